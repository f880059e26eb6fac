//! Plan of the shaft: tracked orders, their cells and control orders, delay and filter.
//!
//! ```text
//! cell       as wide as the slip allows, but at most a sixteenth of a trace's turns                        (1)
//! controls   orders far from all integers and from all harmonics of the tracked orders                 (2)
//! steps      each second sample if h O |ω|/2π of the highest harmonic is at most 0.22 of the rate, with the |ω|
//!            that 99 % of the samples do not exceed                                                    (3)
//! ```
//!
//! Bearing orders that cannot be told from what turns with the rotor.
//!
//! ```text
//! L = 2ⁿ ≤ min(0.5/(O_max s), turns/16, 64)                                        (4)
//! |O − n| ≤ O |q| s + 1/(7 L)                                                      (5)
//! ```
//!
//! Cogging, unbalance and errors of the angle are at whole orders n. The core compares phases of blocks of L turns up
//! to six blocks apart, which tells orders apart that differ by 1/(7 L), and searches slips up to s, by which an order
//! O changes by O q s. The highest order limits L, since its phase must not turn by more than half a turn in a block.

use std::f64::consts::TAU;

use bearing_watch::model::{Blocks, CONTROLS, LAGS, MAX_LAG, TrackedOrder, Tracking, q16};
use bearing_watch::plan::RunTime;

use super::axis::Axis;
use super::filtered::Rates;
use crate::Error;
use crate::core::{MAX_ORDERS, Measured};
use crate::trace::MotionTrace;
use crate::train::VelocitySource;

/// The part of the samples that are slower than the velocity of (3).
const FAST: f64 = 0.99;
/// The limit of (3): the half-band filter passes 0.64 of a sine of this frequency, in parts of the rate.
const HALVED_TO: f64 = 0.22;
/// Highest cut-off of the torque balance, in parts of the rate: a step is then at most a tenth of its period.
const CUTOFF_TO: f64 = 0.05;
/// Blocks in a record, at least.
pub(crate) const BLOCKS_A_RECORD: f64 = 16.0;
/// Binary logarithms of the narrowest and the widest cell, turns.
pub(crate) const CELLS_LOG2: [i8; 2] = [-6, 6];

/// Returns the binary logarithm of the widest cell (1) for these orders, the slip, and the turns of a record.
pub(crate) fn cell_turns_log2(orders: impl Iterator<Item = f64>, slip: f64, turns: f64) -> i8 {
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
    /// The axis behind the motor.
    pub axis: Axis,
    /// Where the velocity comes from.
    pub velocity: VelocitySource,
    /// Samples from step to step of balance and orders, 1 or 2; training chooses it.
    pub decimation: u8,
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
            axis: Axis::Find,
            velocity: VelocitySource::Best,
            decimation: 1,
        }
    }

    /// Returns the plan with a step at each second sample if the highest harmonic passes the half-band filter (3).
    pub(crate) fn decimated(&self, traces: &[&MotionTrace], interval_s: f64) -> Self {
        let highest = self.orders.iter().map(|(_, order)| *order).fold(0.0, f64::max);
        let speeds = traces.iter().flat_map(|trace| trace.velocity_rad_s.iter().map(|w| w.abs()));
        let mut speeds: Vec<f64> = speeds.filter(|w| w.is_finite()).collect();
        let place = (FAST * speeds.len().saturating_sub(1) as f64) as usize;
        let fast = (!speeds.is_empty()).then(|| *speeds.select_nth_unstable_by(place, f64::total_cmp).1);
        let of_harmonic = highest * f64::from(harmonics(&self.weights)) * fast.unwrap_or(0.0) * interval_s / TAU;
        let slow = of_harmonic <= HALVED_TO && self.cutoff_hz * interval_s <= CUTOFF_TO;
        Self { decimation: if slow { 2 } else { 1 }, ..self.clone() }
    }

    /// Returns the cut-off of the balance, Hz, and samples a step.
    pub(crate) fn rates(&self) -> Rates {
        (self.cutoff_hz, self.decimation)
    }

    /// Returns which signals have a channel; before the choice of its source, the velocity has one.
    pub(crate) fn measured(&self) -> Measured {
        Measured { velocity: self.velocity != VelocitySource::Angle, load: self.load }
    }

    /// Returns the names of the orders.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.orders.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Returns the orders, cells (1) and control orders (2) for records of this number of turns. The filters are those
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
                // Of one corner, whatever a step is.
                pole: 0.9_f32.powi(self.decimation.into()),
                high_pass: 0.0,
            },
        }
    }

    /// Returns the orders and control orders (2) of this plan in the cells of another one.
    pub(crate) fn with_cells_of(&self, other: &Blocks) -> Tracking<RunTime> {
        let own = self.tracking(1.0, 0.0);
        Tracking { blocks: Blocks { controls: own.blocks.controls, ..*other }, ..own }
    }

    pub(crate) fn check(&self, interval_s: f64) -> Result<(), Error> {
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
        if let Some(turns) = self.axis.turns().filter(|turns| !(1.0..=1e6).contains(turns)) {
            return refuse(format!("--gear-ratio is {turns}; it is turns of the motor for one of the axis, 1 to 1e6"));
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

/// Number of harmonics with a weight.
pub(crate) fn harmonics(weights: &[f64; 3]) -> u8 {
    3 - weights.iter().rev().take_while(|w| **w <= 0.0).count() as u8
}

/// Control orders (2), spread evenly in the logarithm over the harmonics of the tracked orders.
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

/// Blocks over which phases are compared.
const COMPARED: f64 = LAGS as f64 + 1.0;

/// An order next to one of the rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextToRotor {
    /// Place of the bearing order.
    pub place: usize,
    /// O, in events a turn.
    pub order: f64,
    /// n of (5).
    pub rotor: f64,
    /// What tells them apart.
    pub remedy: Remedy,
}

/// What tells an order from one of the rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remedy {
    /// Records of so many turns.
    Turns(f64),
    /// A search over slips up to `slip` only, and records of so many turns.
    Slip {
        /// Largest slip.
        slip: f64,
        /// Turns of a record.
        turns: f64,
    },
    /// No record: the longest blocks do not resolve the difference.
    None,
}

/// Returns 7 L of (5), the turns over which phases are compared.
#[must_use]
pub fn compared_turns(tracking: &Tracking<RunTime>) -> f64 {
    compared(tracking.blocks.cell_turns_log2)
}

fn compared(log2: i8) -> f64 {
    COMPARED * f64::from(log2).exp2()
}

/// Returns the orders for which (5) holds.
#[must_use]
pub fn next_to_rotor(tracking: &Tracking<RunTime>) -> Vec<NextToRotor> {
    let searched = f64::from(tracking.blocks.slip);
    let orders = || tracking.orders.iter().map(|own| f64::from(own.order()));
    let each = |(place, own): (usize, &TrackedOrder)| {
        let order = f64::from(own.order());
        let rotor = order.round().max(1.0);
        let apart = |slip: f64| (order - rotor).abs() - order * f64::from(own.slip_ratio.abs()) * slip;
        // Turns of a record whose blocks resolve the difference at this slip.
        let needed = |slip: f64| {
            let longest = cell_turns_log2(orders(), slip, f64::INFINITY);
            let mut enough = (CELLS_LOG2[0]..=longest).filter(|log2| apart(slip) * compared(*log2) > 1.0);
            enough.next().map(|log2| BLOCKS_A_RECORD * f64::from(log2).exp2())
        };
        let remedy = || match needed(searched) {
            Some(turns) => Remedy::Turns(turns),
            None => smaller(searched, &needed),
        };
        let hidden = apart(searched) * compared_turns(tracking) <= 1.0;
        hidden.then(|| NextToRotor { place, order, rotor, remedy: remedy() })
    };
    tracking.orders.iter().enumerate().filter_map(each).collect()
}

/// Returns the largest slip, in tenths of the searched one, at which a record is long enough.
fn smaller(searched: f64, needed: &dyn Fn(f64) -> Option<f64>) -> Remedy {
    let mut slips = (0..10).rev().map(|tenths| searched * f64::from(tenths) / 10.0);
    let found = slips.find_map(|slip| needed(slip).map(|turns| Remedy::Slip { slip, turns }));
    found.unwrap_or(Remedy::None)
}

#[cfg(test)]
mod tests {
    use crate::train::ShaftPlan;

    use super::*;

    /// Constant at this velocity but for a twentieth of the samples, with a value that is missing.
    fn trace(velocity_rad_s: f64, otherwise: f64) -> MotionTrace {
        let mut velocity: Vec<f64> = (0..1000).map(|k| if k % 20 == 0 { -otherwise } else { velocity_rad_s }).collect();
        velocity[3] = f64::NAN;
        MotionTrace { velocity_rad_s: velocity, ..MotionTrace::default() }
    }

    #[test]
    fn each_second_sample_is_taken_where_the_highest_harmonic_is_slow() {
        // The third harmonic of order 4 at 500 Hz: 0.22 of the rate is 110 Hz, at 57.6 rad/s.
        let plan = ShaftPlan::new(vec![("outer".into(), 2.0), ("inner".into(), 4.0)]);
        let chosen = |plan: &ShaftPlan, trace: &MotionTrace| plan.decimated(&[trace], 0.002).decimation;
        assert_eq!([57.0, 58.0].map(|w| chosen(&plan, &trace(w, 0.0))), [2, 1]);
        assert_eq!([57.0, 58.0].map(|w| chosen(&plan, &trace(10.0, w))), [2, 1], "a twentieth of the samples counts");
        let first = ShaftPlan { weights: [1.0, 0.0, 0.0], ..plan.clone() };
        assert_eq!([172.0, 174.0].map(|w| chosen(&first, &trace(w, 0.0))), [2, 1]);
        // A twentieth of the rate is 25 Hz.
        assert_eq!(
            [24.9, 25.1].map(|cutoff_hz| chosen(&ShaftPlan { cutoff_hz, ..plan.clone() }, &trace(1.0, 0.0))),
            [2, 1]
        );
        let friction = ShaftPlan::new(vec![]);
        assert_eq!(chosen(&friction, &trace(300.0, 0.0)), 2, "friction alone is slow");
        assert_eq!(friction.decimated(&[], 0.002).decimation, 2, "no trace: training refuses it elsewhere");
    }

    #[test]
    fn an_order_next_to_a_whole_one_needs_turns_or_less_slip() {
        let at = |order: f64, slip: f64, turns: f64| {
            let plan = ShaftPlan { slip, ..ShaftPlan::new(vec![("outer".into(), order)]) };
            next_to_rotor(&plan.tracking(turns, 1.0)).first().map(|found| (found.rotor, found.remedy))
        };
        assert_eq!(at(3.72, 0.008, 40.0), None);
        // 4.1 slips by 0.033: 0.067 apart, which blocks of two turns do not resolve (0.071), but blocks of four do.
        assert_eq!(at(4.1, 0.008, 40.0), Some((4.0, Remedy::Turns(64.0))));
        assert_eq!(at(4.1, 0.008, 64.0), None);
        // 4.04 slips by 0.032: 0.008 apart, for which blocks of 15.5 turns at most, 8, are too short. At nine tenths of
        // the slip it is 0.0109 apart, and blocks of 16 turns resolve 0.0089.
        let Some((4.0, Remedy::Slip { slip, turns })) = at(4.04, 0.008, 1000.0) else { panic!("a smaller slip") };
        assert!((slip - 0.0072).abs() < 1e-6 && (turns - 256.0).abs() < 1e-9, "{slip} {turns}");
        // Slips of 2.2 % reach 0.09 turns; those of 1.54 % leave 0.017, but blocks of 4 turns resolve 0.036 only.
        let Some((4.0, Remedy::Slip { slip, .. })) = at(4.08, 0.022, 1000.0) else { panic!("a smaller slip") };
        assert!((slip - 0.0132).abs() < 1e-6, "{slip}");
        assert_eq!(at(4.08, 0.0, 1000.0), None);
        // Blocks of 64 turns resolve 0.0022.
        assert_eq!(at(4.001, 0.0, 1e5), Some((4.0, Remedy::None)));
        // No rotor order is below one.
        assert_eq!(at(0.4, 0.008, 40.0), None);
    }
}
