//! Segments of runs judged by the other runs.

use rayon::prelude::*;

use super::law::equivalent;
use super::runs::{NextRun, next_run};
use crate::train::FeatureTable;
use crate::train::moments;

/// Parts of the runs, of which one at a time is judged by the others.
const FOLDS: usize = 10;

/// Returns the surprise of each segment by mean, covariance and law of other runs, with its run; none if these have no
/// law, or of fewer than ten runs. A tenth of the runs is left out at a time.
pub(super) fn surprises(table: &FeatureTable, runs: &[usize], count: usize) -> Vec<(f64, usize)> {
    if count < FOLDS {
        return vec![];
    }
    let of_fold = |fold: usize| -> Option<Vec<(f64, usize)>> {
        let (out, others): (Vec<usize>, Vec<usize>) = (0..runs.len()).partition(|&row| runs[row] % FOLDS == fold);
        let left = (0..count).filter(|run| run % FOLDS != fold).collect::<Vec<_>>();
        let numbers: Vec<usize> = others.iter().filter_map(|&row| left.binary_search(&runs[row]).ok()).collect();
        let NextRun { mean, covariance, law, spread } = next_run(&table.keep(&others), &numbers, left.len()).ok()?;
        // The law (4) needs more degrees of freedom than coordinates.
        (spread.freedom > mean.len() as f64).then_some(())?;
        let surprise = |&row: &usize| {
            let (value, variance) = (&table.rows[row], &table.variances[row]);
            let (squared, available) = moments::squared_distance((&mean, &covariance), value, variance)?;
            let squared = equivalent(squared, available, value.len());
            squared.is_finite().then(|| (law.surprise(squared), runs[row]))
        };
        out.iter().map(surprise).collect()
    };
    let all: Option<Vec<_>> = (0..FOLDS).into_par_iter().map(of_fold).collect();
    all.unwrap_or_default().concat()
}
