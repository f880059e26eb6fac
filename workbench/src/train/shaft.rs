//! The constants of the core's shaft: torque balance, delay of the current, tracked orders.
//!
//! ```text
//! scales     powers of two that scale ω̇, ω, T, i to rms ≈ 1
//! nominal    mean p over the traces of the nominal class, estimated by the core                              (1)
//! delay      the delay whose torque balance has the least residual on those traces                          (2)
//! slowest    7 % of the reference's rms; r₀ is the same, ω₀ is that rms                                          (3)
//! block      a fiftieth of a segment: 50 estimates of the noise; a block has 2 % of the segment's noise power    (4)
//! ```
//!
//! (2) identifies the delay: a lag τ of the current adds the term τ · dT/dt, which no other term of the balance
//! explains.

use bearing_watch::model::{
    Balance, Channel, MAX_CURRENT_DELAY, Sampling, ShaftConstants, StateVariable, TrackedOrder, Tracking,
};
use bearing_watch::plan::{RunTime, ShaftLayout, Signal};
use bearing_watch::{Friction, FrictionTerm, ShaftEstimate};
use rayon::prelude::*;

use super::core_form::refused;
use super::estimation::successful;
use crate::Error;
use crate::core::{Embedded, MAX_ORDERS, Parts, Wiring};
use crate::grey_box::filter::LowPass;
use crate::trace::labels::LabelledTrace;
use crate::trace::{MotionTrace, Trace};

/// Limits of the channels, in multiples of the largest magnitude in training.
const LIMIT: f64 = 10.0;

/// Plan of the shaft: tracked orders, delay and filter.
#[derive(Clone, Debug, PartialEq)]
pub struct ShaftPlan {
    /// Names and values of the orders, events per turn; none for friction alone.
    pub orders: Vec<(String, f64)>,
    /// Weights of the orders' harmonics; the last ones may be zero.
    pub weights: [f64; 3],
    /// Delay of the current, samples; estimated from the traces if not given.
    pub current_delay: Option<f64>,
    /// Cut-off of the torque balance's filter, Hz.
    pub cutoff_hz: f64,
    /// Whether the load torque is measured.
    pub load: bool,
}

impl ShaftPlan {
    /// Returns a plan with these orders, weights for a noise that grows with frequency, a cut-off of 8 Hz, and a
    /// measured load.
    #[must_use]
    pub fn new(orders: Vec<(String, f64)>) -> Self {
        Self { orders, weights: [1.0, 0.4, 0.2], current_delay: None, cutoff_hz: 8.0, load: true }
    }

    /// Returns the names of the orders.
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

/// Traces with their motion.
type Watched<'a> = (&'a LabelledTrace, &'a MotionTrace);

/// Returns the core's shaft with its trained constants.
///
/// # Errors
/// A plan out of range; traces without the channels of the shaft or with an unknown interval; a shaft that does not
/// move, or whose balance is not excited in the nominal class.
pub(super) fn model(
    traces: &[LabelledTrace],
    (nominal, segment, interval_s): (usize, usize, f64),
    plan: &ShaftPlan,
    wiring: &Wiring,
) -> Result<(ShaftLayout, ShaftConstants<RunTime>), Error> {
    if interval_s <= 0.0 {
        return Err(Error::Training("the shaft needs the sampling interval; give the traces a column t_s".into()));
    }
    plan.check(interval_s)?;
    let watched: Vec<Watched<'_>> = traces.iter().filter_map(|t| Some((t, t.trace.motion.as_ref()?))).collect();
    if watched.len() < traces.len() {
        return Err(Error::Training("a trace lacks the channels of the shaft, but its features are requested".into()));
    }
    let all: Vec<&MotionTrace> = watched.iter().map(|(_, motion)| *motion).collect();
    let own: Vec<Watched<'_>> = watched.into_iter().filter(|(t, _)| t.class == nominal).collect();
    let harmonics = 3 - plan.weights.iter().rev().take_while(|w| **w <= 0.0).count();
    let ([current, velocity, reference], load) =
        wiring.shaft.ok_or_else(|| Error::Training("the channels of the shaft are not wired".into()))?;
    let (orders, harmonics) = (plan.orders.len() as u8, harmonics as u8);
    let layout = ShaftLayout { current, velocity, reference, load, orders, harmonics };
    let mut constants = untrained(&all, segment, interval_s, plan)?;
    let bench = Bench::new(&own, layout, wiring)?;
    constants.current_delay = match plan.current_delay {
        Some(delay) => delay as f32,
        None => bench.best_delay(&constants, &own[..own.len().min(8)])?,
    };
    let balance = |(labelled, _): &Watched<'_>| {
        let estimate = bench.run(&constants, &labelled.trace)?;
        match estimate.friction_reason {
            Some(reason) => Err(Error::trace(&labelled.trace.id, format!("shaft: {reason}"))),
            None => Ok(estimate.friction),
        }
    };
    // Traces whose balance is not excited have no part in the mean unless all are.
    let estimates: Vec<Friction> = successful(own.par_iter().map(balance).collect())?;
    for (term, cell) in FrictionTerm::ALL.into_iter().zip(&mut constants.balance.nominal) {
        let value = |friction: &Friction| f64::from(friction.parameter(term).unwrap_or_default().value);
        let sum: f64 = estimates.iter().map(value).sum();
        *cell = (sum / estimates.len() as f64) as f32; // (1)
    }
    Ok((layout, constants))
}

/// Runs the shaft of the core alone over whole traces.
struct Bench {
    layout: ShaftLayout,
    channels: Vec<Channel>,
}

impl Bench {
    /// Creates a bench in which every signal of the shaft has its own channel.
    fn new(own: &[Watched<'_>], layout: ShaftLayout, wiring: &Wiring) -> Result<Self, Error> {
        let alone = Wiring { channels: vec![], ..wiring.clone() }.of_shaft(wiring);
        let channels = alone.core_channels(own.iter().map(|(t, _)| &t.trace), LIMIT)?;
        let ([current, velocity, reference], load) = alone.shaft.unwrap_or(([Signal::channel(0); 3], None));
        Ok(Self { layout: ShaftLayout { current, velocity, reference, load, ..layout }, channels })
    }

    fn run(&self, constants: &ShaftConstants<RunTime>, trace: &Trace) -> Result<ShaftEstimate<RunTime>, Error> {
        let parts =
            Parts { channels: self.channels.clone(), regression: None, shaft: Some((self.layout, constants.clone())) };
        let samples = trace.y.len() as u32;
        let sampling = Sampling { interval_s: 0.0, park: None, block_mean: 1, segment_samples: samples };
        let model = parts.estimating(sampling).map_err(refused)?;
        let report = Embedded::new(model).map_err(refused)?.whole(trace);
        report.shaft().cloned().ok_or_else(|| Error::trace(&trace.id, "the shaft was not watched"))
    }

    /// Returns the delay (2), to a tenth of a sample.
    fn best_delay(&self, constants: &ShaftConstants<RunTime>, healthy: &[Watched<'_>]) -> Result<f32, Error> {
        let residual = |delay: f32| -> Result<f64, Error> {
            let delayed = ShaftConstants { current_delay: delay, ..constants.clone() };
            let variance = |(labelled, _): &Watched<'_>| {
                let variance = f64::from(self.run(&delayed, &labelled.trace)?.friction.variance);
                Ok(if variance > 0.0 { variance } else { f64::MAX / 1e3 })
            };
            healthy.par_iter().map(variance).sum()
        };
        let delays = (0..=25_u8).map(|k| f32::from(k) / 10.0);
        let tried: Vec<(f32, f64)> = delays.map(|delay| Ok((delay, residual(delay)?))).collect::<Result<_, Error>>()?;
        let best = tried.into_iter().min_by(|one, other| one.1.total_cmp(&other.1));
        Ok(best.map_or(0.0, |(delay, _)| delay))
    }
}

/// Returns constants with scales and rates; nominal parameters and delay are zero.
fn untrained(
    traces: &[&MotionTrace],
    segment: usize,
    interval_s: f64,
    plan: &ShaftPlan,
) -> Result<ShaftConstants<RunTime>, Error> {
    let column = |pick: fn(&MotionTrace) -> &Vec<f64>| traces.iter().flat_map(move |t| pick(t).iter().copied());
    let rms = |pick| (column(pick).map(|x| x * x).sum::<f64>() / column(pick).count().max(1) as f64).sqrt();
    let reference = rms(|t| &t.reference_rad_s);
    if reference <= 0.0 {
        return Err(Error::Training("the velocity reference is zero throughout: the shaft does not move".into()));
    }
    let cutoff = plan.cutoff_hz * interval_s;
    let low_pass = LowPass::butterworth(1, cutoff);
    let slopes: Vec<f64> = traces.iter().flat_map(|t| low_pass.derivative(&t.velocity_rad_s)).collect();
    let squares = slopes.iter().map(|x| x * x).sum::<f64>() / slopes.len().max(1) as f64;
    let acceleration = squares.sqrt() / interval_s;
    let power_of_two = |rms: f64| if rms > 0.0 { (-rms.log2().round()).exp2() as f32 } else { 1.0 };
    let slowest_rad_s = 0.07 * reference; // (3)
    let weights = plan.weights.map(|w| w as f32);
    // The blocks of order k end k samples after those of order 0, so a block is longer than the number of orders.
    let least = plan.orders.len() + 2;
    Ok(ShaftConstants {
        current_delay: 0.0,
        balance: Balance {
            interval_s: interval_s as f32,
            filter: StateVariable::new((std::f64::consts::PI * cutoff).tan() as f32, interval_s as f32),
            row_interval: (1.0 / (8.0 * cutoff)).round().clamp(1.0, 255.0) as u8,
            settle: (1.6 / cutoff).round().clamp(1.0, 60_000.0) as u16,
            sign_velocity_rad_s: slowest_rad_s as f32,
            usual_velocity_rad_s: reference as f32,
            scale: [acceleration, rms(|t| &t.velocity_rad_s), rms(|t| &t.load_nm), rms(|t| &t.current_a)]
                .map(power_of_two),
            nominal: [0.0; 5],
        },
        tracking: Tracking {
            orders: plan.orders.iter().map(|(_, order)| TrackedOrder::new(*order as f32, weights)).collect(),
            slowest_turn: (slowest_rad_s * interval_s / std::f64::consts::TAU * 4_294_967_296.0) as u32,
            block_samples: (segment / 50).clamp(least, 60_000) as u16, // (4)
        },
    })
}
