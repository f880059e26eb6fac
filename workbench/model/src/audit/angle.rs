//! The angle of a shaft against its velocity: what a drive does wrong with either.
//!
//! ```text
//! d_k = wrapped(φ_{k+1} − φ_k),   D_k = (v_k + v_{k+1})/(2f),   e_k = wrapped(d_k − D_k)                  (1)
//! e_k ≈ D_k Σ_n (a_n cos nφ + b_n sin nφ):   error of the angle at order n   √(a_n² + b_n²)/n             (2)
//! r = median y/x:   ratio of the velocity, by motions x of the angle and y of the velocity in 1/8 turn    (3)
//! d_k ≈ (m + 1)(d_{k−1} + d_{k+1})/2:   m rows are lost                                                   (4)
//! ```
//!
//! A step e that the next ones take back is a spike, or a turn backwards for a row; one that stays is a slip. Steps
//! only where the angle wraps are those of a filter across the wrap. A resolver whose sine and cosine are δ off 90° has
//! an error of δ/2 at order 2, as has one whose amplitudes differ by δ.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2, Vector2};

use super::columns::held::step;

/// Fewest rows that are compared.
const FEWEST: usize = 100;
/// Steps that count, in deviations of the others and in rad.
const DEVIATIONS: f64 = 12.0;
const LEAST_RAD: f64 = 0.01;
/// Rows in which a spike is taken back, and the part of it that may stay.
const BACK: usize = 4;
const STAYS: f64 = 0.3;
/// Parts of a turn from its ends that count as the wrap.
const ENDS: f64 = 0.35;
/// Part of a turn from both ends from which on a value is between them.
const BETWEEN: f64 = 0.05;
/// Width of a place of the turn at which all spikes are.
const ONE_PLACE_RAD: f64 = 0.15;
/// Orders of periodic errors, and the least error that is told, rad.
const ORDERS: usize = 8;
const LEAST_ERROR_RAD: f64 = 0.01;
/// Deviation of the turns by the angle from those by the velocity.
const SCALE: f64 = 0.01;
/// Rows that are named.
const NAMED: usize = 3;
/// Fewest blocks of (3), slowest one as part of the usual motion, and error of the ratio that is told.
const BLOCKS: usize = 8;
const SLOWEST: f64 = 0.2;
const RATIO: f64 = 0.05;
/// Of (4): deviations and steps of the sensor that the motion of a row has at least, the part of it that it may
/// change or be off, and fewest places.
const CLEAR: f64 = 8.0;
const ALIKE: f64 = 0.25;
const FEWEST_LOST: usize = 2;
/// Rows in which the step of the sensor is searched.
const STEPS: usize = 100_000;

/// Compares an angle, rad, with a velocity, rad/s, both sampled at `rate_hz`. Each finding names its rows by numbers.
#[must_use]
pub fn findings(angle: &[f64], velocity: &[f64], rate_hz: f64) -> Vec<String> {
    let rows = angle.len().min(velocity.len());
    if rows < FEWEST || rate_hz.is_nan() || rate_hz <= 0.0 {
        return vec![];
    }
    let turned = |row: usize| wrapped(angle[row + 1] - angle[row]);
    let expected = |row: usize| 0.5 * (velocity[row] + velocity[row + 1]) / rate_hz;
    // Of a long recording the moves are computed again rather than kept.
    let moves = || (0..rows - 1).map(|row| (turned(row), expected(row)));
    // Above half a turn a row nothing can be told.
    if moves().any(|(_, expected)| expected.abs() > PI / 2.0) {
        return vec!["the shaft turns by more than a quarter of a turn a row: the angle is too slow".into()];
    }
    if let Some(scaled) = scale(&moves) {
        return vec![scaled];
    }
    if let Some(ratio) = velocity_ratio(angle, velocity, rate_hz) {
        return vec![format!("the velocity is {ratio:.4} times the slope of the angle: its unit or gain, or the rate")];
    }
    let errors: Vec<f64> = moves().map(|(step, expected)| wrapped(step - expected)).collect();
    let limit = (DEVIATIONS * 1.4826 * middle(errors.iter().copied())).max(LEAST_RAD);
    let large: Vec<usize> = (0..errors.len()).filter(|row| errors[*row].abs() > limit).collect();
    let mut findings = steps((angle, &errors, &expected), &large);
    findings.extend(periodic(angle, &expected, &errors, limit));
    findings
}

/// Whether the velocity of a coarse encoder is the difference of its counts; the step of angle and velocity are the
/// smallest differences of their values.
#[must_use]
pub fn coarse((angle_step, velocity_step, deviation): (f64, f64, f64), rate_hz: f64) -> Option<String> {
    let count = angle_step * rate_hz;
    let is_one = (velocity_step / count - 1.0).abs() < 0.02;
    let coarse = velocity_step > 0.02 * deviation;
    (is_one && coarse).then(|| {
        format!(
            "the velocity has steps of {velocity_step:.4} rad/s, one count of the angle a row: it is the difference of a \
             coarse encoder; leave it out, so that the velocity follows from the angle"
        )
    })
}

/// An angle between −π and π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// The median magnitude.
fn middle(x: impl Iterator<Item = f64>) -> f64 {
    crate::trace::median(x.map(f64::abs).collect::<Vec<_>>())
}

/// A reversed or scaled angle, by the median ratio of its steps to those of the velocity.
fn scale<M: Iterator<Item = (f64, f64)>>(moves: &dyn Fn() -> M) -> Option<String> {
    let usual = middle(moves().map(|(_, expected)| expected));
    let ratios: Vec<f64> = moves().filter(|(_, own)| own.abs() > 0.5 * usual).map(|(step, own)| step / own).collect();
    let slope = crate::trace::median(ratios);
    if slope.is_nan() || usual <= 0.0 || (slope - 1.0).abs() < SCALE {
        return None;
    }
    Some(match slope {
        _ if (slope + 1.0).abs() < SCALE => "the angle runs against the velocity; change the sign of one".into(),
        _ if (0.5..1.5).contains(&slope) => return None,
        _ => {
            format!("the angle turns {slope:.4} times as far as the velocity says: other units, a gear, or pole pairs")
        }
    })
}

/// The ratio (3) of a velocity, rad/s, that is not the slope of the angle, rad; `None` if it is, or is not known.
#[must_use]
pub fn velocity_ratio(angle: &[f64], velocity: &[f64], rate_hz: f64) -> Option<f64> {
    // Of a long recording the moves are made twice rather than kept.
    let of_pair = |(angle, w): (&[f64], &[f64])| (wrapped(angle[1] - angle[0]), 0.5 * (w[0] + w[1]) / rate_hz);
    let moves = || angle.windows(2).zip(velocity.windows(2)).map(of_pair);
    let known = moves().filter(|(x, y)| (x + y).is_finite());
    let (squares, count) = known.fold((0.0, 0_usize), |(sum, count), (x, _)| (sum + x * x, count + 1));
    let slowest = SLOWEST * (squares / count.max(1) as f64).sqrt();
    let mut blocks: Vec<(f64, f64)> = Vec::new();
    let (mut x, mut y, mut rows) = (0.0, 0.0, 0.0);
    for (by_angle, by_velocity) in moves() {
        (x, y, rows) = (x + by_angle, y + by_velocity, rows + 1.0);
        let is_full = x.abs() >= PI / 4.0;
        if is_full && x.abs() > slowest * rows {
            blocks.push((x.abs(), y * x.signum()));
        }
        if is_full || !(x + y).is_finite() {
            (x, y, rows) = (0.0, 0.0, 0.0);
        }
    }
    // An angle that is filtered across its wrap, or slips, has some wrong blocks, or no common ratio.
    let ratios: Vec<f64> = blocks.iter().map(|(x, y)| y / x).collect();
    let ratio = crate::trace::median(&ratios[..]);
    let scatter = middle(ratios.iter().map(|own| own - ratio));
    let deviation = 1.25 * 1.4826 * scatter / (blocks.len() as f64).sqrt();
    let is_common = 1.4826 * scatter < ALIKE * ratio.abs();
    let is_off = is_common && blocks.len() >= BLOCKS && (ratio - 1.0).abs() > RATIO + 3.0 * deviation;
    is_off.then_some(ratio)
}

/// Rows that were lost without a gap in the times (4), by an angle, rad.
#[must_use]
pub fn lost_rows(angle: &[f64]) -> Option<String> {
    let moves: Vec<f64> = angle.windows(2).map(|pair| wrapped(pair[1] - pair[0])).collect();
    let changes: Vec<f64> = moves.windows(2).map(|pair| pair[1] - pair[0]).filter(|x| x.is_finite()).collect();
    if changes.len() < FEWEST {
        return None;
    }
    let least = CLEAR * step(&angle[..angle.len().min(STEPS)]).max(1.4826 * middle(changes.iter().copied()));
    let is_lost = |row: &usize| {
        let (before, behind) = (moves[row - 1], moves[row + 1]);
        let usual = 0.5 * (before + behind);
        let times = moves[*row] / usual;
        usual.abs() > least
            && (before - behind).abs() < ALIKE * usual.abs()
            && times > 1.5
            && (times - times.round()).abs() < ALIKE
    };
    let lost: Vec<usize> = (1..moves.len().saturating_sub(1)).filter(is_lost).collect();
    (lost.len() >= FEWEST_LOST).then(|| {
        format!(
            "rows are lost without a gap in the times at {}: the angle turns there as in several rows",
            named(&lost)
        )
    })
}

/// Names the first rows.
fn named(rows: &[usize]) -> String {
    let first: Vec<String> = rows.iter().take(NAMED).map(|row| (row + 2).to_string()).collect();
    let more = if rows.len() > NAMED { ", …" } else { "" };
    format!("{} row{} ({}{more})", rows.len(), if rows.len() == 1 { "" } else { "s" }, first.join(", "))
}

/// Steps at the wrap, backwards, spikes and slips.
fn steps((angle, errors, expected): (&[f64], &[f64], &dyn Fn(usize) -> f64), large: &[usize]) -> Vec<String> {
    if large.is_empty() {
        return vec![];
    }
    let low = angle.iter().copied().fold(f64::INFINITY, f64::min);
    let high = angle.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let is_wrapping =
        high - low < 1.05 * TAU && angle.windows(2).any(|pair| (pair[1] - pair[0]).abs() > 0.5 * TAU * ENDS);
    // Each event: the rows from the first large step to the last one that follows closely.
    let mut events: Vec<(usize, usize)> = Vec::new();
    for row in large {
        match events.last_mut() {
            Some((_, last)) if row - *last <= BACK => *last = *row,
            _ => events.push((*row, *row)),
        }
    }
    let at_end = |value: f64| (value - low).min(high - value) < ENDS * TAU;
    let across = |&&(first, last): &&(usize, usize)| {
        let (before, behind) = (angle[first], angle[(last + 1).min(angle.len() - 1)]);
        let between = angle[first + 1..=last].iter().any(|value| (value - low).min(high - value) > BETWEEN * TAU);
        between && (before - behind).abs() > (1.0 - 2.0 * ENDS) * TAU && at_end(before) && at_end(behind)
    };
    let wraps: Vec<usize> = events.iter().filter(across).map(|(first, _)| *first).collect();
    let mut found = Vec::new();
    if is_wrapping && 2 * wraps.len() > events.len() {
        let what = "the angle is low-passed or averaged across its wrap";
        found.push(format!("{what} at {}; unwrap it before filtering, or log it unfiltered", named(&wraps)));
        return found;
    }
    let (mut backwards, mut spikes, mut slips) = (vec![], vec![], vec![]);
    // What the first and the last row do is not taken back, or was not seen to begin.
    let inner = |event: &&(usize, usize)| event.0 > 0 && event.1 + BACK < errors.len();
    for (first, last) in events.iter().filter(inner) {
        let sum: f64 = errors[*first..=*last].iter().sum();
        let most = errors[*first..=*last].iter().fold(0.0_f64, |most, e| most.max(e.abs()));
        // A spike against the motion turns back first, one along it afterwards.
        let is_against = errors[*first] * expected(*first) < 0.0;
        match () {
            () if sum.abs() > STAYS * most => slips.push((*first, sum)),
            () if is_against => backwards.push(*first),
            () => spikes.push(*first),
        }
    }
    let all: Vec<usize> = backwards.iter().chain(&spikes).copied().collect();
    let places: Vec<f64> = all.iter().map(|row| wrapped(angle[*row] - angle[all[0]])).collect();
    if places.len() > 2 && places.iter().all(|place| place.abs() < ONE_PLACE_RAD) {
        let place = angle[all[0]].rem_euclid(TAU);
        found.push(format!("the angle has spikes at {}, each turn near {place:.2} rad: the index", named(&all)));
    } else {
        if !backwards.is_empty() {
            let rows = named(&backwards);
            found.push(format!("the angle runs backwards for a sample at {rows}; look at its latch or its filter"));
        }
        if !spikes.is_empty() {
            found.push(format!("the angle has spikes at {}", named(&spikes)));
        }
    }
    if !slips.is_empty() {
        let rows: Vec<usize> = slips.iter().map(|(row, _)| *row).collect();
        let size = middle(slips.iter().map(|(_, sum)| *sum));
        found.push(format!(
            "the angle slips by about {size:.4} rad at {}; lost counts, or the velocity is wrong there",
            named(&rows)
        ));
    }
    found
}

/// The largest periodic error (2) of the angle.
fn periodic(angle: &[f64], expected: &dyn Fn(usize) -> f64, errors: &[f64], limit: f64) -> Option<String> {
    let of_order = |order: usize| -> Option<(f64, f64, usize)> {
        let (mut normal, mut right, mut rest) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
        for (row, error) in errors.iter().enumerate().filter(|(_, error)| error.abs() <= limit) {
            let expected = expected(row);
            let at = order as f64 * (angle[row] + 0.5 * expected);
            let regressor = Vector2::new(at.cos(), at.sin()) * expected;
            normal += regressor * regressor.transpose();
            right += regressor * *error;
            rest += error * error;
        }
        let found = normal.cholesky()?.solve(&right);
        let left = (rest - found.dot(&right)).max(0.0) / errors.len() as f64;
        let deviation = (left * 2.0 / normal.trace()).sqrt();
        Some((found.norm() / order as f64, deviation / order as f64, order))
    };
    let (size, deviation, order) = (1..=ORDERS).filter_map(of_order).max_by(|one, other| one.0.total_cmp(&other.0))?;
    if size < LEAST_ERROR_RAD || size < 6.0 * deviation {
        return None;
    }
    let degrees = size.to_degrees();
    Some(match order {
        2 => format!(
            "the angle has an error of {degrees:.2}° twice a turn: sine and cosine of the resolver are {:.1}° off 90°, or \
             differ by {:.0} %",
            2.0 * degrees,
            200.0 * size
        ),
        1 => format!(
            "the angle has an error of {degrees:.2}° once a turn: an offset of sine or cosine, or an eccentric disc"
        ),
        _ => format!("the angle has an error of {degrees:.2}°, {order} times a turn"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shaft at 5 to 45 rad/s in one direction, 1000 rows a second.
    fn shaft() -> (Vec<f64>, Vec<f64>) {
        let velocity: Vec<f64> = (0..2500).map(|k| 25.0 + 20.0 * (f64::from(k) * TAU / 800.0).sin()).collect();
        let mut turned = 0.3;
        let angle = velocity.windows(2).map(|pair| {
            turned += 0.5 * (pair[0] + pair[1]) / 1000.0;
            turned
        });
        (std::iter::once(0.3).chain(angle).collect(), velocity)
    }

    fn found(change: impl Fn(&mut Vec<f64>)) -> String {
        let (mut angle, velocity) = shaft();
        change(&mut angle);
        findings(&angle, &velocity, 1000.0).join("; ")
    }

    fn wrap(angle: &mut [f64]) {
        angle.iter_mut().for_each(|own| *own = own.rem_euclid(TAU));
    }

    #[test]
    fn faults_of_the_angle_are_told_with_their_rows() {
        assert_eq!(found(|angle| wrap(angle)), "");
        assert_eq!(found(|_| {}), "");
        let low_passed = found(|angle| {
            wrap(angle);
            let raw = angle.clone();
            (1..raw.len()).for_each(|k| angle[k] = 0.5 * angle[k - 1] + 0.5 * raw[k]);
        });
        assert!(low_passed.contains("low-passed or averaged across its wrap"), "{low_passed}");
        let backwards = found(|angle| {
            angle[700] -= 0.2;
            angle[1500] -= 0.2;
            wrap(angle);
        });
        assert!(backwards.contains("runs backwards for a sample at 2 rows (701, 1501)"), "{backwards}");
        let spikes = found(|angle| {
            let turns: Vec<usize> =
                (1..angle.len()).filter(|k| (angle[*k] / TAU).floor() > (angle[k - 1] / TAU).floor()).collect();
            turns.iter().for_each(|k| angle[*k] += 0.1);
            wrap(angle);
        });
        assert!(spikes.contains("each turn near"), "{spikes}");
        let slip = found(|angle| {
            angle[1200..].iter_mut().for_each(|own| *own += 0.098);
            wrap(angle);
        });
        assert!(slip.contains("slips by about 0.0980 rad at 1 row (1201)"), "{slip}");
        let resolver = found(|angle| {
            let off = 8_f64.to_radians();
            angle.iter_mut().for_each(|own| *own = (own.sin()).atan2((*own + off).cos()));
        });
        assert!(resolver.contains("8.0° off 90°") || resolver.contains("7.9° off 90°"), "{resolver}");
        assert!(found(|angle| angle.iter_mut().for_each(|own| *own = -*own)).contains("runs against the velocity"));
        assert!(found(|angle| angle.iter_mut().for_each(|own| *own *= 4.0)).contains("4.0000 times as far"));
    }

    #[test]
    fn the_ratio_of_the_velocity_is_told_from_a_twentieth_on() {
        let (angle, velocity) = shaft();
        let ratio =
            |scale: f64| velocity_ratio(&angle, &velocity.iter().map(|w| scale * w + 0.1).collect::<Vec<_>>(), 1000.0);
        assert_eq!([1.0, 0.97, 1.03].map(ratio), [None; 3]);
        for scale in [0.7153, 0.9, 1.1, 1.4] {
            // 0.1 of 25 rad/s.
            assert!((ratio(scale).expect("off") - scale).abs() < 0.006, "{scale}");
        }
        let scaled: Vec<f64> = velocity.iter().map(|w| 0.7153 * w).collect();
        let found = findings(&angle, &scaled, 1000.0).join("; ");
        assert!(found.starts_with("the velocity is 0.7153 times the slope of the angle"), "{found}");
    }

    #[test]
    fn rows_that_are_lost_without_a_gap_are_told() {
        let (angle, _) = shaft();
        assert_eq!(lost_rows(&angle), None);
        let without = |lost: &[usize]| {
            let kept = angle.iter().enumerate().filter(|(row, _)| !lost.contains(row));
            lost_rows(&kept.map(|(_, own)| own.rem_euclid(TAU)).collect::<Vec<_>>())
        };
        assert_eq!(without(&[700]), None);
        let found = without(&[700, 1000, 1001, 1900]).expect("lost");
        assert!(found.contains("at 3 rows (701, 1000, 1898)"), "{found}");
        // Counts of a coarse encoder, at some rows to a count, turn by none, one or two.
        let coarse: Vec<f64> = angle.iter().map(|own| (own / 0.02).floor() * 0.02).collect();
        assert_eq!(lost_rows(&coarse), None);
    }

    #[test]
    fn the_velocity_of_counts_is_told() {
        let count = TAU / 2400.0;
        assert!(coarse((count, 1000.0 * count, 14.0), 1000.0).expect("coarse").contains("2.6180 rad/s"));
        assert_eq!(coarse((count, 0.001, 14.0), 1000.0), None);
        assert_eq!(coarse((1e-6, 1e-3, 14.0), 1000.0), None);
    }
}
