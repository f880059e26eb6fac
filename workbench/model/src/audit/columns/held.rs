//! The step of a sensor, which is the smallest difference of a column's values, and values that a source slower than
//! the recording holds over several rows.
//!
//! A slow bus gives a new value at regular times, for example every tenth row. A sensor with a coarse step also gives
//! the same value in several rows, but it changes by single steps, at times that the signal decides.

use std::borrow::Cow;

use crate::statistics::mean_sd;
use crate::trace::median;

/// Number of rows with the same value from which on the current is too slow to show a bearing.
const TOO_SLOW: usize = 10;
/// Fewest changes that tell a period.
const CHANGES: usize = 20;
/// A change that is not one step of a coarse sensor, in steps, and the part of the changes that are such.
const STEPS: f64 = 1.5;
const LARGE: f64 = 0.5;

/// The smallest difference of two values, which is that of the sensor's counts.
#[must_use]
pub fn step(x: &[f64]) -> f64 {
    let mut sorted = finite(x).into_owned();
    sorted.sort_by(f64::total_cmp);
    least_difference(&sorted, mean_sd(&sorted).1)
}

/// The values that are not missing.
pub(crate) fn finite(x: &[f64]) -> Cow<'_, [f64]> {
    if x.iter().all(|x| x.is_finite()) {
        Cow::Borrowed(x)
    } else {
        Cow::Owned(x.iter().copied().filter(|x| x.is_finite()).collect())
    }
}

/// The smallest difference of sorted values above the rounding of values with this deviation.
pub(crate) fn least_difference(sorted: &[f64], deviation: f64) -> f64 {
    let differences = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    differences.filter(|step| *step > 1e-12 * deviation).fold(f64::INFINITY, f64::min)
}

/// The usual number of rows from one value to the next, if values are held: nearly all changes are at least half of it
/// apart, and they are not single steps of the sensor.
#[must_use]
pub fn held(x: &[f64]) -> Option<usize> {
    let differs = |row: &usize| x[*row] != x[row - 1] && x[*row].is_finite() && x[row - 1].is_finite();
    let count = (1..x.len()).filter(differs).count();
    // Most signals change in most rows.
    if count < CHANGES || 2 * count > x.len() {
        return None;
    }
    let changes: Vec<usize> = (1..x.len()).filter(differs).collect();
    let mut apart: Vec<f64> = changes.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    apart.sort_by(f64::total_cmp);
    let usual = median(&apart);
    let least = apart[apart.len() / 10];
    if usual < 2.0 || least < 2.0 || 2.0 * least < usual {
        return None;
    }
    let step = step(x);
    let large = changes.iter().filter(|row| (x[**row] - x[**row - 1]).abs() > STEPS * step).count();
    (large as f64 > LARGE * changes.len() as f64).then_some(usual as usize)
}

/// Says how often a column changes whose values are held over `rows` rows; with the rate of the rows, how many times a
/// second.
#[must_use]
pub fn told(rows: usize, rate_hz: Option<f64>) -> String {
    let rate = rate_hz.map_or_else(String::new, |rate| format!(", {:.4} times a second", rate / rows as f64));
    format!("changes every {rows} rows only{rate}")
}

/// Says why a current whose values are held over `rows` rows shows no bearing; `None` if it is fast enough.
#[must_use]
pub fn too_slow(rows: usize, rate_hz: Option<f64>) -> Option<String> {
    (rows >= TOO_SLOW).then(|| {
        format!(
            "{}: no verdict on a bearing is possible; record the value of each row, not that of a slower bus",
            told(rows, rate_hz)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(rows: u32) -> Vec<f64> {
        (0..rows).map(|k| (0.037 * f64::from(k)).sin() + 0.01 * f64::from(k * 7 % 11)).collect()
    }

    #[test]
    fn slow_sources_are_told_from_coarse_and_slow_signals() {
        let hold = |rows: usize| wave(4000).chunks(rows).flat_map(|own| vec![own[0]; own.len()]).collect::<Vec<f64>>();
        for rows in [2, 4, 44, 150] {
            assert_eq!(held(&hold(rows)), Some(rows));
        }
        // 10 values a second at 444 rows a second, by a clock of its own.
        let drifting: Vec<f64> = (0..8000).map(|k| wave(200)[(f64::from(k) * 10.0 / 444.0) as usize]).collect();
        assert_eq!(held(&drifting), Some(44));
        assert_eq!(held(&wave(4000)), None);
        let coarse: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 0.02).floor()).collect();
        assert_eq!(held(&coarse), None, "an encoder at low speed");
        let slow: Vec<f64> = (0..4000).map(|k| ((f64::from(k) * 0.003).sin() * 20.0).round()).collect();
        assert_eq!(held(&slow), None);
        let mut still = vec![0.0; 4000];
        still[1000..2000].copy_from_slice(&wave(1000));
        assert_eq!(held(&still), None, "a drive that stands most of the time");
    }

    #[test]
    fn the_rate_and_its_meaning_are_told() {
        assert_eq!(told(4, Some(1000.0)), "changes every 4 rows only, 250.0000 times a second");
        let slow = too_slow(44, Some(444.0)).expect("too slow");
        assert!(slow.contains("10.0909 times a second: no verdict on a bearing"), "{slow}");
        assert_eq!(too_slow(9, None), None);
    }
}
