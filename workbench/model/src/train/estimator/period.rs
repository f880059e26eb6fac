//! Whether the motor moves an axis that carries a weight: the period of the load over the angle, from healthy traces.
//!
//! ```text
//! i = x p + o + c cos ψ + s sin ψ,   x = (ω̇, ω, s(ω), s(ω)/(1 + (ω/ω_s)²)),   ψ = 2π Θ/R                  (1)
//! e(R) = 1 − S(R)/S₀                                                                                  (2)
//! g(R) = Σ n ln(S₀/S(R))   over the records, n rows each                                              (3)
//! ```
//!
//! Θ are the turns of the motor, R those for one turn of the axis. S is the sum of squares of what (1) leaves of the
//! current, S₀ that without the weight, each record with its own c and s: payload and start of the axis differ between
//! records. The R with the largest (3) is taken if its (2) is at least a half in half of the records: a load that is no
//! function of the position is not explained by one. A payload that changes while the axis rests moves o from one rest
//! to the next: if one o does not do, each stretch between rests has its own, in S₀ as well. R is at most four times
//! the travel of the longest record, where a sine is as good as a parabola, and so is any larger R.

use std::f64::consts::TAU;
use std::ops::Range;

use bearing_watch::model::{ShaftConstants, TorqueBalance};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::axis::{Axis, Weight};
use super::filtered::{Filtered, Rates, turned};
use super::shaft::untrained;
use super::shaft_plan::ShaftPlan;
use super::velocity_source::VelocitySource;
use crate::trace::{MotionTrace, bridged, median};

/// The least (2) of the median record.
const EXPLAINED: f64 = 0.5;
/// A ratio that is given is doubted if another one leaves less than this part of what it leaves.
const FAR_LESS: f64 = 0.5;
/// Records of which (3) is the sum, at most, and rows of each.
const MOST_RECORDS: usize = 64;
const MOST_ROWS: usize = 2000;
/// Fewest rows of a record.
const FEWEST: usize = 32;
/// Fewest turns of the motor a turn of the axis: what turns faster is of the rotor itself.
const LEAST_TURNS: f64 = 1.25;
/// The largest R, in parts of the longest travel.
const TRAVELS: f64 = 4.0;
/// Ratios that are compared, at most.
const MOST_RATIOS: usize = 4000;
/// The payload changes within records if an o for each stretch between rests leaves less than this part, and the weight
/// alone more than that of the current.
const CHANGES: f64 = 0.5;
const LEFT: f64 = 0.1;

/// What (1) without the weight leaves of the current of a record, and its axis.
struct Rest {
    /// Orthonormal columns of what is taken from the current.
    taken: DMatrix<f64>,
    rest: DVector<f64>,
    turns: Vec<f64>,
}

/// The weight in records of an interval; `turns` are those that a user gives.
#[must_use]
pub fn weight_in(records: &[&MotionTrace], interval_s: f64, turns: Option<f64>) -> Option<Weight> {
    let axis = Axis::given(turns);
    let plan = ShaftPlan { load: false, axis, velocity: VelocitySource::Channel, ..ShaftPlan::new(vec![]) };
    match of(&plan, records, interval_s) {
        Axis::Carries(weight) => Some(weight),
        Axis::Find | Axis::None | Axis::Turns(..) => None,
    }
}

/// What these healthy traces say of the axis of a plan.
pub(crate) fn of(plan: &ShaftPlan, healthy: &[&MotionTrace], interval_s: f64) -> Axis {
    if plan.load || plan.axis == Axis::None {
        return Axis::None;
    }
    // What keeps a balance from being trained is told where it is.
    let untrained = plan.check(interval_s).ok().and_then(|()| untrained(healthy, interval_s, plan).ok());
    let Some(ShaftConstants { balance, .. }) = untrained else { return plan.axis };
    let (given, rates) = (plan.axis.turns(), plan.rates());
    let (one, stretches): (Vec<_>, Vec<_>) =
        healthy.par_iter().take(MOST_RECORDS).map(|motion| Rest::of(motion, &balance, rates)).unzip();
    let records = [one, stretches].map(|rests| rests.into_iter().flatten().collect::<Vec<Rest>>());
    let of = |turns: f64, given: bool| by_either(&records, turns, given);
    let mut bests = records.iter().filter_map(|rests| best_ratio(rests)).map(|turns| of(turns, false));
    let searched = bests.find(|weight| weight.explained >= EXPLAINED);
    match (given.map(|turns| of(turns, true)), searched) {
        (Some(given), Some(searched)) if 1.0 - searched.explained < FAR_LESS * (1.0 - given.explained) => {
            Axis::Carries(Weight { better: Some(searched.turns), ..given })
        }
        (Some(weight), _) | (None, Some(weight)) => Axis::Carries(weight),
        (None, None) => Axis::None,
    }
}

/// The weight by one R, with one o or more, whichever explains it better.
fn by_either(records: &[Vec<Rest>; 2], turns: f64, given: bool) -> Weight {
    let of = |records: &[Rest]| {
        let all: Vec<[f64; 3]> = records.iter().map(|rest| rest.explained(turns)).collect();
        let of = |k: usize| median(all.iter().map(|explained| explained[k]).collect::<Vec<_>>());
        [0, 1, 2].map(|k| if all.is_empty() { 0.0 } else { of(k) })
    };
    let [[one, one_a, one_left], [more, more_a, more_left]] = [of(&records[0]), of(&records[1])];
    let changes = !records[1].is_empty() && more_left < CHANGES * one_left && 1.0 - one > LEFT;
    let (explained, amplitude_a) = if changes && more > one { (more, more_a) } else { (one, one_a) };
    Weight { turns, given, explained, amplitude_a, changes, better: None }
}

/// The R with the largest (3).
fn best_ratio(records: &[Rest]) -> Option<f64> {
    let travel = records.iter().map(Rest::travel).fold(0.0, f64::max);
    let (least, most) = (1.0 / (TRAVELS * travel), 1.0 / LEAST_TURNS);
    if !(travel > 0.0 && least < most) {
        return None;
    }
    // A fourth of what the travel resolves.
    let count = (((most - least) * TRAVELS * travel).ceil() as usize).clamp(1, MOST_RATIOS);
    let step = (most - least) / count as f64;
    let gain = |inverse: f64| -> f64 {
        let of = |rest: &Rest| rest.turns.len() as f64 * -(1.0 - rest.explained(1.0 / inverse)[0]).max(1e-9).ln();
        records.iter().map(of).sum()
    };
    let best = |inverses: Vec<f64>| {
        let gains: Vec<(f64, f64)> = inverses.into_par_iter().map(|own| (own, gain(own))).collect();
        gains.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(own, _)| own)
    };
    let mut middle = best((0..=count).map(|k| least + step * k as f64).collect())?;
    let mut width = step;
    for _ in 0..3 {
        middle = best((-8..=8).map(|k| (middle + width * f64::from(k) / 8.0).clamp(least, most)).collect())?;
        width /= 8.0;
    }
    Some(1.0 / middle)
}

impl Rest {
    /// With one o, and with one for each stretch between rests; `None` of a record with too few rows, or without a rest
    /// to part stretches.
    fn of(motion: &MotionTrace, balance: &TorqueBalance, rates: Rates) -> (Option<Self>, Option<Self>) {
        let filtered = Filtered::new(balance, rates);
        let columns = filtered.columns(&bridged(&motion.velocity_rad_s));
        let rows: Vec<usize> = filtered.rows(motion.current_a.len()).take(MOST_ROWS).collect();
        // At rest a brake or dry friction may carry the weight.
        let stretches = filtered.stretches(&columns[1], &rows);
        let rows: Vec<usize> = stretches.concat();
        if rows.len() < FEWEST {
            return (None, None);
        }
        let at = |column: &[f64]| DVector::from_iterator(rows.len(), rows.iter().map(|&row| column[row]));
        let moved: Vec<DVector<f64>> = columns.iter().map(|column| at(column)).collect();
        let current = at(&filtered.signal(&bridged(&motion.current_a)));
        let turns: Vec<f64> = at(&filtered.signal(&turned(&motion.angle_rad))).iter().copied().collect();
        let mut end = 0;
        let ranges = stretches.iter().map(|stretch| {
            let start = end;
            end += stretch.len();
            start..end
        });
        let ranges: Vec<Range<usize>> = ranges.collect();
        let less = |offsets: &[Range<usize>]| Self::less(&moved, offsets, &current, &turns);
        (less(std::slice::from_ref(&(0..rows.len()))), if ranges.len() > 1 { less(&ranges) } else { None })
    }

    /// A current without what the motion and an o of each range of rows take.
    fn less(moved: &[DVector<f64>], offsets: &[Range<usize>], current: &DVector<f64>, turns: &[f64]) -> Option<Self> {
        let one = |range: &Range<usize>| DVector::from_fn(turns.len(), |row, _| f64::from(range.contains(&row)));
        let all = moved.iter().cloned().chain(offsets.iter().map(one));
        // A signal that is zero, or a sum of the others, takes nothing.
        let scaled: Vec<DVector<f64>> = all.map(|column| &column / column.norm().max(1e-300)).collect();
        let decomposed = DMatrix::from_columns(&scaled).svd(true, false);
        let kept: Vec<usize> =
            (0..decomposed.singular_values.len()).filter(|&k| decomposed.singular_values[k] > 1e-6).collect();
        let taken = decomposed.u?.select_columns(&kept);
        let rest = current - &taken * taken.tr_mul(current);
        let whole = rest.norm() > 1e-9 * current.norm() && turns.iter().all(|turn| turn.is_finite());
        whole.then(|| Self { taken, rest, turns: turns.to_vec() })
    }

    fn travel(&self) -> f64 {
        let (low, high) =
            self.turns.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        high - low
    }

    /// (2), the amplitude, and what is left a row, as a mean square.
    fn explained(&self, turns: f64) -> [f64; 3] {
        let count = self.turns.len();
        let of =
            |part: fn(f64) -> f64| DVector::from_iterator(count, self.turns.iter().map(|own| part(TAU * own / turns)));
        let (cos, sin) = (of(f64::cos), of(f64::sin));
        // The current has nothing left of what is taken, so that only the products of the sines lose it.
        let [of_cos, of_sin] = [&cos, &sin].map(|own| self.taken.tr_mul(own));
        let cc = cos.norm_squared() - of_cos.norm_squared();
        let cs = cos.dot(&sin) - of_cos.dot(&of_sin);
        let ss = sin.norm_squared() - of_sin.norm_squared();
        let (ci, si) = (cos.dot(&self.rest), sin.dot(&self.rest));
        let determinant = cc * ss - cs * cs;
        // Over a short travel the sines are what the offset is.
        if determinant <= 1e-10 * cc.max(ss).max(1e-6 * count as f64).powi(2) {
            return [0.0, 0.0, self.rest.norm_squared() / count as f64];
        }
        let (c, s) = ((ss * ci - cs * si) / determinant, (cc * si - cs * ci) / determinant);
        let (whole, part) = (self.rest.norm_squared(), c * ci + s * si);
        [part / whole, c.hypot(s), (whole - part) / count as f64]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::estimator::motion_of;
    use rig::{Condition, Scenario, simulate};

    fn records(condition: &Condition) -> Vec<MotionTrace> {
        let record = |seed| motion_of(simulate(&condition.apply(Scenario::WITH_RESOLVER, seed), seed).expect("valid"));
        (5300..5330).map(record).collect()
    }

    fn weigh(records: &[MotionTrace], turns: Option<f64>) -> Option<Weight> {
        weight_in(&records.iter().collect::<Vec<_>>(), 0.002, turns)
    }

    fn named(name: &str) -> Condition {
        Condition::AXES.into_iter().chain(Condition::FIELD).find(|own| own.name == name).expect("a condition")
    }

    #[test]
    fn the_ratio_is_the_period_of_the_current_over_the_angle() {
        // Of an arc of a seventh of a turn the ratio is known to some per cent, and a weight of amperes from the
        // inertia hardly told; a whole turn tells more.
        for (name, ratio, within, amplitude_a) in
            [("axis-0.15", 50.0, 0.04, 3.0), ("axis-0.4", 50.0, 0.03, 8.0), ("axis-0.15-ratio-5", 5.0, 0.003, 3.0)]
        {
            let weight = weigh(&records(&named(name)), None).expect(name);
            println!("{name}: {weight:?}");
            assert!((weight.turns / ratio - 1.0).abs() < within, "{name}: {weight:?}");
            assert!(
                weight.explained > 0.9 && (weight.amplitude_a / amplitude_a - 1.0).abs() < 0.3,
                "{name}: {weight:?}"
            );
            assert!(!weight.given && weight.better.is_none() && !weight.changes, "{name}: {weight:?}");
        }
    }

    #[test]
    fn a_payload_that_changes_at_rests_is_told_from_one_that_does_not() {
        // Between two rests the axis turns by a fifteenth of a turn, which hardly tells the ratio.
        for (name, changes) in [("axis-cycle", false), ("axis-cycle-steps", true), ("axis-any-cycle-steps", true)] {
            let weight = weigh(&records(&named(name)), None).expect(name);
            println!("{name}: {weight:?}");
            assert_eq!(weight.changes, changes, "{name}: {weight:?}");
            assert!((weight.turns / 50.0 - 1.0).abs() < 0.6, "{name}: {weight:?}");
        }
    }

    #[test]
    fn no_weight_is_found_where_there_is_none() {
        for name in ["axis-level", "no-load-sensor"] {
            assert_eq!(weigh(&records(&named(name)), None), None, "{name}");
        }
        assert_eq!(weigh(&records(&named("axis-0.15")), Some(0.0)), None, "a user says so");
        assert_eq!(weigh(&[], None), None);
    }

    #[test]
    fn a_ratio_that_is_given_is_kept_and_doubted_if_another_explains_far_more() {
        let records = records(&named("axis-0.15-ratio-5"));
        let given = |turns| weigh(&records, Some(turns)).expect("as given");
        let right = given(5.0);
        assert_eq!((right.turns, right.given, right.better, right.doubt()), (5.0, true, None, None));
        let wrong = given(8.0);
        assert!((wrong.turns, wrong.given) == (8.0, true) && (wrong.better.expect("a better one") - 5.0).abs() < 0.02);
        assert!(wrong.doubt().is_some_and(|doubt| doubt.contains("one of 5.0")), "{:?}", wrong.doubt());
    }
}
