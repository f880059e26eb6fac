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
use bearing_watch::model::ShaftConstants;
use bearing_watch::plan::RunTime;
use rayon::prelude::*;
use statrs::statistics::Statistics;

use super::ShaftPlan;
use super::nominal::median;
use super::shaft::{Bench, Watched, harmonics};
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
    let healthy = &healthy[..healthy.len().min(MOST_TRACES)];
    let Some(pulsed) = with_pulses(bench, plan, constants, healthy)? else { return Ok(None) };
    let most = harmonics(&plan.weights);
    let (mut best, mut found) = (gain(bench, constants, healthy, &pulsed)?, None);
    for count in (1..most).rev() {
        let mut own = plan.clone();
        own.weights.iter_mut().skip(count.into()).for_each(|weight| *weight = 0.0);
        let with = ShaftConstants { tracking: own.with_cells_of(&constants.tracking.blocks), ..constants.clone() };
        let least = best + if found.is_none() { BETTER } else { 0.0 };
        let gained = gain(bench, &with, healthy, &pulsed)?;
        if gained > least {
            (best, found) = (gained, Some((own, with)));
        }
    }
    Ok(found)
}

/// The traces with the pulses (1) at all orders; `None` if no trace has orders.
fn with_pulses(
    bench: &Bench,
    plan: &ShaftPlan,
    constants: &ShaftConstants<RunTime>,
    healthy: &[Watched<'_>],
) -> Result<Option<Vec<Trace>>, Error> {
    let estimates = healthy.par_iter().map(|(labelled, _)| bench.run(constants, &labelled.trace));
    let estimates = estimates.collect::<Result<Vec<_>, _>>()?;
    let known = estimates.iter().filter(|own| own.orders_reason.is_none());
    let deviations = known.flat_map(ShaftEstimate::orders).map(|order| f64::from(order.deviation)).collect();
    let amplitude_a = DEVIATIONS * median(deviations);
    if !(amplitude_a > 0.0 && amplitude_a.is_finite()) {
        return Ok(None);
    }
    let each = |(number, (labelled, motion)): (usize, &Watched<'_>)| {
        let mut trace = labelled.trace.clone();
        // Evenly over the ranges, in an order without a pattern.
        let part = |ratio: f64| (number as f64 + 0.5) * ratio % 1.0;
        let (slip, phase) = (plan.slip * (2.0 * part(0.618_034) - 1.0), TAU * part(0.414_214));
        if let Some(shaft) = &mut trace.motion {
            for order in &constants.tracking.orders {
                let order = f64::from(order.order()) * (1.0 + f64::from(order.slip_ratio) * slip);
                add_pulses(&mut shaft.current_a, motion, order, phase, plan.weights.map(|w| amplitude_a * w.sqrt()));
            }
        }
        trace
    };
    Ok(Some(healthy.par_iter().enumerate().map(each).collect()))
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

/// (2), the mean over all orders.
fn gain(
    bench: &Bench,
    constants: &ShaftConstants<RunTime>,
    healthy: &[Watched<'_>],
    pulsed: &[Trace],
) -> Result<f64, Error> {
    let scores = |traces: Vec<&Trace>| -> Result<Vec<Vec<f64>>, Error> {
        let estimates = traces.par_iter().map(|trace| bench.run(constants, trace)).collect::<Result<Vec<_>, _>>()?;
        let of = |own: &ShaftEstimate<RunTime>| own.orders().iter().map(|order| f64::from(order.score)).collect();
        Ok(estimates.iter().filter(|own| own.orders_reason.is_none()).map(of).collect())
    };
    let without = scores(healthy.iter().map(|(labelled, _)| &labelled.trace).collect())?;
    let with = scores(pulsed.iter().collect())?;
    let orders = constants.tracking.orders.len();
    let of_order = |k: usize| {
        let column = |rows: &[Vec<f64>]| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let (without, with) = (column(&without), column(&with));
        let limit = without.as_slice().mean() + LIMIT * without.as_slice().std_dev();
        (with.as_slice().mean() - limit) / with.as_slice().std_dev()
    };
    Ok((0..orders).map(of_order).sum::<f64>() / orders as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{Condition, Defect};
    use crate::study::campaign::experiments::Training;
    use crate::study::campaign::run::{class_names, training_set};
    use crate::study::field::recipe::recipe;
    use crate::train::train;

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

    /// The weights of the outer ring's order after training on so many healthy records of a condition.
    fn chosen_weights(condition: &str, count: u32) -> [f32; 3] {
        let condition = Condition::named(condition).expect("a condition");
        let training = Training { condition, classes: vec![Defect::HEALTHY], count };
        let set = training_set(&training, 78).expect("the rig");
        let trained = train(&set, &class_names(&training.classes), &recipe(&condition, &["order_outer".into()]));
        let (_, shaft) = trained.expect("trains").parts.shaft.expect("watched");
        shaft.tracking.orders[0].weights
    }

    /// In one direction the third harmonic, 11.15, is searched down to 10.9, over a sideband of the cogging at 11.
    #[test]
    fn harmonics_on_lines_of_the_rotor_are_left_out_and_others_are_not() {
        assert!(chosen_weights("field-any", 150)[2] <= 0.0);
        // The load hides all harmonics alike.
        assert!(chosen_weights("no-load-sensor", 100)[1] > 0.0);
        // Too few traces to tell.
        assert_eq!(chosen_weights("field-any", 30), [1.0, 0.5, 0.25]);
    }
}
