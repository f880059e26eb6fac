//! The unit of an angle by its values: the value at which it wraps, and the ratio of its slope to a velocity.
//!
//! ```text
//! W   the value by which the angle goes back where it begins anew: median of |d_k| + what the neighbours move      (1)
//! r   median over windows of   Σ d_k / Σ (v_k + v_{k+1})/(2f),   d_k without jumps by W                          (2)
//! ```
//!
//! Neither takes a unit for granted: the angle is in units of its own, the velocity too.

use crate::trace::median;

/// Part of the range that a step back has at least, and usual motion of a row, as a part of it, up to which it is seen.
const BACK: f64 = 0.5;
const SLOW: f64 = 0.2;
/// Fewest steps back, and largest difference of their sizes.
const FEWEST: usize = 2;
const ALIKE: f64 = 0.02;
/// Windows of (2) at least, and one of an angle that begins anew as a part of its turn: an angle that is filtered
/// across its wrap has some wrong windows. The motion of one as a part of the largest one, and fewest that move so far.
const WINDOWS: usize = 60;
const PART: f64 = 0.25;
const MOVES: f64 = 0.3;
const FEWEST_WINDOWS: usize = 6;
/// Difference from whole turns that is none.
const WHOLE: f64 = 0.05;
/// Scatter of the ratios up to which they are one ratio.
const SCATTER: f64 = 0.1;

/// The value (1) at which an angle begins anew; `None` if it does not.
#[must_use]
pub fn wraps_at(angle: &[f64]) -> Option<f64> {
    let (low, high) = range(angle)?;
    let moves: Vec<f64> = angle.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let is_back = |d: &f64| d.abs() > BACK * (high - low);
    let usual = median(moves.iter().filter(|d| d.is_finite() && !is_back(d)).map(|d| d.abs()).collect::<Vec<_>>());
    if usual.is_nan() || usual > SLOW * (high - low) {
        return None;
    }
    let size = |place: usize| {
        let beside = [place.checked_sub(1), Some(place + 1)].into_iter().flatten().filter_map(|k| moves.get(k));
        let beside: Vec<f64> = beside.filter(|d| d.is_finite() && !is_back(d)).copied().collect();
        let going = beside.iter().sum::<f64>() / beside.len().max(1) as f64;
        // What goes on in the same direction is a step of the motion, not a turn that begins anew.
        (!beside.is_empty()).then(|| (going - moves[place]).abs()).filter(|_| going * moves[place] < 0.0)
    };
    let places: Vec<usize> = (0..moves.len()).filter(|k| is_back(&moves[*k])).collect();
    let sizes: Vec<f64> = places.iter().filter_map(|place| size(*place)).collect();
    let is_enough = sizes.len() >= FEWEST && 2 * sizes.len() > places.len();
    let period = median(&sizes[..]);
    (is_enough && scatter(&sizes, period) < ALIKE * period).then_some(period)
}

/// The median distance from a value.
fn scatter(x: &[f64], center: f64) -> f64 {
    median(x.iter().map(|x| (x - center).abs()).collect::<Vec<_>>())
}

/// Whether an angle that begins anew after so many turns does so after whole ones, as one of an encoder of several
/// turns does.
#[must_use]
pub fn are_whole(turns: f64) -> bool {
    turns > 0.5 && (turns / turns.round() - 1.0).abs() < WHOLE
}

/// Least and largest value, if there are two.
fn range(x: &[f64]) -> Option<(f64, f64)> {
    let fold = |(low, high): (f64, f64), x: &f64| (low.min(*x), high.max(*x));
    let (low, high) = x.iter().filter(|x| x.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), fold);
    (low < high).then_some((low, high))
}

/// The ratio (2) of the slope of an angle to a velocity, each in its own unit and per second; `None` if they have no
/// common ratio, or move too little.
#[must_use]
pub fn slope_by_velocity(angle: &[f64], velocity: &[f64], rate_hz: f64, period: Option<f64>) -> Option<f64> {
    let rows = angle.len().min(velocity.len());
    if rows < 2 * WINDOWS || rate_hz.is_nan() || rate_hz <= 0.0 {
        return None;
    }
    let moved = |row: usize| {
        let d = angle[row + 1] - angle[row];
        let turned = period.map_or(d, |period| d - period * (d / period).round());
        (turned, 0.5 * (velocity[row] + velocity[row + 1]) / rate_hz)
    };
    let longest = (rows - 1) / WINDOWS;
    let travel: f64 = (0..rows - 1).map(|row| moved(row).0.abs()).filter(|x| x.is_finite()).sum();
    let of_turn = period.map(|period| PART * period * rows as f64 / travel);
    let length = of_turn.map_or(longest, |rows| (rows as usize).clamp(1, longest));
    let window = |k: usize| {
        let known = (k * length..(k + 1) * length).map(moved).filter(|(x, y)| (x + y).is_finite());
        known.fold((0.0, 0.0), |(x, y), (dx, dy)| (x + dx, y + dy))
    };
    let all: Vec<(f64, f64)> = (0..(rows - 1) / length).map(window).collect();
    let largest = all.iter().map(|(_, y)| y.abs()).fold(0.0, f64::max);
    let ratios: Vec<f64> = all.iter().filter(|(_, y)| y.abs() > MOVES * largest).map(|(x, y)| x / y).collect();
    let ratio = median(&ratios[..]);
    let is_one = scatter(&ratios, ratio) < SCATTER * ratio.abs();
    (ratios.len() >= FEWEST_WINDOWS && is_one).then_some(ratio)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const RATE_HZ: f64 = 1000.0;

    /// Velocity and angle, rad, of a motion that reverses or not.
    fn motion(mean_rad_s: f64, swing_rad_s: f64) -> (Vec<f64>, Vec<f64>) {
        let velocity = |t: f64| mean_rad_s + swing_rad_s * (TAU * 0.7 * t).sin();
        let angle = |t: f64| mean_rad_s * t + swing_rad_s / (TAU * 0.7) * (1.0 - (TAU * 0.7 * t).cos());
        let times = || (0..8000).map(|k| f64::from(k) / RATE_HZ);
        (times().map(velocity).collect(), times().map(angle).collect())
    }

    #[test]
    fn an_angle_begins_anew_after_a_turn_in_each_unit() {
        let (_, angle) = motion(40.0, 60.0);
        for (turn, low) in [(TAU, 0.0), (TAU, -0.5 * TAU), (1.0, 0.0), (360.0, -180.0), (4096.0, 0.0), (0.1, 0.0)] {
            let wrapped: Vec<f64> = angle.iter().map(|x| (x / TAU * turn - low).rem_euclid(turn) + low).collect();
            let period = wraps_at(&wrapped).expect("wraps");
            assert!((period / turn - 1.0).abs() < 2e-3, "{turn}: {period}"); // motion of a row
        }
        assert_eq!(wraps_at(&angle), None);
        let sine: Vec<f64> = angle.iter().map(|x| x.sin()).collect();
        assert_eq!(wraps_at(&sine), None);
        let square: Vec<f64> = (0..8000).map(|k| f64::from(k / 500 % 2)).collect();
        assert_eq!(wraps_at(&square), None);
    }

    #[test]
    fn the_ratio_is_that_of_the_units_on_both_sides_of_one() {
        for (mean, swing) in [(40.0, 60.0), (50.0, 0.0), (0.0, 80.0)] {
            let (velocity, angle) = motion(mean, swing);
            for factor in [1e-3, 0.02, 1.0 / TAU, 0.5, 1.0, 7.0, 57.3, 4096.0 / TAU, -1.0] {
                let scaled: Vec<f64> = angle.iter().map(|x| factor * x).collect();
                let ratio = slope_by_velocity(&scaled, &velocity, RATE_HZ, None).expect("a ratio");
                assert!((ratio / factor - 1.0).abs() < 1e-3, "{factor}: {ratio}"); // trapezoidal rule
                let wrapped: Vec<f64> = scaled.iter().map(|x| x.rem_euclid(factor.abs() * TAU)).collect();
                let period = Some(factor.abs() * TAU);
                let ratio = slope_by_velocity(&wrapped, &velocity, RATE_HZ, period).expect("a ratio");
                assert!((ratio / factor - 1.0).abs() < 1e-3, "{factor}: {ratio}");
            }
        }
        let (velocity, angle) = motion(0.0, 80.0);
        let other: Vec<f64> = (0..8000).map(|k| (0.013 * f64::from(k)).sin()).collect();
        assert_eq!(slope_by_velocity(&angle, &other, RATE_HZ, None), None);
        assert_eq!(slope_by_velocity(&angle, &vec![0.0; velocity.len()], RATE_HZ, None), None);
    }
}
