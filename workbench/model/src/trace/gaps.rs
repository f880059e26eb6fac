//! Rows that a recording lacks, by its times.
//!
//! ```text
//! Δ_k = t_{k+1} − t_k,   T = mean of the steps within half a usual one of the median step
//! n_k = round((after − before)/T) − 1 rows are missing where Δ_k > 1.5 median                              (1)
//! before = median of t_{k−j} + jT,  after = median of t_{k+1+j} − jT,  j = 0 … 4
//! ```
//!
//! The medians of (1) are those of the rows up to the next long step: one late stamp makes a long and a short step, and
//! no gap. Nothing is told of times whose steps scatter so much that a long one need be no gap, or that a uniform clock
//! explains which is read more coarsely than it samples.

use super::median;

/// Usual steps that a gap is longer than.
const LONG: f64 = 1.5;
/// Rows at each side of a long step by whose times it is judged.
const NEAR: usize = 5;
/// The part of steps from the shortest ones on that must have this part of the usual length.
const SHORTEST: f64 = 0.05;
const LEAST: f64 = 0.6;
/// Gaps in so many steps, at most: with more, the usual step is not known.
const OFTEN: usize = 4;
/// Gaps in so many steps, or fewer, are no rounding of the times.
const SELDOM: usize = 10;
/// Steps by which times that are rounded to their step may be off a uniform clock.
const ROUNDED: f64 = 1.25;
/// Rows that may be missing, in multiples of the rows that are there; with more, long gaps are breaks.
pub const MOST: usize = 4;

/// Missing rows in a row, at most; a longer pause is a break of the recording.
pub const LONGEST_GAP: usize = 1000;
/// Missing samples that stand for a break: more than any lag of a model, so that nothing is joined over it.
pub const BREAK: usize = 100;

/// Missing rows at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The row that they come before.
    pub row: usize,
    /// Number of missing samples: of missing rows, or [`BREAK`].
    pub missing: usize,
    /// Whether the pause is longer than [`LONGEST_GAP`] rows, or than [`BREAK`] and too long for the recording.
    pub is_break: bool,
}

/// Returns the gaps of times that do not fall, s, in their order.
#[must_use]
pub fn gaps(times_s: &[f64]) -> Vec<Gap> {
    let mut steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median(&steps);
    let is_long = |step: f64| step > LONG * usual;
    let long: Vec<usize> = (0..steps.len()).filter(|k| is_long(steps[*k])).collect();
    if usual.is_nan() || usual <= 0.0 || long.is_empty() {
        return vec![];
    }
    let near = steps.iter().filter(|step| (0.5 * usual..=LONG * usual).contains(*step));
    let (sum, count) = near.fold((0.0, 0_usize), |(sum, count), step| (sum + step, count + 1));
    let clock = sum / count.max(1) as f64;
    let place = (SHORTEST * steps.len() as f64) as usize;
    let (_, short, _) = steps.select_nth_unstable_by(place, f64::total_cmp);
    if *short < LEAST * clock {
        return vec![];
    }
    let mut found: Vec<Gap> = (0..long.len()).filter_map(|place| gap(times_s, &long, place, clock)).collect();
    let is_most = |found: &[Gap]| found.iter().map(|gap| gap.missing).sum::<usize>() > MOST * times_s.len() + BREAK;
    if is_most(&found) {
        found.iter_mut().filter(|gap| gap.missing > BREAK).for_each(|gap| (gap.missing, gap.is_break) = (BREAK, true));
    }
    let is_rounded = found.len() * SELDOM > steps.len() && is_uniform(times_s);
    let is_other_clock = found.len() * OFTEN > steps.len() || is_most(&found);
    if is_rounded || is_other_clock { vec![] } else { found }
}

/// Equation (1) at one of the long steps.
fn gap(times_s: &[f64], long: &[usize], place: usize, clock: f64) -> Option<Gap> {
    let k = long[place];
    let first = place.checked_sub(1).map_or(0, |before| long[before] + 1);
    let last = long.get(place + 1).copied().unwrap_or(times_s.len() - 1);
    let before: Vec<f64> = (0..NEAR.min(k + 1 - first)).map(|j| times_s[k - j] + j as f64 * clock).collect();
    let after: Vec<f64> = (0..NEAR.min(last - k)).map(|j| times_s[k + 1 + j] - j as f64 * clock).collect();
    let missing = ((median(&after) - median(&before)) / clock).round() - 1.0;
    let is_break = missing > LONGEST_GAP as f64;
    let rows = if is_break { BREAK } else { missing.max(0.0) as usize };
    (rows > 0).then_some(Gap { row: k + 1, missing: rows, is_break })
}

/// Whether a uniform clock explains the times within their own step.
fn is_uniform(times_s: &[f64]) -> bool {
    let (Some(first), Some(last)) = (times_s.first(), times_s.last()) else { return false };
    let step = (last - first) / (times_s.len() - 1) as f64;
    let off = times_s.iter().enumerate().map(|(k, t)| t - first - k as f64 * step);
    let (least, most) = off.fold((0.0_f64, 0.0_f64), |(least, most), x| (least.min(x), most.max(x)));
    most - least <= ROUNDED * step
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The time of a row.
    type Clock = Box<dyn FnMut(usize) -> f64>;

    /// Numbers from −1 to 1.
    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / 1_073_741_824.0 - 1.0
        }
    }

    fn places(found: &[Gap]) -> Vec<(usize, usize)> {
        found.iter().map(|gap| (gap.row, gap.missing)).collect()
    }

    /// Times of the rows that are not lost, and the gaps that they have.
    fn without(
        rows: usize,
        is_lost: impl Fn(usize) -> bool,
        time: impl FnMut(usize) -> f64,
    ) -> (Vec<f64>, Vec<(usize, usize)>) {
        let times: Vec<f64> = (0..rows).map(time).collect();
        let (mut kept, mut expected, mut lost) = (Vec::new(), Vec::new(), 0);
        for (k, t) in times.into_iter().enumerate() {
            if is_lost(k) {
                lost += 1;
                continue;
            }
            if lost > 0 {
                expected.push((kept.len(), lost));
            }
            (lost, _) = (0, kept.push(t));
        }
        (kept, expected)
    }

    #[test]
    fn lost_rows_are_found_whatever_the_clock() {
        let is_lost = |k: usize| k > 0 && (k.is_multiple_of(97) || (500..520).contains(&k) || matches!(k, 702 | 704));
        // Exact, off by a tenth of a step, in milliseconds at 119 a second, with a drift.
        let mut jitter = noise(1);
        let mut clocks: Vec<(&str, Clock)> = vec![
            ("exact", Box::new(|k| 0.001 * k as f64)),
            ("jitter", Box::new(move |k| 0.001 * (k as f64 + 0.15 * jitter()))),
            ("milliseconds", Box::new(|k| (1000.0 * k as f64 / 119.0).round())),
            ("drift", Box::new(|k| 0.01 * k as f64 * (1.0 + 1e-6 * k as f64))),
            ("epoch", Box::new(|k| 1.7e9 + 1e-4 * k as f64)),
        ];
        for (name, clock) in &mut clocks {
            let (times, expected) = without(3000, is_lost, clock);
            assert_eq!(places(&gaps(&times)), expected, "{name}");
        }
    }

    #[test]
    fn jitter_and_coarse_times_are_no_gaps() {
        let mut one = noise(2);
        let late: Vec<f64> = (0..2000).map(|k| 0.01 * f64::from(k) + if k % 150 == 7 { 0.007 } else { 0.0 }).collect();
        let jitter: Vec<f64> = (0..2000).map(|k| f64::from(k) + 0.45 * one()).collect();
        // A logger that polls: each step of 0.2 to 1.8 usual ones.
        let polled: Vec<f64> = (0..2000)
            .scan(0.0, |t, _| {
                *t += 1.0 + 0.8 * one();
                Some(*t)
            })
            .collect();
        let coarse = |rate: f64| (0..2000).map(|k| (1000.0 * f64::from(k) / rate).floor()).collect::<Vec<f64>>();
        for (name, times) in [
            ("late", late),
            ("jitter", jitter),
            ("polled", polled),
            ("400 Hz", coarse(400.0)),
            ("600 Hz", coarse(600.0)),
            ("700 Hz", coarse(700.0)),
            ("900 Hz", coarse(900.0)),
            ("equal", vec![1.0; 100]),
            ("one", vec![1.0]),
            ("none", vec![]),
        ] {
            assert_eq!(gaps(&times), [], "{name}");
        }
    }

    #[test]
    fn a_long_pause_is_a_break() {
        let pause = |rows: f64| {
            let times: Vec<f64> = (0..2000).map(|k| f64::from(k) + if k < 700 { 0.0 } else { rows }).collect();
            gaps(&times)
        };
        assert_eq!(pause(1000.0), [Gap { row: 700, missing: 1000, is_break: false }]);
        // A recording of 100 rows does not bear 900 missing ones.
        let short: Vec<f64> = (0..100).map(|k| f64::from(k) + if k < 50 { 0.0 } else { 900.0 }).collect();
        assert_eq!(gaps(&short), [Gap { row: 50, missing: BREAK, is_break: true }]);
        for rows in [1001.0, 1e6, 1e12] {
            assert_eq!(pause(rows), [Gap { row: 700, missing: BREAK, is_break: true }]);
        }
    }
}
