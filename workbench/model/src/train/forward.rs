//! Validation forward in time: a gate of the first runs judges all later ones.
//!
//! ```text
//! runs 1 … s ──► fit, gate for the next run ──► healthy segments of the runs s + 1 … k,   s = 2 … k − 1
//! ```
//!
//! Cross-validation judges each run by runs before and after it, and does not show what a drift does to a gate.

use serde_json::{Value, json};

use super::fit::fit;
use super::folds::check;
use super::novelty::Rows;
use super::{Explained, Trained, novelty};
use crate::Error;
use crate::evaluate::FalseAlarms;

/// Fewest healthy runs for a validation forward in time.
const LEAST_RUNS: usize = 4;

/// The gate of the first runs, judged on all later ones.
#[derive(Debug)]
pub struct Forward {
    /// Number of runs in training.
    pub seen: usize,
    /// False alarms of the later runs, or why there is no gate.
    pub later: Result<FalseAlarms, Error>,
}

impl Trained {
    /// Returns the gates of the first 2, 3, … healthy runs, judged on the later runs; none if the false-alarm rate is
    /// not that of the next run, or with fewer than four runs.
    #[must_use]
    pub fn forward(&self) -> Vec<Forward> {
        let Some(healthy) = self.recipe.alarms.healthy.filter(|_| self.recipe.runs(&self.candidates).is_some()) else {
            return vec![];
        };
        let rows = self.candidates.groups.iter().zip(&self.candidates.table.classes);
        let mut runs: Vec<usize> = rows.filter(|(_, class)| **class == healthy).map(|(run, _)| *run).collect();
        runs.sort_unstable();
        runs.dedup();
        if runs.len() < LEAST_RUNS {
            return vec![];
        }
        (2..runs.len()).map(|seen| Forward { seen, later: self.later(healthy, runs[seen]) }).collect()
    }

    /// Returns the false alarms from the run `first` on of a gate of the runs before it.
    fn later(&self, healthy: usize, first: usize) -> Result<FalseAlarms, Error> {
        let candidates = self.candidates.select(&self.candidates.places(&self.feature_names));
        let (before, after): (Vec<usize>, Vec<usize>) =
            (0..candidates.groups.len()).partition(|&row| candidates.groups[row] < first);
        let before = candidates.rows(&before);
        check(&before)?;
        let fitted = fit(&before, &self.recipe)?;
        let fitted_terms = fitted.explained.as_ref().map_or(0, Explained::fitted);
        let rising = self.recipe.rising(&fitted.coordinate_names);
        let (table, names) = (&fitted.coordinates, fitted.coordinate_names.as_slice());
        let rows = Rows { table, names, fitted: fitted_terms, rising };
        let gate = novelty::required_gate(rows, self.recipe.runs(&before).as_deref(), &self.recipe.alarms)?;
        let mut found = FalseAlarms::default();
        for row in after.into_iter().filter(|&row| candidates.table.classes[row] == healthy) {
            let (z, variances) = fitted.coordinates_of(&candidates, row);
            let run = &self.recipe.validation.groups[candidates.groups[row]];
            found.add(run, gate.is_novel(&z, &variances));
        }
        Ok(found)
    }
}

impl Forward {
    /// JSON object with the keys `runs_in_training` and either `false_alarms` or `refused`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        match &self.later {
            Ok(found) => json!({ "runs_in_training": self.seen, "false_alarms": found.to_json() }),
            Err(reason) => json!({ "runs_in_training": self.seen, "refused": reason.to_string() }),
        }
    }
}

impl Forward {
    /// A line a number of runs; one for all numbers in a row that have the same refusal.
    #[must_use]
    pub fn lines(all: &[Self]) -> Vec<String> {
        let refusal = |one: &Self| one.later.as_ref().err().map(ToString::to_string);
        let same = |a: &Self, b: &Self| refusal(a).is_some() && refusal(a) == refusal(b);
        let line = |alike: &[Self]| match alike {
            [first, .., last] => first.line(&format!(" to {}", last.seen)),
            _ => alike.iter().map(|one| one.line("")).collect(),
        };
        all.chunk_by(same).map(line).collect()
    }

    fn line(&self, until: &str) -> String {
        let start = format!("forward in time, first {}{until} runs: ", self.seen);
        match &self.later {
            Ok(found) => format!("{start}false alarms later {found}"),
            Err(reason) => format!("{start}no gate, {reason}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_of_several_numbers_of_runs_is_told_once() {
        let refused = |reason: &str| Err(Error::Training(reason.into()));
        let later = [
            refused("no spall"),
            refused("no spall"),
            refused("few runs"),
            Ok(FalseAlarms::default()),
            refused("no spall"),
        ];
        let all: Vec<Forward> = (2..).zip(later).map(|(seen, later)| Forward { seen, later }).collect();
        let lines = Forward::lines(&all);
        let starts =
            ["2 to 3 runs: no gate, no spall", "4 runs: no gate, few runs", "5 runs: false alarms", "6 runs: no"];
        assert_eq!(lines.len(), starts.len());
        for (line, start) in lines.iter().zip(starts) {
            assert!(line.starts_with(&format!("forward in time, first {start}")), "{line}");
        }
    }
}
