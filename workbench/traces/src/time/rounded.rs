//! Times that are rounded to a unit → the line that they are rounded from.
//!
//! ```text
//! t_k = ⌊(c + n_k T)/u⌉ u        n_k: number of the row, also over missing ones; u: the unit               (1)
//! max_k (t_k − n_k T) − min_k (t_k − n_k T) ≤ u       the steps T that all times allow                    (2)
//! ```
//!
//! The difference (2) is convex in T, so that its least value and the two ends of the interval are found by halving.
//! Only the corners of the convex hulls of (n_k, t_k) matter to it. Of the rates that the interval allows, the usual
//! one is taken, else that in its middle. Parts of a recording between breaks have the same T, and a c each.

use crate::time::usual_rate::between;
use model::trace::median;

/// Times are rounded if the unit is at least this part of a step.
const COARSE: f64 = 1e-3;
/// Part of a step from which on the unit may be the step over a missing row.
const LONG_UNIT: f64 = 0.5;
/// Least number and least part of the steps that such rounding made longer than others.
const LONGER: f64 = 20.0;
const PART: f64 = 0.1;
/// Part of a unit by which steps of rounded times may be off whole units, and by which (2) may be off the unit.
const WHOLE: f64 = 0.1;
const OFF: f64 = 1e-3;
/// Steps from which on a pause is a break, behind which the rows are not numbered on.
const BREAK: f64 = 100.0;

/// Numbers of rows, and their times.
type Points = Vec<(f64, f64)>;

/// Puts times that are rounded to a coarse unit onto the line that they are rounded from; says so.
pub(crate) fn evened(times: &mut [f64]) -> Option<String> {
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = slope(times);
    // Of times that are no numbers nothing is known.
    if !mean.is_finite() || mean <= 0.0 {
        return None;
    }
    let shortest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let unit = steps.iter().map(|own| own - shortest).filter(|own| *own > COARSE * mean).fold(f64::INFINITY, f64::min);
    // Rounded times are apart by whole units.
    let is_whole = |own: &f64| (own / unit - (own / unit).round()).abs() < WHOLE;
    if !unit.is_finite() || !steps.iter().all(is_whole) {
        return None;
    }
    let usual = median(&steps);
    let (numbers, (low, high)) = if unit < LONG_UNIT * usual {
        let numbers = numbered(&steps, usual)?;
        let allowed = allowed(&parts(times, &numbers), unit)?;
        (numbers, allowed)
    } else {
        let longer = steps.iter().filter(|own| **own > shortest + 0.5 * unit).count();
        let rare = longer.min(steps.len() - longer) as f64;
        if rare < LONGER || rare < PART * steps.len() as f64 {
            return None;
        }
        let numbers: Vec<Option<f64>> = vec![Some(1.0); steps.len()];
        // Times that are not quite rounded have the line of least squares.
        let points = parts(times, &numbers);
        let near = || (spread(&points, mean) <= 1.02 * unit).then_some((mean, mean));
        (numbers, allowed(&points, unit).or_else(near)?)
    };
    let step = between(1.0 / high, 1.0 / low).map_or(0.5 * (low + high), |rate| 1.0 / rate);
    let mut start = (0.0, times[0]);
    for (time, number) in times.iter_mut().skip(1).zip(numbers) {
        start = number.map_or((0.0, *time), |more| (start.0 + more, start.1));
        *time = start.1 + start.0 * step;
    }
    Some(format!("the times are rounded to {unit:.3e} s; {:.6} rows a second by all of them", 1.0 / step))
}

/// The slope of the line of least squares.
fn slope(times: &[f64]) -> f64 {
    let Some(first) = times.first() else { return f64::NAN };
    let middle = 0.5 * (times.len() - 1) as f64;
    let (mut products, mut squares) = (0.0, 0.0);
    for (k, time) in times.iter().enumerate() {
        let at = k as f64 - middle;
        products += at * (time - first);
        squares += at * at;
    }
    products / squares
}

/// How many rows each step goes on, `None` at a break; `None` if a step is none.
fn numbered(steps: &[f64], usual: f64) -> Option<Vec<Option<f64>>> {
    let number = |step: &f64| match (step / usual).round() {
        count if count < 1.0 => None,
        count => Some(Some(count).filter(|count| *count < BREAK)),
    };
    steps.iter().map(number).collect()
}

/// The corners of the hulls of each part between breaks.
fn parts(times: &[f64], numbers: &[Option<f64>]) -> Vec<Points> {
    let mut parts = vec![vec![(0.0, 0.0)]];
    let mut start = times[0];
    for (time, number) in times[1..].iter().zip(numbers) {
        match (number, parts.last_mut()) {
            (Some(more), Some(part)) => {
                let last = part.last().map_or(0.0, |(number, _)| *number);
                part.push((last + more, time - start));
            }
            _ => {
                start = *time;
                parts.push(vec![(0.0, 0.0)]);
            }
        }
    }
    parts.iter().map(|part| [hull(part, 1.0), hull(part, -1.0)].concat()).collect()
}

/// The corners of the upper hull of points in the order of their numbers, or of the lower one by the other sign.
fn hull(points: &[(f64, f64)], sign: f64) -> Points {
    let mut corners: Points = Vec::new();
    for point in points {
        while let [.., one, last] = corners[..] {
            let turn = (last.0 - one.0) * (point.1 - one.1) - (last.1 - one.1) * (point.0 - one.0);
            if sign * turn < 0.0 {
                break;
            }
            corners.pop();
        }
        corners.push(*point);
    }
    corners
}

/// The difference of (2) at a step, the largest of all parts.
fn spread(parts: &[Points], step: f64) -> f64 {
    let of_part = |part: &Points| {
        let off = part.iter().map(|(number, time)| time - number * step);
        let (low, high) = off.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    parts.iter().map(of_part).fold(0.0, f64::max)
}

/// The least and the largest step that all times allow.
fn allowed(parts: &[Points], unit: f64) -> Option<(f64, f64)> {
    const HALVINGS: usize = 100;
    let last = parts.iter().flatten().max_by(|one, other| one.0.total_cmp(&other.0))?;
    let limit = unit * (1.0 + OFF);
    // No step outside of these is allowed by the first and the last time of the longest part.
    let ends = [last.1 - limit, last.1 + limit].map(|span| (span / last.0).max(0.0));
    let (mut low, mut high) = (ends[0], ends[1]);
    for _ in 0..HALVINGS {
        let third = (high - low) / 3.0;
        if spread(parts, low + third) <= spread(parts, high - third) { high -= third } else { low += third }
    }
    let best = 0.5 * (low + high);
    if spread(parts, best) > limit {
        return None;
    }
    let edge = |mut outside: f64| {
        let mut inside = best;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            *if spread(parts, middle) <= limit { &mut inside } else { &mut outside } = middle;
        }
        inside
    };
    Some((edge(ends[0]), edge(ends[1])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of rows at a rate, in whole units.
    fn rounded(rate: f64, unit: f64, rows: impl Iterator<Item = u32>) -> Vec<f64> {
        rows.map(|k| ((0.3 + f64::from(k) / rate / unit).round()) * unit).collect()
    }

    #[test]
    fn the_rate_is_that_which_all_times_allow() {
        for rate in [8192.0, 16_384.0, 19_200.0, 25_600.0, 44_100.0, 51_200.0, 12_800.0, 3000.0, 9600.0, 1234.5, 7999.0]
        {
            for rows in [400, 3000, 20_000] {
                let mut times = rounded(rate, 1e-6, 0..rows);
                let told = evened(&mut times).expect("rounded");
                let by_steps = f64::from(rows - 1) / (times[times.len() - 1] - times[0]);
                // Half a unit at each end.
                let width = 1e-6 / (f64::from(rows) / rate);
                assert!((by_steps / rate - 1.0).abs() < width, "{rate} {rows}: {by_steps}, {told}");
                assert!(rows < 3000 || (by_steps / rate - 1.0).abs() < 1e-6, "{rate} {rows}: {by_steps}");
            }
        }
        // Steps of whole units need no line.
        assert_eq!(evened(&mut rounded(8000.0, 1e-6, 0..3000)), None);
    }

    #[test]
    fn missing_rows_and_breaks_leave_the_rate() {
        for rate in [8192.0, 19_200.0, 25_600.0] {
            let is_there = |k: &u32| !k.is_multiple_of(97) && !(500..520).contains(k) && !(2000..9000).contains(k);
            let rows: Vec<u32> = (0..12_000).filter(is_there).collect();
            let mut times = rounded(rate, 1e-6, rows.iter().copied());
            let before = times.clone();
            assert!(evened(&mut times).expect("rounded").contains(&format!("{rate:.6} rows a second")));
            for ((time, old), (k, row)) in times.iter().zip(&before).zip(rows.iter().enumerate()) {
                assert!((time - old).abs() < 1.1e-6, "{rate} {row}: {time} {old}");
                let step = k.checked_sub(1).map(|last| (time - times[last]) * rate);
                let rows = k.checked_sub(1).map(|last| f64::from(row - rows[last])).filter(|rows| *rows < 100.0);
                assert!(step.zip(rows).is_none_or(|(step, rows)| (step - rows).abs() < 1e-6), "{rate} {row}");
            }
        }
    }

    #[test]
    fn rounded_times_are_those_of_the_rate_and_lost_rows_stay() {
        // 1500 Hz in whole milliseconds.
        let mut times: Vec<f64> = (0..3000).map(|k| (f64::from(k) / 1.5).floor() / 1e3).collect();
        assert!(evened(&mut times).expect("rounded").contains("1500"), "{times:?}");
        assert!((times[2999] - times[0] - 1.999).abs() < 2e-3);
        let lost: Vec<f64> = (0..3000).filter(|k| k % 50 != 7).map(|k| f64::from(k) / 1e3).collect();
        let irregular: Vec<f64> = (0..3000).map(|k| f64::from(k) / 1e3 + f64::from(k * 7 % 5) * 1e-4).collect();
        let even: Vec<f64> = (0..3000).map(|k| f64::from(k) / 1e3).collect();
        // %g behind 100 s: more than half of the times stand.
        let mut coarse: Vec<f64> = (0..2500).map(|k| ((100.0 + f64::from(k) * 4e-4) * 1e3).round() / 1e3).collect();
        assert!(evened(&mut coarse).is_some());
        let rate = 2499.0 / (coarse[2499] - coarse[0]);
        assert!((rate / 2500.0 - 1.0).abs() < 2e-5, "{rate}");
        for times in [lost, even] {
            let mut own = times.clone();
            assert_eq!(evened(&mut own), None);
            assert_eq!(own, times);
        }
        // Jitter of known steps is rounding as well: the rows are those of the line.
        assert!(evened(&mut irregular.clone()).is_none());
    }
}
