//! The filters of the residual in which the shaft's orders are tracked, from healthy traces.
//!
//! ```text
//! cost = mean ln σ_A + ½ ln mean prominence                                                            (1)
//! ```
//!
//! (1) is the deviation of the orders' amplitudes: the geometric mean of what the control orders say, and how much more
//! noise there is at the orders themselves. A high-pass costs signal where the shaft turns slowly, and removes what the
//! torque balance does not know; parameters of the segment itself know more than nominal ones, and change meanwhile.
//! Which is better depends on the drive: each is tried with the core.
//!
//! The number of harmonics of the bearing orders that the core uses, from healthy traces and the same traces with
//! pulses.
//!
//! ```text
//! i' = i + A sgn(ω) Σ_h √w_h cos(h (O (1 + c δ) θ + φ)),   A: four deviations of the order's amplitude        (2)
//! gain = [mean s' − (mean s + 2.33 deviation s)] / deviation s'                                             (3)
//! ```
//!
//! w are the weights of the plan: the shares of the energy that pulses of a defect have at each harmonic. More
//! harmonics have more of this energy, and more of what else is in the residual: a higher harmonic covers a wider range
//! of orders in the search of the slip, where whole orders of the rotor, their sidebands or a resonance may be. (3) is
//! how far the scores s' with pulses are above the limit of one in a hundred of the scores s without: the number of
//! harmonics with the largest gain finds most defects. Each trace has another slip δ and phase φ of the pulses, which
//! do not slip within it.

use bearing_watch::model::{ShaftConstants, TrackedOrder};
use bearing_watch::plan::RunTime;
use bearing_watch::shaft::ShaftEstimate;
use rayon::prelude::*;
use statrs::statistics::Statistics;

use super::bench::{AlarmState, Bench, OWN_FROM_ROWS};
use super::nominal::median;
use super::pulses;
use super::shaft_plan::{ShaftPlan, harmonics};
use crate::Error;
use crate::trace::Trace;

/// Traces on which filters are compared.
pub(crate) const MOST_COMPARED: usize = 16;

/// Corners of the residual's low-pass and high-pass that are compared.
const POLES_HZ: [f32; 10] = [2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 32.0, 64.0, 128.0, 256.0];
const SLOW_HZ: [f32; 3] = [0.0, 2.0, 4.0];

/// Returns the constants with the best high-pass and parameters, then with the best low-pass.
pub(crate) fn best(
    bench: &Bench,
    constants: ShaftConstants<RunTime>,
    healthy: &[AlarmState<'_>],
) -> Result<ShaftConstants<RunTime>, Error> {
    let healthy = &healthy[..healthy.len().min(MOST_COMPARED)];
    let half = std::f32::consts::PI * constants.balance.interval_s;
    let with = |rows: u16, slow_hz: f32| {
        let mut own = constants.clone();
        own.balance.adapt_after_rows = rows;
        own.tracking.blocks.high_pass = 1.0 - (-2.0 * half * slow_hz).exp();
        own
    };
    // What is never formed with own parameters, or has to be, stays so.
    let own = [constants.balance.adapt_after_rows];
    let rows = if own == [OWN_FROM_ROWS] { &[OWN_FROM_ROWS, u16::MAX][..] } else { &own };
    let slow = rows.iter().flat_map(|rows| SLOW_HZ.map(|slow_hz| with(*rows, slow_hz)));
    let best = least(bench, slow.collect(), healthy)?.map_or(constants, |(_, best)| best);
    Ok(least(bench, poles(&best), healthy)?.map_or(best, |(_, best)| best))
}

/// Returns the least cost (1) of any low-pass.
pub(crate) fn cost(
    bench: &Bench,
    constants: &ShaftConstants<RunTime>,
    healthy: &[AlarmState<'_>],
) -> Result<f64, Error> {
    let healthy = &healthy[..healthy.len().min(MOST_COMPARED)];
    Ok(least(bench, poles(constants), healthy)?.map_or(f64::INFINITY, |(cost, _)| cost))
}

fn poles(constants: &ShaftConstants<RunTime>) -> Vec<ShaftConstants<RunTime>> {
    let half = std::f32::consts::PI * constants.balance.interval_s;
    let with = |corner_hz: f32| {
        let mut own = constants.clone();
        own.tracking.blocks.pole = ((1.0 - half * corner_hz) / (1.0 + half * corner_hz)).max(0.0);
        own
    };
    POLES_HZ.map(with).to_vec()
}

/// Returns the constants with the least cost (1), and the cost.
fn least(
    bench: &Bench,
    tried: Vec<ShaftConstants<RunTime>>,
    healthy: &[AlarmState<'_>],
) -> Result<Option<(f64, ShaftConstants<RunTime>)>, Error> {
    let cost = |own: &ShaftConstants<RunTime>| -> Result<f64, Error> {
        let runs = bench.run_all(own, healthy)?;
        let orders = || runs.iter().filter(|run| run.orders_reason.is_none()).flat_map(ShaftEstimate::orders);
        let count = orders().count() as f64;
        if count == 0.0 {
            return Ok(f64::INFINITY);
        }
        let deviations = orders().map(|order| f64::from(order.deviation).max(1e-30).ln()).sum::<f64>() / count;
        let prominence = orders().map(|order| f64::from(order.prominence)).sum::<f64>() / count;
        Ok(deviations + 0.5 * prominence.max(1e-30).ln()) // (1)
    };
    let costs: Vec<f64> = tried.iter().map(cost).collect::<Result<_, _>>()?;
    Ok(costs.into_iter().zip(tried).min_by(|(one, _), (other, _)| one.total_cmp(other)))
}

/// Fewer traces do not tell the deviations of (3).
const LEAST_TRACES: usize = 50;
/// Traces on which numbers of harmonics are compared.
const MOST_TRACES: usize = 200;
/// A of (2).
const DEVIATIONS: f64 = 4.0;
/// A hundredth of a normal variable is above so many deviations.
const LIMIT: f64 = 2.326;
/// Fewer harmonics have to gain so much more, so that the choice does not depend on chance.
const BETTER: f64 = 0.15;

/// Returns the plan with fewer harmonics, if they find more.
pub(crate) fn chosen(
    bench: &Bench,
    plan: &ShaftPlan,
    constants: &ShaftConstants<RunTime>,
    healthy: &[AlarmState<'_>],
) -> Result<Option<ShaftPlan>, Error> {
    if !plan.fewer_harmonics || healthy.len() < LEAST_TRACES {
        return Ok(None);
    }
    // Evenly over all of them: neighbours are often alike.
    let some: Vec<_> = healthy.iter().copied().step_by(healthy.len().div_ceil(MOST_TRACES)).collect();
    let without = bench.run_all(constants, &some)?;
    let Some(pulses) = Pulses::of(plan, &without) else { return Ok(None) };
    let (mut best, mut found) = (pulses.gain(bench, constants, &some, &without)?, None);
    for count in (1..harmonics(&plan.weights)).rev() {
        let mut own = ShaftPlan { fewer_harmonics: false, ..plan.clone() };
        own.weights.iter_mut().skip(count.into()).for_each(|weight| *weight = 0.0);
        let with = ShaftConstants { tracking: own.with_cells_of(&constants.tracking.blocks), ..constants.clone() };
        let least = best + if found.is_none() { BETTER } else { 0.0 };
        let gained = pulses.gain(bench, &with, &some, &bench.run_all(&with, &some)?)?;
        if gained > least {
            (best, found) = (gained, Some(own));
        }
    }
    Ok(found)
}

/// The pulses (2).
struct Pulses {
    /// A √w of each harmonic.
    amplitudes_a: [f64; 3],
    /// Largest slip.
    slip: f64,
}

impl Pulses {
    /// For these estimates; `None` if no trace has orders.
    fn of(plan: &ShaftPlan, estimates: &[ShaftEstimate<RunTime>]) -> Option<Self> {
        let known = estimates.iter().filter(|own| own.orders_reason.is_none());
        let deviations = known.flat_map(ShaftEstimate::orders).map(|order| f64::from(order.deviation)).collect();
        let amplitude_a = DEVIATIONS * median(deviations);
        let amplitudes_a = plan.weights.map(|weight| amplitude_a * weight.sqrt());
        (amplitude_a > 0.0 && amplitude_a.is_finite()).then_some(Self { amplitudes_a, slip: plan.slip })
    }

    /// A trace with pulses at all orders.
    fn added(&self, (labelled, motion): &AlarmState<'_>, number: usize, orders: &[TrackedOrder]) -> Trace {
        let mut trace = labelled.trace.clone();
        let (slip, phase) = pulses::slip_and_phase(number, self.slip);
        if let Some(shaft) = &mut trace.motion {
            for order in orders {
                let order = f64::from(order.order()) * (1.0 + f64::from(order.slip_ratio) * slip);
                pulses::add(&mut shaft.current_a, motion, order, phase, self.amplitudes_a);
            }
        }
        trace
    }

    /// (3), the mean over all orders; `without` are the estimates without pulses.
    fn gain(
        &self,
        bench: &Bench,
        constants: &ShaftConstants<RunTime>,
        healthy: &[AlarmState<'_>],
        without: &[ShaftEstimate<RunTime>],
    ) -> Result<f64, Error> {
        let orders = &constants.tracking.orders;
        let pulsed = |(number, own): (usize, &AlarmState<'_>)| bench.run(constants, &self.added(own, number, orders));
        let with = healthy.par_iter().enumerate().map(pulsed).collect::<Result<Vec<_>, _>>()?;
        let of_order = |k: usize| {
            let (without, with) = (scores(without, k), scores(&with, k));
            let limit = without.as_slice().mean() + LIMIT * without.as_slice().std_dev();
            (with.as_slice().mean() - limit) / with.as_slice().std_dev()
        };
        Ok((0..orders.len()).map(of_order).sum::<f64>() / orders.len() as f64)
    }
}

/// The scores of an order in the traces that have one.
fn scores(estimates: &[ShaftEstimate<RunTime>], order: usize) -> Vec<f64> {
    let known = estimates.iter().filter(|own| own.orders_reason.is_none());
    known.filter_map(|own| own.orders().get(order)).map(|order| f64::from(order.score)).collect()
}
