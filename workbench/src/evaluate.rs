//! Performance of a model on traces that were not used for training, by running the core on them.

mod by_run;

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::Error;
use crate::core::{Embedded, Finding, SegmentReport};
use crate::trace::labels::LabelledTrace;

pub use by_run::{FalseAlarms, RunAlarms};

/// Counts of decisions: one row per true class, one column per decided class, then one column each for undetermined,
/// novel and ambiguous decisions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Confusion {
    /// Class names.
    pub classes: Vec<String>,
    /// `counts[true][decided]`; after the n classes, column n counts undetermined decisions, n + 1 novel, n + 2
    /// ambiguous ones.
    pub counts: Vec<Vec<usize>>,
    /// Index of the healthy class, if there is one.
    pub healthy: Option<usize>,
}

/// Names of the columns after the classes.
const OTHERS: [&str; 3] = ["undetermined", "novel", "ambiguous"];

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
        /// 97.5 % quantile of the normal distribution.
        const Q: f64 = 1.959_963_984_540_054;
        if n <= 0.0 {
            return Self { value: f64::NAN, low: 0.0, high: 1.0 };
        }
        let p = k / n;
        let centre = (p + Q * Q / (2.0 * n)) / (1.0 + Q * Q / n);
        let half = Q / (1.0 + Q * Q / n) * (p * (1.0 - p) / n + Q * Q / (4.0 * n * n)).sqrt();
        // At 0 and n the interval ends exactly at the rate; the clamp prevents rounding from moving it beyond.
        Self { value: p, low: (centre - half).clamp(0.0, p), high: (centre + half).clamp(p, 1.0) }
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

impl Confusion {
    /// Counts of zero.
    #[must_use]
    pub fn new(classes: &[String]) -> Self {
        let counts = vec![vec![0; classes.len() + OTHERS.len()]; classes.len()];
        Self { classes: classes.to_vec(), counts, healthy: None }
    }

    /// Counts one finding; `None` counts as undetermined.
    pub fn add_finding(&mut self, truth: usize, finding: Option<Finding>) {
        let n = self.classes.len();
        let column = match finding {
            Some(Finding::Class(class)) => class,
            None => n,
            Some(Finding::Novel) => n + 1,
            Some(Finding::Ambiguous) => n + 2,
        };
        self.counts[truth][column] += 1;
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
        self.total() - (0..self.classes.len()).map(|k| self.counts[k][k]).sum::<usize>()
    }

    /// Fraction of each defect class decided as healthy; `None` for the healthy class and for classes that did not
    /// occur.
    #[must_use]
    pub fn called_healthy(&self) -> Vec<Option<Rate>> {
        let each = |(k, row): (usize, &Vec<usize>)| {
            let (n, healthy) = (row.iter().sum(), self.healthy?);
            (k != healthy && n > 0).then(|| Rate::wilson(row[healthy], n))
        };
        self.counts.iter().enumerate().map(each).collect()
    }

    /// Fraction of decisions that are wrong, undetermined, novel or ambiguous.
    #[must_use]
    pub fn error_rate(&self) -> Rate {
        Rate::wilson(self.wrong(), self.total())
    }

    /// Fraction of each class decided correctly; `None` for classes that did not occur.
    #[must_use]
    pub fn recalls(&self) -> Vec<Option<Rate>> {
        let rows = self.counts.iter().enumerate();
        rows.map(|(k, row)| {
            let n: usize = row.iter().sum();
            (n > 0).then(|| Rate::wilson(row[k], n))
        })
        .collect()
    }

    /// Mean of the recalls of the classes that occurred.
    #[must_use]
    pub fn balanced_accuracy(&self) -> Rate {
        Rate::mean(&self.recalls().into_iter().flatten().collect::<Vec<_>>())
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

/// Verdicts on one labelled trace.
#[derive(Clone, Debug)]
pub struct TraceVerdict {
    /// Trace id.
    pub id: String,
    /// True class.
    pub class: usize,
    /// Verdict over the whole trace.
    pub decided: Option<Finding>,
    /// Posteriors over the whole trace; empty if undetermined.
    pub posteriors: Vec<f32>,
    /// Its segments.
    pub segments: Vec<SegmentReport>,
}

/// Runs traces through the core; `done` is called once per trace.
///
/// # Errors
/// The core rejects the model.
pub fn run(model: &Embedded, traces: &[LabelledTrace], done: impl Fn() + Sync) -> Result<Vec<TraceVerdict>, Error> {
    let each = |labelled: &LabelledTrace| {
        let segments = model.run(&labelled.trace);
        let (decided, posteriors) = model.combine(&segments).unzip();
        done();
        Ok(TraceVerdict {
            id: labelled.trace.id.clone(),
            class: labelled.class,
            decided,
            posteriors: posteriors.unwrap_or_default(),
            segments,
        })
    };
    traces.par_iter().map(each).collect()
}

/// Counts verdicts per trace or per segment.
#[must_use]
pub fn count(classes: &[String], verdicts: &[TraceVerdict], per_segment: bool) -> Confusion {
    let mut confusion = Confusion::new(classes);
    for verdict in verdicts {
        if per_segment {
            for segment in &verdict.segments {
                confusion.add_finding(verdict.class, segment.verdict.clone().ok());
            }
        } else {
            confusion.add_finding(verdict.class, verdict.decided);
        }
    }
    confusion
}

#[cfg(test)]
mod tests {
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
        let mut confusion = Confusion { healthy: Some(0), ..Confusion::new(&["healthy".into(), "spall".into()]) };
        for finding in [Finding::Class(1), Finding::Novel, Finding::Ambiguous, Finding::Class(0)] {
            confusion.add_finding(1, Some(finding));
        }
        confusion.add_finding(0, Some(Finding::Novel));
        let json = confusion.to_json();
        assert_eq!((&json["novel"], &json["ambiguous"]), (&json!([1, 1]), &json!([0, 1])));
        assert_eq!((confusion.wrong(), json["called_healthy"][1]["value"].as_f64()), (4, Some(0.25)));
        let text = confusion.to_string();
        assert!(
            text.contains("novel") && text.contains("called healthy 25.0 %") && !text.contains("undeter"),
            "{text}"
        );
    }
}
