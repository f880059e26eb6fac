//! How many harmonics of the bearing orders the core uses, from healthy traces and the same traces with pulses.
//!
//! ```text
//! i' = i + A sgn(ω) Σ_h √w_h cos(h (O (1 + c δ) θ + φ)),   A: four deviations of the order's amplitude        (1)
//! gain = [mean s' − (mean s + 2.33 deviation s)] / deviation s'                                             (2)
//! ```
//!
//! w are the weights of the plan: the shares of the energy that pulses of a defect have at each harmonic. More
//! harmonics have more of this energy, and more of what else is in the residual: a higher harmonic covers a wider range
//! of orders in the search of the slip, where whole orders of the rotor, their sidebands or a resonance may be. (2) is
//! how far the scores s' with pulses are above the limit of one in a hundred of the scores s without: the number of
//! harmonics with the largest gain finds most defects. Each trace has another slip δ and phase φ of the pulses, which
//! do not slip within it.

use bearing_watch::model::{ShaftConstants, TrackedOrder};
use bearing_watch::plan::RunTime;
use bearing_watch::shaft::ShaftEstimate;
use rayon::prelude::*;
use statrs::statistics::Statistics;

use super::bench::{Bench, Watched};
use super::nominal::median;
use super::pulses;
use super::shaft_plan::{ShaftPlan, harmonics};
use crate::Error;
use crate::trace::Trace;

/// Fewer traces do not tell the deviations of (2).
const LEAST_TRACES: usize = 50;
/// Traces on which numbers of harmonics are compared.
const MOST_TRACES: usize = 200;
/// A of (1).
const DEVIATIONS: f64 = 4.0;
/// A hundredth of a normal variable is above so many deviations.
const LIMIT: f64 = 2.326;
/// Fewer harmonics have to gain so much more, so that the choice does not depend on chance.
const BETTER: f64 = 0.15;

/// Returns the plan with fewer harmonics, if they find more.
pub(super) fn chosen(
    bench: &Bench,
    plan: &ShaftPlan,
    constants: &ShaftConstants<RunTime>,
    healthy: &[Watched<'_>],
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

/// The pulses (1).
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
    fn added(&self, (labelled, motion): &Watched<'_>, number: usize, orders: &[TrackedOrder]) -> Trace {
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

    /// (2), the mean over all orders; `without` are the estimates without pulses.
    fn gain(
        &self,
        bench: &Bench,
        constants: &ShaftConstants<RunTime>,
        healthy: &[Watched<'_>],
        without: &[ShaftEstimate<RunTime>],
    ) -> Result<f64, Error> {
        let orders = &constants.tracking.orders;
        let pulsed = |(number, own): (usize, &Watched<'_>)| bench.run(constants, &self.added(own, number, orders));
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
