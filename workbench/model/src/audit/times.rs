//! The times of a trace: rate, jitter, gaps, times that stand.

use super::columns::held::finite;
use crate::trace::{gaps, median};

/// Usual steps that a gap is longer than.
const GAP: f64 = 1.5;
/// Relative difference of the mean step from the usual one from which on the mean tells the rate.
const SCATTERED: f64 = 0.15;

/// What was found in the times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// Rows a second: one over the median step, or over the mean of those that are no gaps where that is clearly
    /// another.
    pub rate_hz: f64,
    /// Standard deviation of the steps that are no gaps, relative to the usual one.
    pub jitter: f64,
    /// Number of steps of more than 1.5 usual ones.
    pub gaps: usize,
    /// The longest of them, s.
    pub longest_gap_s: f64,
    /// Samples that are missing by the gaps.
    pub missing: usize,
    /// Steps of zero.
    pub standing: usize,
}

impl Times {
    /// Of at least two times, s; one that is NaN is missing.
    #[must_use]
    pub fn of(times_s: &[f64]) -> Option<Self> {
        let times_s = finite(times_s);
        let steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let usual = median(&steps);
        if usual.is_nan() || usual <= 0.0 {
            return None;
        }
        let long = || steps.iter().filter(|step| **step > GAP * usual);
        let plain = || steps.iter().filter(|step| **step <= GAP * usual);
        let scatter = plain().map(|step| (step - usual).powi(2)).sum::<f64>() / plain().count().max(1) as f64;
        // Of times that are stamped late and in groups the usual step is none of the rows.
        let mean = plain().sum::<f64>() / plain().count().max(1) as f64;
        Some(Self {
            rate_hz: 1.0 / if (mean / usual - 1.0).abs() > SCATTERED { mean } else { usual },
            jitter: scatter.sqrt() / usual,
            gaps: long().count(),
            longest_gap_s: long().copied().fold(0.0, f64::max),
            missing: gaps(&times_s).iter().map(|gap| gap.missing).sum(),
            standing: steps.iter().filter(|step| **step == 0.0).count(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_jitter_and_standing_times_are_counted() {
        let mut times: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k) + 0.001 * f64::from(k % 2)).collect();
        times.iter_mut().skip(600).for_each(|t| *t += 0.3);
        times[100] = times[99];
        let found = Times::of(&times).expect("times");
        // Steps of 9 and 11 ms: the median is one of them.
        assert!((found.rate_hz - 1.0 / 0.009).abs() < 1e-6 || (found.rate_hz - 1.0 / 0.011).abs() < 1e-6, "{found:?}");
        assert!((0.05..0.2).contains(&found.jitter), "{found:?}");
        assert!(found.standing == 1 && found.gaps >= 1 && (found.longest_gap_s - 0.309).abs() < 0.003, "{found:?}");
        let lost: Vec<f64> = (0..1000).filter(|k| k % 100 != 50).map(|k| f64::from(k) / 100.0).collect();
        let found = Times::of(&[&lost[..], &[f64::NAN]].concat()).expect("times");
        assert_eq!((found.gaps, found.missing), (10, 10));
        assert!(Times::of(&[1.0]).is_none() && Times::of(&[1.0, 1.0]).is_none());
    }

    #[test]
    fn rows_that_are_stamped_in_groups_have_the_rate_of_all() {
        // Two of three rows of 100 a second are stamped with the third one.
        let times: Vec<f64> = (0..3000).map(|k| 0.01 * f64::from(k) + [0.0, 0.004, -0.004][k as usize % 3]).collect();
        let found = Times::of(&times).expect("times");
        assert!((found.rate_hz / 100.0 - 1.0).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn a_single_lost_row_is_a_gap() {
        let times: Vec<f64> = (0..100).filter(|k| *k != 40).map(|k| f64::from(k) / 64.0).collect();
        let found = Times::of(&times).expect("times");
        let expected =
            Times { rate_hz: 64.0, jitter: 0.0, gaps: 1, longest_gap_s: 2.0 / 64.0, missing: 1, standing: 0 };
        assert_eq!(found, expected);
    }
}
