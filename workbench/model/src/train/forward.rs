//! False alarms of gates that have not seen what they judge: of folds, and forward in time.
//!
//! ```text
//! runs 1 … s ──► fit, gate for the next run ──► healthy segments of the runs s + 1 … k,   s = 2 … k − 1
//! rows outside a fold ──► fit, gate ──► healthy segments of the fold
//! ```
//!
//! Cross-validation judges each run by runs before and after it, and does not show what a drift does to a gate.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::fit::fit;
use super::folds::{Candidates, Folds, check};
use super::novelty::Rows;
use super::{Explained, Trained, novelty};
use crate::Error;
use crate::evaluate::FalseAlarms;

/// Fewest healthy runs for a validation forward in time.
const LEAST_RUNS: usize = 4;
/// Most rows of the printed table.
const MOST_ROWS: usize = 12;

/// The run of a segment, and whether a gate calls the segment novel.
type Judged = (String, bool);

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
        (2..runs.len()).into_par_iter().map(|seen| Forward { seen, later: self.later(healthy, runs[seen]) }).collect()
    }

    /// Returns the false alarms from the run `first` on of a gate of the runs before it.
    fn later(&self, healthy: usize, first: usize) -> Result<FalseAlarms, Error> {
        let candidates = self.candidates.select(&self.candidates.places(&self.feature_names));
        let (before, after): (Vec<usize>, Vec<usize>) =
            (0..candidates.groups.len()).partition(|&row| candidates.groups[row] < first);
        let mut alarms = FalseAlarms::default();
        let judged = self.judge((&candidates, healthy), (&before, &after))?;
        judged.iter().for_each(|(run, is_novel)| alarms.add(run, *is_novel));
        Ok(alarms)
    }

    /// Returns the false alarms of healthy segments, each by a gate without its fold; `None` without a gate.
    #[must_use]
    pub fn false_alarms(&self) -> Option<Result<FalseAlarms, Error>> {
        let healthy = self.watch.gate.as_ref()?.class;
        let candidates = self.candidates.select(&self.candidates.places(&self.feature_names));
        let all = || {
            let folds = Folds::new(&candidates, &self.recipe.validation)?;
            let judge = |fold: usize| {
                let (seen, held_out) = folds.split(fold);
                self.judge((&candidates, healthy), (&seen, &held_out))
            };
            // As a list first: the first fold without a gate is told, whichever thread is first.
            let judged: Vec<Result<Vec<Judged>, Error>> = (0..folds.count).into_par_iter().map(judge).collect();
            let mut alarms = FalseAlarms::default();
            for fold in judged {
                fold?.iter().for_each(|(run, is_novel)| alarms.add(run, *is_novel));
            }
            Ok(alarms)
        };
        Some(all())
    }

    /// Judges the healthy rows of `after` by a gate of the rows `before`.
    fn judge(
        &self,
        (candidates, healthy): (&Candidates, usize),
        (before, after): (&[usize], &[usize]),
    ) -> Result<Vec<Judged>, Error> {
        let before = candidates.rows(before);
        check(&before)?;
        let fitted = fit(&before, &self.recipe)?;
        let fitted_terms = fitted.explained.as_ref().map_or(0, Explained::fitted);
        let rising = self.recipe.rising(&fitted.coordinate_names);
        let (table, names) = (&fitted.coordinates, fitted.coordinate_names.as_slice());
        let rows = Rows { table, names, fitted: fitted_terms, rising };
        let gate = novelty::required_gate(rows, self.recipe.runs(&before).as_deref(), &self.recipe.alarms)?;
        let judge = |row: usize| {
            let (z, variances) = fitted.coordinates_of(candidates, row);
            let group = candidates.groups[row];
            let run = self.recipe.validation.groups.get(group).cloned().unwrap_or_else(|| group.to_string());
            (run, gate.is_novel(&z, &variances))
        };
        let healthy_rows = after.iter().copied().filter(|&row| candidates.table.classes[row] == healthy);
        Ok(healthy_rows.map(judge).collect())
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
    /// A table with a row for a number of runs, or for all numbers in a row that have the same refusal; of many numbers
    /// every n-th.
    #[must_use]
    pub fn lines(all: &[Self]) -> Vec<String> {
        let refusal = |one: &Self| one.later.as_ref().err().map(ToString::to_string);
        let same = |a: &Self, b: &Self| refusal(a).is_some() && refusal(a) == refusal(b);
        let alike: Vec<&[Self]> = all.chunk_by(same).collect();
        let step = alike.len().div_ceil(MOST_ROWS).max(1);
        let every =
            if step > 1 { format!(" (every {step}-th row of {}; --json has all)", alike.len()) } else { String::new() };
        let title = format!("forward in time, gates of the first runs on later ones{every}:");
        let shown = alike.iter().enumerate().filter(|(k, _)| k % step == 0 || k + 1 == alike.len());
        let rows =
            shown.filter_map(|(_, own)| Some((own.first()?, own.last()?))).map(|(one, last)| one.line(last.seen));
        (!all.is_empty()).then_some(title).into_iter().chain(rows).collect()
    }

    fn line(&self, until: usize) -> String {
        let runs = if until > self.seen { format!("{} to {until}", self.seen) } else { self.seen.to_string() };
        let found = match &self.later {
            Ok(found) => found.summary(),
            Err(reason) => format!("no gate, {reason}"),
        };
        format!("  {runs:>10} runs  {found}")
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
        let starts = [
            "2 to 3 runs  no gate, no spall",
            "4 runs  no gate, few runs",
            "5 runs  0 of 0",
            "6 runs  no gate, no spall",
        ];
        assert_eq!(lines.len(), starts.len() + 1);
        for (line, start) in lines[1..].iter().zip(starts) {
            assert!(line.trim_start().starts_with(start), "{line}");
        }
    }

    #[test]
    fn many_numbers_of_runs_are_a_short_table() {
        let all: Vec<Forward> = (2..334).map(|seen| Forward { seen, later: Ok(FalseAlarms::default()) }).collect();
        let lines = Forward::lines(&all);
        assert!(lines.len() <= MOST_ROWS + 2 && lines[0].contains("every 28-th row of 332"), "{lines:?}");
        assert!(lines[1].contains(" 2 runs") && lines[lines.len() - 1].contains(" 333 runs"), "{lines:?}");
        assert_eq!(Forward::lines(&[]), Vec::<String>::new());
    }
}
