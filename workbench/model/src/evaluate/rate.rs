//! A rate with its 95 % interval, of independent decisions or of decisions that are alike within groups.
//!
//! ```text
//! p  = K/N,   K = Σ k_i,  N = Σ n_i         k_i of n_i decisions of group i = 1 … g
//! v  = g/(g − 1) Σ (k_i − p n_i)² / N²                                   (1)  variance of p, by groups
//! D  = v N / (p (1 − p)),  at least 1                                    (2)  design effect
//! n* = max(N/D · (z/t)²,  N²/Σ n_i²)                                     (3)  effective number of decisions
//! ```
//!
//! The interval is Wilson's with n* decisions (Korn and Graubard 1998). z and t are the 97.5 % quantiles of the normal
//! distribution and of Student's with g − 1 degrees of freedom. N²/Σ n_i² is n* if all decisions of a group are equal,
//! which is the worst case; at p = 0 and 1, where (1) is zero, it is used alone.

use serde_json::{Value, json};
use statrs::distribution::{ContinuousCDF as _, StudentsT};

/// 97.5 % quantile of the normal distribution.
const Q: f64 = 1.959_963_984_540_054;

/// A rate with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rate {
    /// The observed rate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Rate {
    /// Rate `k` of `n`, with Wilson's score interval. For `n = 0` the interval is [0, 1].
    #[must_use]
    pub fn wilson(k: usize, n: usize) -> Self {
        Self::wilson_of(k as f64, n as f64)
    }

    /// Same as [`Rate::wilson`] for numbers that need not be integers, for example effective counts.
    #[must_use]
    pub fn wilson_of(k: f64, n: f64) -> Self {
        if n <= 0.0 {
            return Self { value: f64::NAN, low: 0.0, high: 1.0 };
        }
        let p = k / n;
        let centre = (p + Q * Q / (2.0 * n)) / (1.0 + Q * Q / n);
        let half = Q / (1.0 + Q * Q / n) * (p * (1.0 - p) / n + Q * Q / (4.0 * n * n)).sqrt();
        // At 0 and n the interval ends exactly at the rate; the clamp prevents rounding from moving it beyond.
        Self { value: p, low: (centre - half).clamp(0.0, p), high: (centre + half).clamp(p, 1.0) }
    }

    /// Rate of all decisions of groups, given as (k, n) for each; the decisions of a group may be alike (3).
    pub(crate) fn clustered(groups: &[(usize, usize)]) -> Self {
        let weights: Vec<(f64, f64)> = groups.iter().map(|&(k, n)| (k as f64, n as f64)).collect();
        Self::clustered_of(&weights)
    }

    /// Same as [`Rate::clustered`] for decisions with weights of mean 1: sums of the weights.
    pub(crate) fn clustered_of(groups: &[(f64, f64)]) -> Self {
        let used: Vec<(f64, f64)> = groups.iter().filter(|(_, n)| *n > 0.0).copied().collect();
        let (k, n) = used.iter().fold((0.0, 0.0), |(k, n), group| (k + group.0, n + group.1));
        let squares: f64 = used.iter().map(|group| group.1 * group.1).sum();
        // One decision in each group: they are independent.
        if used.iter().all(|group| (group.1 - 1.0).abs() < 1e-9) {
            return Self::wilson_of(k, n);
        }
        let (p, count, alike) = (k / n, used.len() as f64, n * n / squares);
        let effective = match StudentsT::new(0.0, 1.0, count - 1.0) {
            Ok(student) if k > 0.0 && k < n => {
                let between: f64 = used.iter().map(|group| (group.0 - p * group.1).powi(2)).sum();
                let design = count / (count - 1.0) * between / n / (p * (1.0 - p));
                (n / design.max(1.0) * (Q / student.inverse_cdf(0.975)).powi(2)).max(alike)
            }
            _ => alike,
        };
        Self::wilson_of(p * effective, effective)
    }

    /// A rate with this variance, which was estimated from this number of groups. Groups that differ in nothing have no
    /// variance: then it is that of as many decisions as there are groups.
    pub(super) fn of_variance(value: f64, variance: f64, groups: f64) -> Self {
        let student = StudentsT::new(0.0, 1.0, groups - 1.0);
        let effective = match student {
            Ok(student) if variance > 0.0 => {
                let count = value * (1.0 - value) / variance * (Q / student.inverse_cdf(0.975)).powi(2);
                count.max(groups)
            }
            _ => groups,
        };
        Self::wilson_of(value * effective, effective)
    }

    /// Mean of independent rates; its interval follows from variances recovered from their intervals (MOVER, Zou and
    /// Donner 2008), which remains valid at 0 and 100 %.
    #[must_use]
    pub fn mean(rates: &[Self]) -> Self {
        let n = rates.len() as f64;
        let value = rates.iter().map(|r| r.value).sum::<f64>() / n;
        let spread = |end: fn(&Self) -> f64| rates.iter().map(|r| (end(r) - r.value).powi(2)).sum::<f64>().sqrt() / n;
        Self { value, low: (value - spread(|r| r.low)).max(0.0), high: (value + spread(|r| r.high)).min(1.0) }
    }

    /// The same rate with both sides of the interval longer by a factor.
    pub(super) fn widened(self, factor: f64) -> Self {
        let Self { value, low, high } = self;
        Self { value, low: (value - factor * (value - low)).max(0.0), high: (value + factor * (high - value)).min(1.0) }
    }

    /// JSON object with the keys `value`, `low`, `high`.
    #[must_use]
    pub fn to_json(self) -> Value {
        json!({ "value": self.value, "low": self.low, "high": self.high })
    }
}

impl std::fmt::Display for Rate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.1} % [{:.1}, {:.1}]", 100.0 * self.value, 100.0 * self.low, 100.0 * self.high)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn wilson_interval_against_tabulated_values() {
        // Newcombe 1998, table I: 81/263 → 0.2553 … 0.3662; 0/20 → 0 … 0.1611.
        let r = Rate::wilson(81, 263);
        assert!((r.low - 0.2553).abs() < 5e-5 && (r.high - 0.3662).abs() < 5e-5, "{r:?}");
        let r = Rate::wilson(0, 20);
        assert!(r.low == 0.0 && (r.high - 0.1611).abs() < 5e-5, "{r:?}");
    }

    #[test]
    fn equal_decisions_of_a_group_count_once_and_single_ones_as_independent() {
        let alike = Rate::clustered(&[(10, 10), (0, 10), (0, 10), (0, 10), (10, 10), (0, 10)]);
        assert_eq!(alike, Rate::wilson(2, 6));
        assert_eq!(Rate::clustered(&[(0, 8), (0, 8), (0, 8)]), Rate::wilson(0, 3));
        assert_eq!(Rate::clustered(&[(1, 1), (0, 1), (0, 1), (0, 0)]), Rate::wilson(1, 3));
        assert!(Rate::clustered(&[]).value.is_nan());
    }

    /// The intervals contain the rate as often as they say, where those of independent decisions do not: groups whose
    /// own rates are spread around 20 % (5, 20 or 50 %).
    #[test]
    fn interval_of_groups_covers_the_rate() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let (draws, rates) = (1500, [0.05, 0.05, 0.05, 0.2, 0.2, 0.2, 0.2, 0.5, 0.3, 0.25]);
        let truth = rates.iter().sum::<f64>() / rates.len() as f64;
        let (mut covered, mut naive) = (0, 0);
        for _ in 0..draws {
            let groups: Vec<(usize, usize)> = (0..12)
                .map(|_| {
                    let own = rates[rng.random_range(0..rates.len())];
                    (0..30).fold((0, 0), |(k, n), _| (k + usize::from(rng.random_bool(own)), n + 1))
                })
                .collect();
            let inside = |rate: Rate| usize::from((rate.low..=rate.high).contains(&truth));
            covered += inside(Rate::clustered(&groups));
            let (k, n) = groups.iter().fold((0, 0), |sum, group| (sum.0 + group.0, sum.1 + group.1));
            naive += inside(Rate::wilson(k, n));
        }
        let share = |count: usize| count as f64 / f64::from(draws);
        // Standard deviation of the share at 95 %: 0.6 %; 12 groups are few for (1). Too wide an interval fails too.
        assert!((0.93..0.985).contains(&share(covered)), "{}", share(covered));
        assert!(share(naive) < 0.75, "{}", share(naive));
    }

    #[test]
    fn few_groups_have_the_design_effect_and_student_s_quantile() {
        // p = 0.4; (1) = 4/3 · (1 + 1 + 9 + 9)/40²; D = 2.7778; t of 3 degrees 3.182446: n* = 14.4 · (1.959964/t)².
        let rate = Rate::clustered(&[(3, 10), (5, 10), (1, 10), (7, 10)]);
        assert!((rate.value - 0.4).abs() < 1e-12, "{rate:?}");
        // Wilson's interval of 5.461809 decisions, by its formula in another program; seven digits of t.
        assert!((rate.low - 0.123_794_1).abs() < 1e-6 && (rate.high - 0.758_788_9).abs() < 1e-6, "{rate:?}");
    }

    #[test]
    fn both_sides_of_an_interval_are_widened() {
        let Rate { value, low, high } = Rate { value: 0.5, low: 0.4, high: 0.7 }.widened(1.5);
        assert!(value == 0.5 && (low - 0.35).abs() < 1e-12 && (high - 0.8).abs() < 1e-12, "{low} {high}");
    }
}
