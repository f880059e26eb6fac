//! The constants of the core's shaft: torque balance, lags, tracked orders.
//!
//! ```text
//! scales     powers of two that scale the columns of the balance and i to rms ≈ 1
//! sign       three standard deviations of the velocity's noise, from its second differences              (1)
//! ```
//!
//! [`ShaftPlan`] has the tracked orders, [`super::lags`] finds the lags, [`super::nominal`] the parameters, and
//! [`super::filters`] the filters of the residual.

use bearing_watch::model::{Lags, MAX_LAG, ShaftConstants, StateVariable, TERMS, TorqueBalance, Tracking};
use bearing_watch::plan::{RunTime, ShaftLayout};

use super::bench::{AlarmState, Bench, OWN_FROM_FEW_ROWS, OWN_FROM_ROWS, layout};
use super::loop_noise::LoopNoise;
use super::nominal::{self, median};
use super::shaft_plan::ShaftPlan;
use super::velocity_source::velocity_noise;
use super::{filters, lags, reference_instruments};
use crate::Error;
use crate::core::Wiring;
use crate::grey_box::filter::LowPass;
use crate::trace::MotionTrace;
use crate::trace::labels::LabelledTrace;
use crate::train::VelocitySource;

/// The prior of a weight, in parts of that of the median trace: payloads differ.
const WIDER: f64 = 3.0;

/// Returns the core's shaft with its trained constants.
///
/// # Errors
/// A plan out of range; traces without the channels of the shaft or with an unknown interval; a shaft that does not
/// move, or whose balance is not excited in the nominal class.
pub(crate) fn model(
    traces: &[LabelledTrace],
    sizes: (usize, f64),
    plan: &ShaftPlan,
    wiring: &Wiring,
) -> Result<(ShaftLayout, ShaftConstants<RunTime>), Error> {
    let trained = with_balance(traces, sizes, plan, wiring, |bench, plan, constants, own| {
        if plan.orders.is_empty() {
            return Ok(Ok((layout(plan, wiring)?, constants)));
        }
        let constants = filters::best(bench, constants, own)?;
        match filters::chosen(bench, plan, &constants, own)? {
            Some(fewer) => Ok(Err(fewer)),
            None => Ok(Ok((layout(plan, wiring)?, constants))),
        }
    })?;
    // Other harmonics have other noise, for which other filters are best: as if they had been given.
    trained.or_else(|fewer| model(traces, sizes, &fewer, wiring))
}

/// Returns the cost of [`filters`] with this plan.
///
/// # Errors
/// Those of [`model`].
pub(crate) fn cost(
    traces: &[LabelledTrace],
    sizes: (usize, f64),
    plan: &ShaftPlan,
    wiring: &Wiring,
) -> Result<f64, Error> {
    with_balance(traces, sizes, plan, wiring, |bench, _, constants, own| filters::cost(bench, &constants, own))
}

/// Learns lags and torque balance of the nominal class, then does `rest`.
fn with_balance<T>(
    traces: &[LabelledTrace],
    (class, interval_s): (usize, f64),
    plan: &ShaftPlan,
    wiring: &Wiring,
    rest: impl FnOnce(&Bench, &ShaftPlan, ShaftConstants<RunTime>, &[AlarmState<'_>]) -> Result<T, Error>,
) -> Result<T, Error> {
    if interval_s <= 0.0 {
        return Err(Error::Training("the shaft needs the sampling interval; give the traces a column t_s".into()));
    }
    plan.check(interval_s)?;
    let recorded = traces.iter().filter_map(|t| t.trace.motion.as_ref());
    let motions: Vec<_> = recorded.map(|motion| plan.velocity.motion(motion, interval_s)).collect();
    if motions.len() < traces.len() {
        return Err(Error::Training("a trace lacks the channels of the shaft, but its features are requested".into()));
    }
    let all: Vec<&MotionTrace> = motions.iter().map(AsRef::as_ref).collect();
    let plan = &plan.decimated(&all, interval_s);
    let own: Vec<AlarmState<'_>> = traces.iter().zip(all.iter().copied()).filter(|(t, _)| t.class == class).collect();
    let recorded_healthy: Vec<&MotionTrace> = own.iter().filter_map(|(t, _)| t.trace.motion.as_ref()).collect();
    let bench = Bench::new(&own, plan, wiring)?;
    let healthy: Vec<&MotionTrace> = own.iter().map(|(_, motion)| *motion).collect();
    let mut constants = untrained(&all, interval_s, plan)?;
    let sign_velocity = f64::from(constants.balance.sign_velocity_rad_s);
    let noise = if plan.load { None } else { LoopNoise::of(&recorded_healthy, interval_s) };
    constants.lags = match plan.current_delay {
        Some(delay) => Lags { current: delay as f32, ..Lags::default() },
        None if plan.load => lags::best(&healthy, (3.0 * plan.cutoff_hz * interval_s).min(0.2), sign_velocity),
        // The controller answers a load that is not measured with current, which looks like a lag of several samples.
        None => Lags { current: noise.map_or(0.0, |own| own.current_lag as f32), ..Lags::default() },
    };
    constants.lags = match (plan.velocity, plan.current_delay) {
        (VelocitySource::Angle, Some(_)) => Lags { velocity: 0.5, ..constants.lags },
        (VelocitySource::Angle, None) if noise.is_some() => Lags { velocity: 0.5, ..constants.lags },
        (VelocitySource::Angle, None) => behind_angle(constants.lags),
        (VelocitySource::Best | VelocitySource::Channel, _) => constants.lags,
    };
    noise.into_iter().for_each(|own| own.hold(&mut constants.balance));
    let trained = bench.frictions(&constants, &own)?;
    nominal::learn(&mut constants.balance, &trained);
    noise.into_iter().for_each(|own| own.hold(&mut constants.balance));
    let weights: Vec<f64> = trained.iter().filter_map(|own| own.weight_a()).map(|(weight, _)| weight.into()).collect();
    if !weights.is_empty() {
        let prior = (WIDER * nominal::median(weights)).max(1e-9) as f32;
        (constants.balance.prior[3], constants.balance.prior[5]) = (prior, prior);
    }
    constants.balance.largest_change_rad = nominal::of(&all, interval_s, constants.balance.nominal[0]);
    // The residual of the orders is then never formed with a segment's own parameters, which the load biases, unless
    // a weight is most of the load.
    let corrected =
        !plan.load && reference_instruments::correct(&mut constants.balance, &healthy, plan.rates(), plan.axis.turns());
    if plan.axis.weighs() {
        constants.balance.adapt_after_rows = OWN_FROM_FEW_ROWS;
    } else if corrected {
        constants.balance.adapt_after_rows = u16::MAX;
    }
    rest(&bench, plan, constants, &own)
}

/// Returns the lags if the velocity is that of the angle over the last sample: half a sample behind it.
fn behind_angle(lags: Lags) -> Lags {
    let more = (0.5 - lags.velocity).max(0.0);
    let Lags { current, velocity, load } = lags;
    let later = |lag: f32| (lag + more).min(MAX_LAG);
    Lags { current: later(current), velocity: later(velocity), load: later(load) }
}

/// Returns constants with scales and rates; the nominal parameters are zero, with wide priors.
pub(super) fn untrained(
    traces: &[&MotionTrace],
    interval_s: f64,
    plan: &ShaftPlan,
) -> Result<ShaftConstants<RunTime>, Error> {
    let column = |pick: fn(&MotionTrace) -> &Vec<f64>| traces.iter().flat_map(move |t| pick(t).iter().copied());
    let rms = |pick| {
        let finite = || column(pick).filter(|x| x.is_finite());
        (finite().map(|x| x * x).sum::<f64>() / finite().count().max(1) as f64).sqrt()
    };
    let velocity = rms(|t| &t.velocity_rad_s);
    if velocity <= 0.0 {
        return Err(Error::Training("the velocity is zero throughout: the shaft does not move".into()));
    }
    let cutoff = plan.cutoff_hz * interval_s;
    let low_pass = LowPass::butterworth(1, cutoff);
    // The filter would not forget a missing sample: it starts anew after each.
    let runs = traces.iter().flat_map(|t| t.velocity_rad_s.split(|x| !x.is_finite()));
    let slopes: Vec<f64> = runs.flat_map(|run| low_pass.derivative(run)).collect();
    let acceleration = (slopes.iter().map(|x| x * x).sum::<f64>() / slopes.len().max(1) as f64).sqrt() / interval_s;
    let power_of_two = |rms: f64| if rms > 0.0 { (-rms.log2().round()).exp2() as f32 } else { 1.0 };
    let current = rms(|t| &t.current_a);
    let load = if plan.axis.weighs() { std::f64::consts::FRAC_1_SQRT_2 } else { rms(|t| &t.load_nm) };
    let columns = [acceleration, velocity, 1.0, load, 1.0, load, 1.0];
    let scale = columns.map(power_of_two);
    let [s0, s1, s2, s3, s4, s5, s6] = scale;
    let sign_velocity = (3.0 * velocity_noise(traces)).max(0.01 * velocity); // (1)
    // From here on by steps.
    let step_s = interval_s * f64::from(plan.decimation);
    let cutoff = plan.cutoff_hz * step_s;
    let row_interval = (1.0 / (8.0 * cutoff)).round().clamp(1.0, 255.0);
    Ok(ShaftConstants {
        lags: Lags::default(),
        balance: TorqueBalance {
            interval_s: step_s as f32,
            filter: StateVariable::new((std::f64::consts::PI * cutoff).tan() as f32, step_s as f32),
            row_interval: row_interval as u8,
            settle: (1.6 / cutoff).round().clamp(1.0, 60_000.0) as u16,
            sign_velocity_rad_s: sign_velocity as f32,
            stribeck_velocity_rad_s: (3.0 * sign_velocity).max(0.1 * velocity) as f32,
            usual_velocity_rad_s: velocity as f32,
            usual_load_nm: if plan.load { load as f32 } else { 0.0 },
            // The noise of a second-order Butterworth filter has 1.11 times its cut-off as bandwidth.
            row_spread: (1.0 / (2.22 * cutoff * row_interval)).max(1.0) as f32,
            scale: [s0, s1, s2, s3, s4, s5, s6, power_of_two(current)],
            nominal: [0.0; TERMS],
            prior: columns.map(|column| if column > 0.0 { (10.0 * current / column) as f32 } else { 1.0 }),
            deviation: (0.1 * current).max(1e-6) as f32,
            adapt_after_rows: OWN_FROM_ROWS,
            largest_change_rad: f32::INFINITY,
        },
        tracking: tracking(traces, plan, sign_velocity),
    })
}

fn tracking(traces: &[&MotionTrace], plan: &ShaftPlan, sign_velocity: f64) -> Tracking<RunTime> {
    plan.tracking(median(traces.iter().map(|trace| trace.turns()).collect()), 1.2 * sign_velocity)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_runs_of_valid_samples_tell_the_acceleration() {
        // A constant velocity for a second, then one that vibrates at 1 Hz.
        let velocity = |k: usize| if k < 500 { 40.0 } else { 40.0 + 20.0 * (0.0126 * k as f64).sin() };
        let of = |missing: &[usize]| {
            let mut velocity_rad_s: Vec<f64> = (0..5000).map(velocity).collect();
            missing.iter().for_each(|&k| velocity_rad_s[k] = f64::NAN);
            let zeros = || vec![0.0; 5000];
            let (load_nm, angle_rad) = (zeros(), zeros());
            let motion =
                MotionTrace { velocity_rad_s, current_a: vec![1.0; 5000], load_nm, angle_rad, reference_rad_s: vec![] };
            let constants = untrained(&[&motion], 0.002, &ShaftPlan::new(vec![])).expect("a shaft that moves");
            (constants.balance.scale[0], constants.balance.prior[0])
        };
        let (whole, part) = (of(&[]), of(&[100, 2000, 2001, 4000]));
        assert_eq!(whole.0, part.0);
        // The filter settles again after three gaps, in some 250 of 5000 samples each.
        assert!((part.1 / whole.1 - 1.0).abs() < 0.15, "{whole:?} {part:?}");
    }
}
