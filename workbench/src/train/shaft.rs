//! The constants of the core's shaft: torque balance, delay of the current, tracked orders.
//!
//! ```text
//! scales     powers of two that bring ω̇, ω, T, i to rms ≈ 1
//! nominal    mean p over the traces of the nominal class, estimated by the core itself                       (1)
//! delay      the one whose torque balance leaves the least residual on those traces                         (2)
//! still      7 % of the reference's rms, and r₀ likewise; ω₀ that rms                                         (3)
//! block      a fiftieth of a segment: 50 noise estimates, 2 % as much noise as in the whole                  (4)
//! ```
//!
//! (2) works since a lag τ of the current leaves τ times the rate of the load, which nothing else in the balance can explain.

use bearing_watch::estimate::{
    Balance, MAX_CURRENT_DELAY, ShaftEstimate, StateVariable, TrackedOrder, Tracking, Watch,
};
use bearing_watch::{Guard, Shaft, ShaftModel};
use rayon::prelude::*;

use crate::Error;
use crate::core::MAX_ORDERS;
use crate::grey_box::filter::LowPass;
use crate::trace::MotionTrace;
use crate::trace::labels::LabelledTrace;

/// What is watched of the shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct ShaftPlan {
    /// Names and values of the orders, events a turn; none for friction alone.
    pub orders: Vec<(String, f64)>,
    /// Weights of their harmonics; those at the end may be zero.
    pub weights: [f64; 3],
    /// Samples by which the current lags; found from the traces where not given.
    pub current_delay: Option<f64>,
    /// Cut-off of the torque balance's filter.
    pub cutoff_hz: f64,
    /// Whether the load torque is measured.
    pub load: bool,
}

impl ShaftPlan {
    /// These orders, with the weights that suit a noise growing with frequency, a cut-off of 8 Hz, and a measured load.
    #[must_use]
    pub fn new(orders: Vec<(String, f64)>) -> Self {
        Self { orders, weights: [1.0, 0.4, 0.2], current_delay: None, cutoff_hz: 8.0, load: true }
    }

    /// Names of the orders.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.orders.iter().map(|(name, _)| name.clone()).collect()
    }

    fn check(&self, interval_s: f64) -> Result<(), Error> {
        let refuse = |problem: String| Err(Error::Usage(problem));
        if self.orders.len() > MAX_ORDERS {
            return refuse(format!("{} bearing orders are more than {MAX_ORDERS}", self.orders.len()));
        }
        if let Some((name, order)) = self.orders.iter().find(|(_, order)| !(0.01..=1000.0).contains(order)) {
            return refuse(format!("bearing order {name} is {order}; it counts events a turn, from 0.01 to 1000"));
        }
        if let Some((name, _)) = self
            .orders
            .iter()
            .enumerate()
            .find_map(|(k, own)| self.orders[..k].iter().any(|(name, _)| *name == own.0).then_some(own))
        {
            return refuse(format!("bearing order {name} is given twice"));
        }
        if !(self.weights[0] > 0.0 && self.weights.iter().all(|w| (0.0..=1000.0).contains(w))) {
            return refuse("weights of the harmonics are not negative, the first above zero".into());
        }
        if self.current_delay.is_some_and(|delay| !(0.0..=f64::from(MAX_CURRENT_DELAY)).contains(&delay)) {
            return refuse(format!("--current-delay is 0 to {MAX_CURRENT_DELAY} samples"));
        }
        if !(self.cutoff_hz > 0.0 && self.cutoff_hz * interval_s < 0.25) {
            let most = 0.25 / interval_s;
            return refuse(format!(
                "the torque balance's cut-off is above 0 and below {most} Hz, a quarter of the rate"
            ));
        }
        Ok(())
    }
}

/// The shaft's constants from training traces.
///
/// # Errors
/// A plan out of range; traces without the shaft's channels or of unknown interval; a shaft that stands still, or whose balance is
/// not excited in the nominal class.
pub(super) fn model(
    traces: &[LabelledTrace],
    (nominal, segment, interval_s): (usize, usize, f64),
    plan: &ShaftPlan,
) -> Result<ShaftModel<MAX_ORDERS>, Error> {
    if interval_s <= 0.0 {
        return Err(Error::Training("the shaft needs the sampling interval; give the traces a column t_s".into()));
    }
    plan.check(interval_s)?;
    let watched: Vec<(&LabelledTrace, &MotionTrace)> =
        traces.iter().filter_map(|t| Some((t, t.trace.motion.as_ref()?))).collect();
    if watched.len() < traces.len() {
        return Err(Error::Training("a trace has no channels of the shaft, but its features are asked for".into()));
    }
    let all: Vec<&MotionTrace> = watched.iter().map(|(_, motion)| *motion).collect();
    let own: Vec<_> = watched.into_iter().filter(|(t, _)| t.class == nominal).collect();
    let mut model = untrained(&all, segment, interval_s, plan)?;
    model.current_delay = match plan.current_delay {
        Some(delay) => delay as f32,
        None => best_delay(&model, &own[..own.len().min(8)]),
    };
    let balance = |(labelled, motion): &(&LabelledTrace, &MotionTrace)| {
        let estimate = run(&model, motion);
        match estimate.reason {
            Some(reason) => Err(Error::trace(&labelled.trace.id, format!("shaft: {reason}"))),
            None => Ok(estimate),
        }
    };
    let estimates: Vec<ShaftEstimate<MAX_ORDERS>> = own.par_iter().map(balance).collect::<Result<_, _>>()?;
    for (k, cell) in model.balance.nominal.iter_mut().enumerate() {
        let sum: f64 = estimates.iter().map(|e| f64::from(e.friction.parameters[k])).sum();
        *cell = (sum / estimates.len() as f64) as f32; // (1)
    }
    Ok(model)
}

/// (2), to a tenth of a sample.
fn best_delay(model: &ShaftModel<MAX_ORDERS>, healthy: &[(&LabelledTrace, &MotionTrace)]) -> f32 {
    let residual = |delay: f32| -> f64 {
        let model = ShaftModel { current_delay: delay, ..*model };
        let variance = |(_, motion): &(&LabelledTrace, &MotionTrace)| f64::from(run(&model, motion).friction.variance);
        healthy.par_iter().map(variance).map(|v| if v > 0.0 { v } else { f64::MAX / 1e3 }).sum()
    };
    let delays = (0..=25_u8).map(|k| f32::from(k) / 10.0);
    let best = delays.map(|delay| (delay, residual(delay))).min_by(|one, other| one.1.total_cmp(&other.1));
    best.map_or(0.0, |(delay, _)| delay)
}

/// What the core says of a whole trace.
fn run(model: &ShaftModel<MAX_ORDERS>, motion: &MotionTrace) -> ShaftEstimate<MAX_ORDERS> {
    let mut shaft = Shaft::new(Some(model));
    (0..motion.angle_rad.len()).for_each(|k| shaft.step(Some(model), &motion.at(k)));
    shaft.sums().map_or_else(|| ShaftEstimate::empty(bearing_watch::Reason::TooFewRows), |sums| model.conclude(&sums))
}

/// Scales, limits and rates; nominal parameters and delay are zero.
fn untrained(
    traces: &[&MotionTrace],
    segment: usize,
    interval_s: f64,
    plan: &ShaftPlan,
) -> Result<ShaftModel<MAX_ORDERS>, Error> {
    let column = |pick: fn(&MotionTrace) -> &Vec<f64>| traces.iter().flat_map(move |t| pick(t).iter().copied());
    let largest = |pick| column(pick).fold(0.0_f64, |most, x| most.max(x.abs()));
    let rms = |pick| (column(pick).map(|x| x * x).sum::<f64>() / column(pick).count().max(1) as f64).sqrt();
    let reference = rms(|t| &t.reference_rad_s);
    if reference <= 0.0 {
        return Err(Error::Training("the velocity reference is zero throughout: nothing moves the shaft".into()));
    }
    let cutoff = plan.cutoff_hz * interval_s;
    let low_pass = LowPass::butterworth(1, cutoff);
    let slopes: Vec<f64> = traces.iter().flat_map(|t| low_pass.derivative(&t.velocity_rad_s)).collect();
    let squares = slopes.iter().map(|x| x * x).sum::<f64>() / slopes.len().max(1) as f64;
    let acceleration = squares.sqrt() / interval_s;
    let power_of_two = |rms: f64| if rms > 0.0 { (-rms.log2().round()).exp2() as f32 } else { 1.0 };
    let still_rad_s = 0.07 * reference; // (3)
    let velocity = largest(|t| &t.velocity_rad_s).max(largest(|t| &t.reference_rad_s));
    let limit = [largest(|t| &t.current_a), velocity, largest(|t| &t.load_nm).max(1e-3)].map(|x| (10.0 * x) as f32);
    let harmonics = 3 - plan.weights.iter().rev().take_while(|w| **w <= 0.0).count();
    let mut orders = [TrackedOrder::NONE; MAX_ORDERS];
    for (cell, (_, order)) in orders.iter_mut().zip(&plan.orders) {
        *cell = TrackedOrder::new(*order as f32, plan.weights.map(|w| w as f32));
    }
    Ok(ShaftModel {
        guard: Guard::within(limit),
        current_delay: 0.0,
        balance: Balance {
            interval_s: interval_s as f32,
            filter: StateVariable::new((std::f64::consts::PI * cutoff).tan() as f32, interval_s as f32),
            row_interval: (1.0 / (8.0 * cutoff)).round().clamp(1.0, 255.0) as u8,
            settle: (1.6 / cutoff).round().clamp(1.0, 60_000.0) as u16,
            sign_velocity_rad_s: still_rad_s as f32,
            usual_velocity_rad_s: reference as f32,
            load: plan.load,
            scale: [acceleration, rms(|t| &t.velocity_rad_s), rms(|t| &t.load_nm), rms(|t| &t.current_a)]
                .map(power_of_two),
            nominal: [0.0; 5],
        },
        tracking: Tracking {
            orders,
            count: plan.orders.len() as u8,
            harmonics: harmonics as u8,
            still: (still_rad_s * interval_s / std::f64::consts::TAU * 4_294_967_296.0) as u32,
            block_samples: (segment / 50).clamp(2, 60_000) as u16, // (4)
        },
    })
}
