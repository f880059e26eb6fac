//! Counts of decisions by true and decided class, and their rates.

use serde_json::{Value, json};

use super::Rate;
use crate::core::Finding;

/// Counts of decisions: one row per true class, one column per decided class, then one column each for undetermined,
/// novel and ambiguous decisions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Confusion {
    /// Class names.
    pub classes: Vec<String>,
    /// `counts[true][decided]`; after the n classes, column n counts undetermined decisions, n + 1 novel, n + 2
    /// ambiguous ones.
    pub counts: Vec<Vec<usize>>,
    /// The same counts of each group (run, drive, trace with several segments), whose decisions are alike; empty if
    /// all decisions are independent.
    pub by_group: Vec<Vec<Vec<usize>>>,
    /// Index of the healthy class, if there is one.
    pub healthy: Option<usize>,
}

/// Names of the columns after the classes.
const OTHERS: [&str; 3] = ["undetermined", "novel", "ambiguous"];

impl Confusion {
    /// Counts of zero.
    #[must_use]
    pub fn new(classes: &[String]) -> Self {
        Self { classes: classes.to_vec(), counts: zeros(classes.len()), by_group: vec![], healthy: None }
    }

    /// Counts of zero for decisions of so many groups.
    pub(crate) fn of_groups(classes: &[String], groups: usize) -> Self {
        Self { by_group: vec![zeros(classes.len()); groups], ..Self::new(classes) }
    }

    /// Counts one finding of a group.
    pub(crate) fn add_of_group(&mut self, group: usize, truth: usize, finding: Option<Finding>) {
        let column = self.column(finding);
        self.counts[truth][column] += 1;
        self.by_group[group][truth][column] += 1;
    }

    fn column(&self, finding: Option<Finding>) -> usize {
        let n = self.classes.len();
        match finding {
            Some(Finding::Class(class)) => class,
            None => n,
            Some(Finding::Novel) => n + 1,
            Some(Finding::Ambiguous) => n + 2,
        }
    }

    /// The rate k/n of counts, with an interval that considers the groups.
    fn rate(&self, of: impl Fn(&[Vec<usize>]) -> (usize, usize)) -> Rate {
        if self.by_group.is_empty() {
            let (k, n) = of(&self.counts);
            return Rate::wilson(k, n);
        }
        Rate::clustered(&self.by_group.iter().map(|counts| of(counts)).collect::<Vec<_>>())
    }

    /// Counts one decision.
    pub fn add(&mut self, truth: usize, decided: Option<usize>) {
        let undetermined = self.classes.len();
        self.counts[truth][decided.unwrap_or(undetermined)] += 1;
    }

    /// Total number of decisions.
    #[must_use]
    pub fn total(&self) -> usize {
        self.counts.iter().flatten().sum()
    }

    /// Number of decisions that are wrong, undetermined, novel or ambiguous.
    #[must_use]
    pub fn wrong(&self) -> usize {
        wrong(&self.counts).0
    }

    /// Fraction of each defect class decided as healthy; `None` for the healthy class and for classes that did not
    /// occur.
    #[must_use]
    pub fn called_healthy(&self) -> Vec<Option<Rate>> {
        let each = |(k, row): (usize, &Vec<usize>)| {
            let healthy = self.healthy?;
            let rate = || self.rate(|counts| (counts[k][healthy], counts[k].iter().sum()));
            (k != healthy && row.iter().sum::<usize>() > 0).then(rate)
        };
        self.counts.iter().enumerate().map(each).collect()
    }

    /// Fraction of decisions that are wrong, undetermined, novel or ambiguous.
    #[must_use]
    pub fn error_rate(&self) -> Rate {
        self.rate(wrong)
    }

    /// Fraction of each class decided correctly; `None` for classes that did not occur.
    #[must_use]
    pub fn recalls(&self) -> Vec<Option<Rate>> {
        let rows = self.counts.iter().enumerate();
        let right = |k: usize| self.rate(|counts| (counts[k][k], counts[k].iter().sum()));
        rows.map(|(k, row)| (row.iter().sum::<usize>() > 0).then(|| right(k))).collect()
    }

    /// Mean of the recalls of the classes that occurred.
    #[must_use]
    pub fn balanced_accuracy(&self) -> Rate {
        let recalls = self.recalls();
        let mean = Rate::mean(&recalls.iter().copied().flatten().collect::<Vec<_>>());
        mean.widened(self.shared_between_classes(&recalls))
    }

    /// The factor between the standard error of the mean of the recalls and that of independent recalls: a group that
    /// holds several classes makes all of them better or worse together. At least 1.
    fn shared_between_classes(&self, recalls: &[Option<Rate>]) -> f64 {
        let all = |k: usize| self.counts[k].iter().sum::<usize>() as f64;
        let part = |counts: &[Vec<usize>], k: usize| {
            let (n, right) = (counts[k].iter().sum::<usize>() as f64, counts[k][k] as f64);
            recalls[k].map_or(0.0, |recall| (right - recall.value * n) / all(k))
        };
        let (mut together, mut apart) = (0.0, 0.0);
        for counts in &self.by_group {
            let parts: Vec<f64> = (0..recalls.len()).map(|k| part(counts, k)).collect();
            together += parts.iter().sum::<f64>().powi(2);
            apart += parts.iter().map(|part| part * part).sum::<f64>();
        }
        if apart > 0.0 { (together / apart).sqrt().max(1.0) } else { 1.0 }
    }

    /// JSON object with the keys `classes`, `confusion`, `undetermined`, `novel`, `ambiguous`, `called_healthy`,
    /// `error_rate`, `balanced_accuracy`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let n = self.classes.len();
        let column = |k: usize| self.counts.iter().map(|row| row[k]).collect::<Vec<_>>();
        json!({
            "classes": self.classes,
            "confusion": self.counts.iter().map(|row| &row[..n]).collect::<Vec<_>>(),
            "undetermined": column(n),
            "novel": column(n + 1),
            "ambiguous": column(n + 2),
            "called_healthy": self.called_healthy().iter().map(|rate| rate.map(Rate::to_json)).collect::<Vec<_>>(),
            "error_rate": self.error_rate().to_json(),
            "balanced_accuracy": self.balanced_accuracy().to_json(),
        })
    }
}

/// Counts of zero: a row a class, a column a class and one for each other decision.
fn zeros(classes: usize) -> Vec<Vec<usize>> {
    vec![vec![0; classes + OTHERS.len()]; classes]
}

/// Numbers of decisions that are not right, and of all.
fn wrong(counts: &[Vec<usize>]) -> (usize, usize) {
    let total: usize = counts.iter().flatten().sum();
    (total - counts.iter().enumerate().map(|(k, row)| row[k]).sum::<usize>(), total)
}

impl std::fmt::Display for Confusion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let n = self.classes.len();
        let others = OTHERS.iter().zip(n..).filter(|(_, k)| self.counts.iter().any(|row| row[*k] > 0));
        let names = self.classes.iter().map(String::as_str).zip(0..).chain(others.map(|(name, k)| (*name, k)));
        let names: Vec<(&str, usize)> = names.collect();
        let first = self.classes.iter().map(String::len).max().unwrap_or(0).max("true \\ decided".len());
        write!(f, "{:first$}", "true \\ decided")?;
        names.iter().try_for_each(|(name, _)| write!(f, "  {name:>5}"))?;
        writeln!(f, "  right [95 %]")?;
        for ((class, row), recall) in self.classes.iter().zip(&self.counts).zip(self.recalls()) {
            write!(f, "{class:first$}")?;
            for (name, k) in &names {
                write!(f, "  {count:>width$}", count = row[*k], width = name.len().max(5))?;
            }
            writeln!(f, "  {}", recall.map_or_else(|| "none seen".into(), |rate| rate.to_string()))?;
        }
        for (class, rate) in self.classes.iter().zip(self.called_healthy()) {
            if let Some(rate) = rate {
                writeln!(f, "{class:first$}  called healthy {rate}")?;
            }
        }
        let (error, balanced) = (self.error_rate(), self.balanced_accuracy());
        write!(f, "error rate {error} of {}, balanced accuracy {balanced}", self.total())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balanced_accuracy_weighs_classes_alike() {
        let mut confusion = Confusion::new(&["a".into(), "b".into()]);
        for _ in 0..98 {
            confusion.add(0, Some(0));
        }
        confusion.add(1, Some(0));
        confusion.add(1, None);
        assert!(!confusion.to_string().contains("novel"));
        assert_eq!((confusion.wrong(), confusion.total()), (2, 100));
        let balanced = confusion.balanced_accuracy();
        assert!((balanced.value - 0.5).abs() < 1e-12 && balanced.low < 0.5 && balanced.high > 0.7, "{balanced:?}");
        assert!(confusion.to_string().contains("undetermined"));
    }

    #[test]
    fn novel_is_wrong_but_not_called_healthy() {
        let mut confusion =
            Confusion { healthy: Some(0), ..Confusion::of_groups(&["healthy".into(), "spall".into()], 1) };
        for finding in [Finding::Class(1), Finding::Novel, Finding::Ambiguous, Finding::Class(0)] {
            confusion.add_of_group(0, 1, Some(finding));
        }
        confusion.add_of_group(0, 0, Some(Finding::Novel));
        let json = confusion.to_json();
        assert_eq!((&json["novel"], &json["ambiguous"]), (&json!([1, 1]), &json!([0, 1])));
        assert_eq!((confusion.wrong(), json["called_healthy"][1]["value"].as_f64()), (4, Some(0.25)));
        let text = confusion.to_string();
        assert!(
            text.contains("novel") && text.contains("called healthy 25.0 %") && !text.contains("undeter"),
            "{text}"
        );
    }

    #[test]
    fn classes_of_the_same_groups_are_right_together() {
        let mut confusion = Confusion::of_groups(&["a".into(), "b".into()], 2);
        for (group, class) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            // All right in the first group, none in the second one.
            let decided = if group == 0 { class } else { 1 - class };
            (0..4).for_each(|_| confusion.add_of_group(group, class, Some(Finding::Class(decided))));
        }
        // A recall is one of two groups; both recalls are the same number, so that their mean is as uncertain as one.
        let (one, mean) = (Rate::wilson(1, 2), confusion.balanced_accuracy());
        assert!((mean.low - one.low).abs() < 1e-12 && (mean.high - one.high).abs() < 1e-12, "{mean:?} {one:?}");
    }
}
