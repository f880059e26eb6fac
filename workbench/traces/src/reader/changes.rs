//! Logs that write a value only where it changed: the last one is held.
//!
//! ```text
//! t    i     v             t    i     v
//! 0    0.5   10            0    0.5   10
//! 1          11      ─►    1    0.5   11
//! 2    0.6                 2    0.6   11
//! 3                        3    0.6   11
//! ```
//!
//! A cell that is empty may also be a value that is lost. The log is one of changes if many cells are empty, no value
//! comes twice in a row, and the values are so coarse that some would: their usual step is a few of the smallest one,
//! or each of them comes several times.

use model::trace::median;

/// Least part of the rows that lack a value.
const EMPTY: f64 = 0.33;
/// Least number of values that are given.
const GIVEN: usize = 16;
/// Part of the values that may come twice.
const TWICE: f64 = 0.01;
/// The usual step of values that are coarse, in their smallest step.
const COARSE: f64 = 3.0;
/// How often each value comes, if values are coarse whatever their steps, and the least number of values for that.
const RECURRING: usize = 4;
const MANY: usize = 64;

/// Holds the values of such a column; returns how many rows lacked one.
pub(crate) fn hold(column: &mut [f64]) -> Option<usize> {
    let first = column.iter().position(|value| value.is_finite())?;
    let missing = column[first..].iter().filter(|value| !value.is_finite()).count();
    if (missing as f64) < EMPTY * (column.len() - first) as f64 || !are_changes(&column[first..]) {
        return None;
    }
    let mut last = column[first];
    for value in &mut column[first..] {
        if value.is_finite() { last = *value } else { *value = last }
    }
    Some(missing)
}

/// Whether each value differs from the one before, and is one of a few.
fn are_changes(column: &[f64]) -> bool {
    let given: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    let steps: Vec<f64> = given.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let twice = steps.iter().filter(|step| **step == 0.0).count();
    let others: Vec<f64> = steps.into_iter().filter(|step| *step > 0.0).collect();
    let least = others.iter().copied().fold(f64::INFINITY, f64::min);
    let mut distinct: Vec<u64> = given.iter().map(|value| value.to_bits()).collect();
    distinct.sort_unstable();
    distinct.dedup();
    let recur = given.len() >= MANY && RECURRING * distinct.len() <= given.len();
    // The digits of a step are not those of its values.
    let are_near = median(&others) <= COARSE * least * (1.0 + 1e-6);
    given.len() >= GIVEN && (twice as f64) <= TWICE * given.len() as f64 && (are_near || recur)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(k: usize) -> f64 {
        let mixed = (k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        ((mixed ^ mixed >> 31).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
    }

    /// A signal rounded to steps, with cells empty where it does not change.
    fn log_of(signal: impl Fn(usize) -> f64, step: f64) -> (Vec<f64>, Vec<f64>) {
        let all: Vec<f64> = (0..2000).map(|k| (signal(k) / step).round() * step).collect();
        let log = (0..all.len()).map(|k| if k > 0 && all[k] == all[k - 1] { f64::NAN } else { all[k] });
        (log.collect(), all)
    }

    #[test]
    fn values_that_change_are_held() {
        type Signal = fn(usize) -> f64;
        let signals: [(Signal, f64); 4] = [
            (|k| 5.0 * (k as f64 / 90.0).sin(), 0.1),
            (|k| 0.01 * k as f64, 0.05),
            (|k| (k as f64 / 40.0).sin() + 0.08 * noise(k), 0.1),
            // It rests, and moves quickly.
            (|k| if k % 500 < 250 { 0.0 } else { 20.0 * (k as f64 / 20.0).sin() }, 0.5),
        ];
        for (signal, step) in signals {
            let (mut log, all) = log_of(signal, step);
            let empty = log.iter().filter(|value| value.is_nan()).count();
            assert!(empty > 700, "{empty}");
            assert_eq!((hold(&mut log), &log), (Some(empty), &all));
        }
    }

    #[test]
    fn values_that_are_lost_stay_missing() {
        let lossy = |signal: &dyn Fn(usize) -> f64, lost: f64| -> Vec<f64> {
            (0..2000).map(|k| if noise(k + 7777) + 0.5 < lost { f64::NAN } else { signal(k) }).collect()
        };
        let fine = |k: usize| 5.0 * (k as f64 / 90.0).sin() + noise(k);
        let coarse = |k: usize| (50.0 * (k as f64 / 90.0).sin()).round();
        // A slow sensor beside faster ones, and few empty cells.
        let slow: Vec<f64> =
            (0..2000).map(|k| if k % 10 == 0 { (0.01 * k as f64).round() } else { f64::NAN }).collect();
        let (few, _) = log_of(|k| k as f64 + (k % 5) as f64, 1.0);
        for column in [lossy(&fine, 0.5), lossy(&coarse, 0.5), slow, few, vec![f64::NAN; 50], vec![]] {
            let mut held = column.clone();
            assert_eq!(hold(&mut held), None);
            assert!(held.iter().zip(&column).all(|(one, other)| one.to_bits() == other.to_bits()));
        }
    }
}
