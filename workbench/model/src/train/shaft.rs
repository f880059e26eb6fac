//! The constants of the core's shaft: torque balance, lags, tracked orders.
//!
//! ```text
//! scales     powers of two that scale the columns of the balance and i to rms ≈ 1
//! sign       three standard deviations of the velocity's noise, from its second differences              (1)
//! cell       as wide as the slip allows, but at most a sixteenth of a trace's turns                        (2)
//! controls   orders far from all integers and from all harmonics of the tracked orders                 (3)
//! ```
//!
//! [`super::lags`] finds the lags, [`super::nominal`] the parameters, and [`super::filters`] the filters of the
//! residual.

use bearing_watch::model::{
    Balance, Blocks, CONTROLS, Channel, Lags, MAX_LAG, Sampling, ShaftConstants, StateVariable, TERMS, TrackedOrder,
    Tracking, q16,
};
use bearing_watch::plan::{RunTime, ShaftLayout};
use bearing_watch::{Friction, ShaftEstimate};
use rayon::prelude::*;

use super::core_form::refused;
use super::estimation::successful;
use super::nominal::median;
use super::{VelocitySource, fewer_harmonics, filters, lags, nominal, reference_instruments};
use crate::Error;
use crate::core::{Embedded, MAX_ORDERS, Measured, Parts, ShaftSignals, Wiring};
use crate::grey_box::filter::LowPass;
use crate::trace::labels::LabelledTrace;
use crate::trace::{MotionTrace, Trace};

/// Blocks in a record, at least.
pub(super) const BLOCKS_A_RECORD: f64 = 16.0;

/// Limits of the channels, in multiples of the largest magnitude in training.
const LIMIT: f64 = 10.0;

/// Rows from which a segment's own parameters are compared with the nominal ones.
pub(super) const OWN_FROM_ROWS: u16 = 48;

/// Binary logarithms of the narrowest and the widest cell, turns.
pub(super) const CELLS_LOG2: [i8; 2] = [-6, 6];

/// Returns the binary logarithm of the widest cell (2) for these orders, the slip, and the turns of a record.
pub(super) fn cell_turns_log2(orders: impl Iterator<Item = f64>, slip: f64, turns: f64) -> i8 {
    let highest = orders.fold(0.1, f64::max);
    let [narrowest, most] = CELLS_LOG2.map(f64::from);
    let widest = (0.5 / (highest * slip.max(1e-4))).min(turns / BLOCKS_A_RECORD);
    widest.log2().floor().clamp(narrowest, most) as i8
}

/// Plan of the shaft: tracked orders, delay and filter.
#[derive(Clone, Debug, PartialEq)]
pub struct ShaftPlan {
    /// Names and values of the orders, events per turn; none for friction alone.
    pub orders: Vec<(String, f64)>,
    /// Weights of the orders' harmonics; the last ones may be zero.
    pub weights: [f64; 3],
    /// Whether training may leave higher harmonics out.
    pub fewer_harmonics: bool,
    /// Largest relative slip of the cage that is searched.
    pub slip: f64,
    /// Lag of the current, samples; estimated from the traces if not given.
    pub current_delay: Option<f64>,
    /// Cut-off of the torque balance's filter, Hz.
    pub cutoff_hz: f64,
    /// Whether the load torque is measured.
    pub load: bool,
    /// Where the velocity comes from.
    pub velocity: VelocitySource,
}

impl ShaftPlan {
    /// Returns a plan with these orders, weights for pulses of a tenth to half of a period, a slip of ± 0.8 %, a
    /// cut-off of 4 Hz, a measured load, and the better source of the velocity.
    #[must_use]
    pub fn new(orders: Vec<(String, f64)>) -> Self {
        Self {
            orders,
            weights: [1.0, 0.5, 0.25],
            fewer_harmonics: true,
            slip: 0.008,
            current_delay: None,
            cutoff_hz: 4.0,
            load: true,
            velocity: VelocitySource::Best,
        }
    }

    /// Returns which signals have a channel; before the choice of its source, the velocity has one.
    pub(super) fn measured(&self) -> Measured {
        Measured { velocity: self.velocity != VelocitySource::Angle, load: self.load }
    }

    /// Returns the names of the orders.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.orders.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Returns the orders, cells (2) and control orders (3) for records of this number of turns. The filters are those
    /// before training.
    #[must_use]
    pub fn tracking(&self, turns: f64, slowest_rad_s: f64) -> Tracking<RunTime> {
        let named = |name: &str| self.orders.iter().find(|(own, _)| own == name).map(|(_, order)| *order);
        let ratio = |name: &str| match (name, named("outer"), named("inner")) {
            ("inner", Some(outer), Some(inner)) => -outer / inner,
            _ => 1.0,
        };
        let weights = self.weights.map(|w| w as f32);
        let order = |(name, order): &(String, f64)| TrackedOrder {
            slip_ratio: ratio(name) as f32,
            ..TrackedOrder::new(*order as f32, weights)
        };
        Tracking {
            orders: self.orders.iter().map(order).collect(),
            blocks: Blocks {
                controls: controls(&self.orders, self.slip, harmonics(&self.weights)).map(|order| q16(order as f32)),
                cell_turns_log2: cell_turns_log2(self.orders.iter().map(|(_, order)| *order), self.slip, turns),
                slip: self.slip as f32,
                slowest_rad_s: slowest_rad_s as f32,
                pole: 0.9,
                high_pass: 0.0,
            },
        }
    }

    /// Returns the orders and control orders (3) of this plan in the cells of another one.
    pub(super) fn with_cells_of(&self, other: &Blocks) -> Tracking<RunTime> {
        let own = self.tracking(1.0, 0.0);
        Tracking { blocks: Blocks { controls: own.blocks.controls, ..*other }, ..own }
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
        if self.current_delay.is_some_and(|delay| !(0.0..=f64::from(MAX_LAG)).contains(&delay)) {
            return refuse(format!("--current-delay is 0 to {MAX_LAG} samples"));
        }
        if !(0.0..=0.1).contains(&self.slip) {
            return refuse(format!("--slip is {}; it is 0 to 0.1, for example 0.008 for 0.8 %", self.slip));
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

/// Traces with their motion.
pub(super) type Watched<'a> = (&'a LabelledTrace, &'a MotionTrace);

/// Returns the core's shaft with its trained constants.
///
/// # Errors
/// A plan out of range; traces without the channels of the shaft or with an unknown interval; a shaft that does not
/// move, or whose balance is not excited in the nominal class.
pub(super) fn model(
    traces: &[LabelledTrace],
    sizes: (usize, f64),
    plan: &ShaftPlan,
    wiring: &Wiring,
) -> Result<(ShaftLayout, ShaftConstants<RunTime>), Error> {
    with_balance(traces, sizes, plan, wiring, |bench, constants, own| {
        if plan.orders.is_empty() {
            return Ok((layout(plan, wiring)?, constants));
        }
        let constants = filters::best(bench, constants, own)?;
        // Other harmonics have other noise, for which other filters are best.
        Ok(match fewer_harmonics::chosen(bench, plan, &constants, own)? {
            Some((fewer, constants)) => (layout(&fewer, wiring)?, filters::best(bench, constants, own)?),
            None => (layout(plan, wiring)?, constants),
        })
    })
}

/// Returns the cost of [`filters`] with this plan.
///
/// # Errors
/// Those of [`model`].
pub(super) fn cost(
    traces: &[LabelledTrace],
    sizes: (usize, f64),
    plan: &ShaftPlan,
    wiring: &Wiring,
) -> Result<f64, Error> {
    with_balance(traces, sizes, plan, wiring, |bench, constants, own| filters::cost(bench, &constants, own))
}

/// Learns lags and torque balance of the nominal class, then does `rest`.
fn with_balance<T>(
    traces: &[LabelledTrace],
    (class, interval_s): (usize, f64),
    plan: &ShaftPlan,
    wiring: &Wiring,
    rest: impl FnOnce(&Bench, ShaftConstants<RunTime>, &[Watched<'_>]) -> Result<T, Error>,
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
    let own: Vec<Watched<'_>> = traces.iter().zip(all.iter().copied()).filter(|(t, _)| t.class == class).collect();
    let bench = Bench::new(&own, plan, wiring)?;
    let healthy: Vec<&MotionTrace> = own.iter().map(|(_, motion)| *motion).collect();
    let mut constants = untrained(&all, interval_s, plan)?;
    let sign_velocity = f64::from(constants.balance.sign_velocity_rad_s);
    constants.lags = match plan.current_delay {
        Some(delay) => Lags { current: delay as f32, ..Lags::default() },
        None if plan.load => lags::best(&healthy, (3.0 * plan.cutoff_hz * interval_s).min(0.2), sign_velocity),
        // The controller answers a load that is not measured with current, which looks like a lag of several samples.
        None => Lags::default(),
    };
    constants.lags = match (plan.velocity, plan.current_delay) {
        (VelocitySource::Angle, Some(_)) => Lags { velocity: 0.5, ..constants.lags },
        (VelocitySource::Angle, None) => behind_angle(constants.lags),
        (VelocitySource::Best | VelocitySource::Channel, _) => constants.lags,
    };
    let trained = bench.frictions(&constants, &own)?;
    nominal::learn(&mut constants.balance, &trained);
    // The residual of the orders is then never formed with a segment's own parameters, which the load biases.
    if !plan.load && reference_instruments::correct(&mut constants.balance, &healthy, plan.cutoff_hz) {
        constants.balance.own_from_rows = u16::MAX;
    }
    rest(&bench, constants, &own)
}

/// Returns the lags if the velocity is that of the angle over the last sample: half a sample behind it.
fn behind_angle(lags: Lags) -> Lags {
    let more = (0.5 - lags.velocity).max(0.0);
    let Lags { current, velocity, load } = lags;
    let later = |lag: f32| (lag + more).min(MAX_LAG);
    Lags { current: later(current), velocity: later(velocity), load: later(load) }
}

/// Returns the shaft of this plan on the channels of a wiring.
fn layout(plan: &ShaftPlan, wiring: &Wiring) -> Result<ShaftLayout, Error> {
    let missing = || Error::Training("the channels of the shaft are not wired".into());
    let ShaftSignals { current, velocity, load } = wiring.shaft.ok_or_else(missing)?;
    let (orders, harmonics) = (plan.orders.len() as u8, harmonics(&plan.weights));
    Ok(ShaftLayout { current, velocity, load, orders, harmonics })
}

/// Number of harmonics with a weight.
pub(super) fn harmonics(weights: &[f64; 3]) -> u8 {
    3 - weights.iter().rev().take_while(|w| **w <= 0.0).count() as u8
}

/// Runs the shaft of the core alone over whole traces.
pub(super) struct Bench {
    layout: ShaftLayout,
    channels: Vec<Channel>,
}

impl Bench {
    /// Creates a bench in which every signal of the shaft has its own channel.
    fn new(own: &[Watched<'_>], plan: &ShaftPlan, wiring: &Wiring) -> Result<Self, Error> {
        let alone = Wiring { channels: vec![], ..wiring.clone() }.of_shaft(wiring);
        let channels = alone.core_channels(own.iter().map(|(t, _)| &t.trace), LIMIT)?;
        Ok(Self { layout: layout(plan, &alone)?, channels })
    }

    pub(super) fn run(
        &self,
        constants: &ShaftConstants<RunTime>,
        trace: &Trace,
    ) -> Result<ShaftEstimate<RunTime>, Error> {
        let parts = Parts {
            channels: self.channels.clone(),
            regression: None,
            shaft: Some((self.layout, constants.clone())),
            averaged: 0,
        };
        let samples = trace.y.len() as u32;
        let sampling = Sampling { interval_s: 0.0, park: None, block_mean: 1, segment_samples: samples };
        let model = parts.estimating(sampling).map_err(refused)?;
        let report = Embedded::new(model).map_err(refused)?.whole(trace);
        report.shaft().cloned().ok_or_else(|| Error::trace(&trace.id, "the shaft was not watched"))
    }

    /// Returns the estimates of all traces.
    pub(super) fn run_all(
        &self,
        constants: &ShaftConstants<RunTime>,
        own: &[Watched<'_>],
    ) -> Result<Vec<ShaftEstimate<RunTime>>, Error> {
        own.par_iter().map(|(labelled, _)| self.run(constants, &labelled.trace)).collect()
    }

    /// Returns the torque balances of all traces that have one.
    ///
    /// # Errors
    /// No trace has a torque balance.
    fn frictions(&self, constants: &ShaftConstants<RunTime>, own: &[Watched<'_>]) -> Result<Vec<Friction>, Error> {
        let balance = |(labelled, _): &Watched<'_>| {
            let id = &labelled.trace.id;
            let ShaftEstimate { friction, friction_reason, .. } = self.run(constants, &labelled.trace)?;
            let refuse = |reason| format!("shaft: {reason}; no trace of the nominal class has a torque balance");
            friction_reason.map_or(Ok(friction), |reason| Err(Error::trace(id, refuse(reason))))
        };
        successful(own.par_iter().map(balance).collect())
    }
}

/// Returns constants with scales and rates; the nominal parameters are zero, with wide priors.
fn untrained(traces: &[&MotionTrace], interval_s: f64, plan: &ShaftPlan) -> Result<ShaftConstants<RunTime>, Error> {
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
    let slopes: Vec<f64> = traces.iter().flat_map(|t| low_pass.derivative(&t.velocity_rad_s)).collect();
    let finite = || slopes.iter().filter(|x| x.is_finite());
    let acceleration = (finite().map(|x| x * x).sum::<f64>() / finite().count().max(1) as f64).sqrt() / interval_s;
    let power_of_two = |rms: f64| if rms > 0.0 { (-rms.log2().round()).exp2() as f32 } else { 1.0 };
    let (load, current) = (rms(|t| &t.load_nm), rms(|t| &t.current_a));
    let columns = [acceleration, velocity, 1.0, load, 1.0, load, 1.0];
    let scale = columns.map(power_of_two);
    let [s0, s1, s2, s3, s4, s5, s6] = scale;
    let sign_velocity = (3.0 * velocity_noise(traces)).max(0.01 * velocity); // (1)
    let row_interval = (1.0 / (8.0 * cutoff)).round().clamp(1.0, 255.0);
    Ok(ShaftConstants {
        lags: Lags::default(),
        balance: Balance {
            interval_s: interval_s as f32,
            filter: StateVariable::new((std::f64::consts::PI * cutoff).tan() as f32, interval_s as f32),
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
            own_from_rows: OWN_FROM_ROWS,
        },
        tracking: tracking(traces, plan, sign_velocity),
    })
}

/// Standard deviation of the velocity's white noise: second differences of white noise have six times its variance.
pub(super) fn velocity_noise(traces: &[&MotionTrace]) -> f64 {
    let second = |t: &&MotionTrace| {
        let differences = t.velocity_rad_s.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs());
        median(differences.filter(|x| x.is_finite()).collect())
    };
    1.483 * median(traces.iter().map(second).collect()) / 6.0_f64.sqrt()
}

fn tracking(traces: &[&MotionTrace], plan: &ShaftPlan, sign_velocity: f64) -> Tracking<RunTime> {
    plan.tracking(median(traces.iter().map(|trace| trace.turns()).collect()), 1.2 * sign_velocity)
}

/// Control orders (3), spread evenly in the logarithm over the harmonics of the tracked orders.
fn controls(orders: &[(String, f64)], slip: f64, harmonics: u8) -> [f64; CONTROLS] {
    let lines: Vec<f64> =
        orders.iter().flat_map(|(_, order)| (1..=harmonics).map(move |h| order * f64::from(h))).collect();
    let lowest = 0.66 * lines.iter().copied().fold(1000.0, f64::min).max(1.0);
    // Four half orders, at least: orders near those of the rotor have its lines.
    let highest = (1.04 * lines.iter().copied().fold(1.0, f64::max)).max(2.2 * lowest);
    let clear = |order: f64| {
        let integer = (order - order.round()).abs();
        lines.iter().map(|line| (line - order).abs() - slip * line).fold(integer, f64::min)
    };
    std::array::from_fn(|k| {
        let even = lowest * (highest / lowest).powf(k as f64 / (CONTROLS - 1) as f64);
        let near = (-12..=12).map(|percent| even * (1.0 + 0.01 * f64::from(percent)));
        near.max_by(|one, other| clear(*one).total_cmp(&clear(*other))).unwrap_or(even)
    })
}
