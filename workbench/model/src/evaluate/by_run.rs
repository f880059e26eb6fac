//! False alarms of each run in order, with an interval that counts runs.
//!
//! Segments of a run are alike, so that Wilson's interval of all segments is too narrow.

use serde_json::{Value, json};

use super::{Rate, TraceVerdict};
use crate::core::Finding;

/// False alarms of one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunAlarms {
    /// Name of the run.
    pub name: String,
    /// Healthy traces or segments that are not called healthy.
    pub alarms: usize,
    /// All healthy traces or segments with a decision.
    pub judged: usize,
}

/// False alarms of runs in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FalseAlarms {
    /// The runs.
    pub runs: Vec<RunAlarms>,
}

impl FalseAlarms {
    /// Counts the healthy verdicts of each run, in the order of the first appearance; `runs` are those of the verdicts.
    #[must_use]
    pub fn of(verdicts: &[TraceVerdict], runs: &[String], healthy: usize, per_segment: bool) -> Self {
        let mut found = Self::default();
        for (verdict, run) in verdicts.iter().zip(runs).filter(|(verdict, _)| verdict.class == healthy) {
            let mut add = |finding: &Finding| found.add(run, *finding != Finding::Class(healthy));
            if per_segment {
                verdict.segments.iter().filter_map(|segment| segment.verdict.as_ref().ok()).for_each(add);
            } else {
                verdict.decided.iter().for_each(&mut add);
            }
        }
        found
    }

    /// Counts one decision.
    pub fn add(&mut self, run: &str, alarm: bool) {
        let place = self.runs.iter().position(|own| own.name == run).unwrap_or_else(|| {
            self.runs.push(RunAlarms { name: run.into(), alarms: 0, judged: 0 });
            self.runs.len() - 1
        });
        self.runs[place].alarms += usize::from(alarm);
        self.runs[place].judged += 1;
    }

    /// Numbers of alarms and of decisions.
    #[must_use]
    pub fn total(&self) -> (usize, usize) {
        self.runs.iter().fold((0, 0), |(alarms, judged), run| (alarms + run.alarms, judged + run.judged))
    }

    /// Rate of false alarms, with an interval that counts runs (`Rate::clustered`).
    #[must_use]
    pub fn rate(&self) -> Rate {
        Rate::clustered(&self.runs.iter().map(|run| (run.alarms, run.judged)).collect::<Vec<_>>())
    }

    /// Number of runs with an alarm.
    #[must_use]
    pub fn with_alarm(&self) -> usize {
        self.runs.iter().filter(|run| run.alarms > 0).count()
    }

    /// The sums in words, without each run.
    #[must_use]
    pub fn summary(&self) -> String {
        let ((alarms, judged), runs) = (self.total(), self.runs.len());
        format!("{alarms} of {judged}, {} by runs, in {} of {runs} runs", self.rate(), self.with_alarm())
    }

    /// JSON object with the keys `rate`, `runs_with_alarm`, `runs`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let each = |run: &RunAlarms| json!({ "run": run.name, "alarms": run.alarms, "judged": run.judged });
        json!({
            "rate": self.rate().to_json(),
            "runs_with_alarm": self.with_alarm(),
            "runs": self.runs.iter().map(each).collect::<Vec<_>>(),
        })
    }
}

impl std::fmt::Display for FalseAlarms {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let each: Vec<String> =
            self.runs.iter().map(|run| format!("{} {}/{}", run.name, run.alarms, run.judged)).collect();
        write!(f, "{}: {}", self.summary(), each.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_counts_runs() {
        let mut found = FalseAlarms::default();
        for (run, alarms) in [("5", 0), ("6", 4), ("7", 0), ("8", 1)] {
            (0..5).for_each(|k| found.add(run, k < alarms));
        }
        assert_eq!((found.total(), found.with_alarm()), ((5, 20), 2));
        // A quarter of four runs is one run.
        assert_eq!(found.rate(), Rate::wilson(1, 4));
        let text = found.to_string();
        assert!(
            text.starts_with("5 of 20, 25.0 % [") && text.ends_with("in 2 of 4 runs: 5 0/5, 6 4/5, 7 0/5, 8 1/5"),
            "{text}"
        );
    }

    #[test]
    fn each_healthy_verdict_that_is_not_healthy_is_a_false_alarm() {
        let verdict = |class: usize, decided: Option<Finding>| TraceVerdict {
            id: String::new(),
            class,
            decided,
            posteriors: vec![],
            segments: vec![],
        };
        let found = [Some(Finding::Class(0)), Some(Finding::Class(1)), Some(Finding::Novel), Some(Finding::Ambiguous)];
        let mut verdicts: Vec<TraceVerdict> = found.map(|finding| verdict(0, finding)).to_vec();
        verdicts.extend([verdict(0, None), verdict(1, Some(Finding::Class(1)))]);
        let runs = ["1", "1", "2", "2", "2", "2"].map(String::from);
        let alarms = FalseAlarms::of(&verdicts, &runs, 0, false);
        let run = |name: &str, alarms: usize| RunAlarms { name: name.into(), alarms, judged: 2 };
        assert_eq!(alarms.runs, [run("1", 1), run("2", 2)]);
    }
}
