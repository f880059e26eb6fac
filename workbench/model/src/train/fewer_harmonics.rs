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

use std::f64::consts::{PI, TAU};

use bearing_watch::ShaftEstimate;
use bearing_watch::model::{ShaftConstants, TrackedOrder};
use bearing_watch::plan::RunTime;
use rayon::prelude::*;
use statrs::statistics::Statistics;

use super::bench::{Bench, Watched};
use super::nominal::median;
use super::shaft_plan::{ShaftPlan, harmonics};
use crate::Error;
use crate::trace::{MotionTrace, Trace};

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

/// Returns the plan and the constants with fewer harmonics, if they find more.
pub(super) fn chosen(
    bench: &Bench,
    plan: &ShaftPlan,
    constants: &ShaftConstants<RunTime>,
    healthy: &[Watched<'_>],
) -> Result<Option<(ShaftPlan, ShaftConstants<RunTime>)>, Error> {
    if !plan.fewer_harmonics || healthy.len() < LEAST_TRACES {
        return Ok(None);
    }
    // Evenly over all of them: neighbours are often alike.
    let some: Vec<_> = healthy.iter().copied().step_by(healthy.len().div_ceil(MOST_TRACES)).collect();
    let without = bench.run_all(constants, &some)?;
    let Some(pulses) = Pulses::of(plan, &without) else { return Ok(None) };
    let (mut best, mut found) = (pulses.gain(bench, constants, &some, &without)?, None);
    for count in (1..harmonics(&plan.weights)).rev() {
        let mut own = plan.clone();
        own.weights.iter_mut().skip(count.into()).for_each(|weight| *weight = 0.0);
        let with = ShaftConstants { tracking: own.with_cells_of(&constants.tracking.blocks), ..constants.clone() };
        let least = best + if found.is_none() { BETTER } else { 0.0 };
        let gained = pulses.gain(bench, &with, &some, &bench.run_all(&with, &some)?)?;
        if gained > least {
            (best, found) = (gained, Some((own, with)));
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
        // Evenly over the ranges, in an order without a pattern.
        let part = |ratio: f64| (number as f64 + 0.5) * ratio % 1.0;
        let (slip, phase) = (self.slip * (2.0 * part(0.618_034) - 1.0), TAU * part(0.414_214));
        if let Some(shaft) = &mut trace.motion {
            for order in orders {
                let order = f64::from(order.order()) * (1.0 + f64::from(order.slip_ratio) * slip);
                add_pulses(&mut shaft.current_a, motion, order, phase, self.amplitudes_a);
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

/// Adds the pulses (1) of one order.
fn add_pulses(current_a: &mut [f64], motion: &MotionTrace, order: f64, phase: f64, amplitudes_a: [f64; 3]) {
    let (mut turned_rad, mut before) = (0.0, f64::NAN);
    for ((current, angle), velocity) in current_a.iter_mut().zip(&motion.angle_rad).zip(&motion.velocity_rad_s) {
        if angle.is_finite() {
            // Of a wrapped angle, the step of less than half a turn.
            let step = (angle - before + PI).rem_euclid(TAU) - PI;
            turned_rad += if step.is_finite() { step } else { 0.0 };
            before = *angle;
        }
        let place = order * turned_rad + phase;
        let pulses: f64 = [1.0, 2.0, 3.0].iter().zip(amplitudes_a).map(|(h, a)| a * (h * place).cos()).sum();
        *current += pulses * if *velocity < 0.0 { -1.0 } else { 1.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of x cos(h O θ) and of x sin(h O θ) over a whole number of turns.
    fn projected(x: &[f64], angle_rad: &[f64], order: f64) -> [f64; 2] {
        let of = |part: fn(f64) -> f64| {
            2.0 * x.iter().zip(angle_rad).map(|(x, angle)| x * part(order * angle)).sum::<f64>() / x.len() as f64
        };
        [of(f64::cos), of(f64::sin)]
    }

    #[test]
    fn pulses_have_their_harmonics_and_oppose_the_motion() {
        // Ten turns forward, wrapped; the angle of one sample is missing.
        let turned: Vec<f64> = (0..5000).map(|k| f64::from(k) * TAU / 500.0).collect();
        let mut motion = MotionTrace {
            angle_rad: turned.iter().map(|angle| angle.rem_euclid(TAU)).collect(),
            velocity_rad_s: vec![20.0; 5000],
            ..MotionTrace::default()
        };
        motion.angle_rad[700] = f64::NAN;
        let mut current_a = vec![0.0; 5000];
        add_pulses(&mut current_a, &motion, 3.5, 0.5 * PI, [0.4, 0.2, 0.1]);
        for (h, amplitude) in [(1.0, 0.4), (2.0, 0.2), (3.0, 0.1)] {
            let [x, y] = projected(&current_a, &turned, 3.5 * h);
            // cos(h (φ + π/2)): the phase turns by a quarter, a half and three quarters.
            let [want_x, want_y] = [amplitude * (h * 0.5 * PI).cos(), -amplitude * (h * 0.5 * PI).sin()];
            // One sample of 5000 is held at the angle before.
            assert!((x - want_x).abs() < 1e-3 && (y - want_y).abs() < 1e-3, "{h}: {x} {y}");
        }
        let mut back = MotionTrace { velocity_rad_s: vec![-20.0; 5000], ..motion };
        back.angle_rad[700] = 0.0;
        let mut reversed = vec![0.0; 5000];
        add_pulses(&mut reversed, &back, 3.5, 0.5 * PI, [0.4, 0.2, 0.1]);
        assert!((reversed[10] + current_a[10]).abs() < 1e-12);
    }
}
