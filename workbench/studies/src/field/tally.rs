//! Counts of verdicts, and rates with intervals over several draws.

use model::evaluate::Rate;

/// Counts of the verdicts on records of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Number of records with the counted outcome: detected, or wrong class.
    pub counted: usize,
    /// Number of records with the opposite outcome: called healthy, or right class.
    pub opposite: usize,
    /// Number of records without a verdict.
    pub undetermined: usize,
}

impl Tally {
    /// Counts the outcomes; `None` is a record without a verdict.
    #[must_use]
    pub fn of(outcomes: impl IntoIterator<Item = Option<bool>>) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            match outcome {
                Some(true) => tally.counted += 1,
                Some(false) => tally.opposite += 1,
                None => tally.undetermined += 1,
            }
        }
        tally
    }

    /// Number of judged records, with or without a verdict.
    #[must_use]
    pub const fn judged(&self) -> usize {
        self.counted + self.opposite + self.undetermined
    }

    /// The same counts with the undetermined records among the counted ones.
    #[must_use]
    pub const fn undetermined_counted(self) -> Self {
        Self { counted: self.counted + self.undetermined, undetermined: 0, ..self }
    }

    /// The counts of undetermined records: they are counted, all others are not.
    #[must_use]
    pub const fn of_undetermined(self) -> Self {
        Self { counted: self.undetermined, opposite: self.counted + self.opposite, undetermined: 0 }
    }
}

/// Rate of the counted records among all judged records of all draws, with a 95 % interval.
///
/// The records of one draw share a trained detector, so they are not independent. The interval is Wilson's for an
/// effective number of records (1): the number of records, divided by the factor by which the variance between draws
/// exceeds that of independent records.
///
/// ```text
/// n_eff = n/max(1, s²·m/(p (1 − p)))    n records in all, m a draw, s² the variance of the draws' rates      (1)
/// ```
///
/// From one draw s² is not known, and n_eff = n: the interval then holds for this one detector. From a few draws s² is
/// uncertain, and so is the interval.
#[must_use]
pub fn rate(draws: &[Tally]) -> Rate {
    let sum = |count: fn(&Tally) -> usize| draws.iter().map(count).sum::<usize>() as f64;
    let (counted, judged) = (sum(|tally| tally.counted), sum(Tally::judged));
    let p = counted / judged;
    let draws_variance = |count: f64| {
        let squares = draws.iter().map(|tally| (tally.counted as f64 - p * tally.judged() as f64).powi(2));
        squares.sum::<f64>() / (count - 1.0)
    };
    let count = draws.len() as f64;
    let varies = count > 1.0 && p > 0.0 && p < 1.0;
    // s²·m/(p (1 − p)), with the deviations in records.
    let factor = if varies { draws_variance(count) / (judged / count * p * (1.0 - p)) } else { 1.0 };
    let effective = judged / factor.max(1.0);
    Rate::wilson_of(p * effective, effective)
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn tally(counted: usize, judged: usize) -> Tally {
        Tally { counted, opposite: judged - counted, undetermined: 0 }
    }

    #[test]
    fn counts_add_up() {
        let outcomes = [Some(true), None, Some(false), Some(true), None, None];
        let counts = Tally::of(outcomes);
        assert_eq!(counts, Tally { counted: 2, opposite: 1, undetermined: 3 });
        for other in [counts, counts.undetermined_counted(), counts.of_undetermined()] {
            assert_eq!(other.judged(), 6);
        }
        assert_eq!((counts.undetermined_counted().counted, counts.of_undetermined().counted), (5, 3));
    }

    #[test]
    fn equal_draws_have_the_interval_of_their_records() {
        assert_eq!(rate(&[tally(30, 60); 4]), Rate::wilson(120, 240));
        for counted in 0..=60 {
            let (found, expected) = (rate(&[tally(counted, 60)]), Rate::wilson(counted, 60));
            assert!(
                (found.low - expected.low).abs() < 1e-12 && (found.high - expected.high).abs() < 1e-12,
                "{counted}"
            );
        }
        assert_eq!(rate(&[tally(0, 60); 3]), Rate::wilson(0, 180));
        assert_eq!(rate(&[tally(60, 60); 3]), Rate::wilson(180, 180));
    }

    #[test]
    fn unequal_draws_have_a_wider_interval() {
        // Rates 0.4 and 0.6 of 100 records: s² = 0.02, and that of independent records is 0.0025; a factor of 8.
        let found = rate(&[tally(40, 100), tally(60, 100)]);
        let expected = Rate::wilson_of(12.5, 25.0);
        assert!((found.low - expected.low).abs() < 1e-12 && (found.high - expected.high).abs() < 1e-12, "{found:?}");
        assert!(rate(&[]).value.is_nan());
    }
}
