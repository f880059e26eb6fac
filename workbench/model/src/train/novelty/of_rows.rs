//! Healthy segments → the novelty gate.
//!
//! The twin of this room is [`super::of_sums`], which has sums of the segments only.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use super::alarms::Alarms;
use super::gate::{Counted, Gate, GateOrReason, checked, scarcity};
use super::laws::law::{self, DistanceLaw, equivalent};
use super::laws::rising::Rising;
use super::laws::score::ScoreLaw;
use super::laws::{knots, spread};
use super::runs::{self, NextRun, RunSpread, next_run};
use crate::Error;
use crate::train::FeatureTable;
use crate::train::distribution::covariance::{singular, whitening};
use crate::train::distribution::moments::{self, Moments};
use crate::train::distribution::statistics::ClassStatistics;

/// Probability that any coordinate seems skewed if none is.
const IMPROBABLE: f64 = 0.01;

/// Coordinates of training segments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a> {
    pub(crate) table: &'a FeatureTable,
    pub(crate) names: &'a [String],
    /// Number of coefficients of covariates that were fitted to their features.
    pub(crate) fitted: usize,
    /// Number of the last coordinates, of which only larger values than usual are a defect.
    pub(crate) rising: usize,
}

/// Returns the gate of the healthy class, or why there is none.
///
/// # Errors
/// Settings out of range; no gate although one is required.
pub(super) fn gate(
    Rows { table, names, fitted, rising }: Rows<'_>,
    runs: Option<&[usize]>,
    alarms: &Alarms,
) -> Result<GateOrReason, Error> {
    let class = alarms.healthy.ok_or_else(|| Error::Training("no healthy class".into()))?;
    let healthy = Healthy { fitted, ..Healthy::of(table, class, runs) };
    let scarcity = || healthy.scarcity(names, alarms.false_alarm);
    checked(alarms, scarcity, || healthy.gate(class, (names, rising), alarms.false_alarm))
}

/// Returns the gate of the healthy class; too few rows are an error.
pub(crate) fn required_gate(rows: Rows<'_>, runs: Option<&[usize]>, alarms: &Alarms) -> Result<Gate, Error> {
    let alarms = Alarms { required: true, ..alarms.clone() };
    gate(rows, runs, &alarms)?.map_err(Error::Training)
}

/// Returns the gate of a table of healthy rows alone, whose values may have errors or be missing; of rows with runs,
/// each with a number in the order of time, that for the next run.
///
/// # Errors
/// Too few rows or runs for the rate, or coordinates that are constant or depend on each other.
pub fn gate_of_runs(table: &FeatureTable, runs: Option<&[usize]>, rate: f64) -> Result<Gate, Error> {
    gate_of_rising(table, runs, 0, rate)
}

/// Returns the gate for the next run of a table whose last `rising` coordinates only become larger with a defect.
///
/// # Errors
/// As [`gate_of_runs`].
pub fn gate_of_rising(table: &FeatureTable, runs: Option<&[usize]>, rising: usize, rate: f64) -> Result<Gate, Error> {
    let names: Vec<String> = (1..=table.rows.first().map_or(0, DVector::len)).map(|k| format!("z{k}")).collect();
    let rows = Rows { table, names: &names, fitted: 0, rising };
    required_gate(rows, runs, &Alarms { healthy: Some(0), false_alarm: rate, ..Alarms::default() })
}

/// Returns the skewness of values, relative to its standard deviation if they are normal; 0 of fewer than eight.
fn skewness(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    if n < 8.0 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / n;
    let moment = |power: i32| values.iter().map(|x| (x - mean).powi(power)).sum::<f64>() / n;
    let deviation = (6.0 * (n - 2.0) / ((n + 1.0) * (n + 3.0))).sqrt();
    let skewness = moment(3) / moment(2).powf(1.5) / deviation;
    if skewness.is_finite() { skewness } else { 0.0 }
}

/// Returns the number of rows of a class that have the coordinate which is missing most often, and this coordinate; all
/// rows and none if no coordinate is missing.
fn rows_of(table: &FeatureTable, class: usize) -> (usize, Option<usize>) {
    let rows = table.classes.iter().filter(|c| **c == class).count();
    let coordinates = table.rows.first().map_or(0, DVector::len);
    let with = |k: usize| (table.with(class, k).count(), Some(k));
    (0..coordinates).map(with).filter(|(count, _)| *count < rows).min().unwrap_or((rows, None))
}

/// The healthy rows of a table, and their runs if these count.
struct Healthy {
    table: FeatureTable,
    /// Run of each row, from 0 in their order, and the number of runs.
    runs: Option<(Vec<usize>, usize)>,
    /// Number of coefficients that were fitted to a feature beforehand; each takes a degree of freedom.
    fitted: usize,
}

impl Healthy {
    fn of(table: &FeatureTable, class: usize, runs: Option<&[usize]>) -> Self {
        let own: Vec<usize> = (0..table.rows.len()).filter(|&row| table.classes[row] == class).collect();
        let mut healthy = table.keep(&own);
        (healthy.classes, healthy.names) = (vec![0; own.len()], vec![table.names[class].clone()]);
        let Some(runs) = runs else { return Self { table: healthy, runs: None, fitted: 0 } };
        let of_rows: Vec<usize> = own.iter().map(|&row| runs[row]).collect();
        let (rows, numbers, count) = runs::complete(&healthy, &of_rows);
        // Runs of one segment each are independent segments.
        let single = numbers.len() == count && count == own.len();
        let kept = if single { healthy } else { healthy.keep(&rows) };
        Self { table: kept, runs: (!single).then_some((numbers, count)), fitted: 0 }
    }

    /// Says why there are too few segments or runs for a gate at this rate.
    fn scarcity(&self, names: &[String], rate: f64) -> Option<String> {
        let counted = match &self.runs {
            Some((_, count)) => Counted::Runs(*count),
            None => Counted::Rows(rows_of(&self.table, 0)),
        };
        scarcity(counted, self.fitted, names, rate)
    }

    /// Factor of a covariance of so many rows or runs whose coefficients took degrees of freedom.
    fn wider(&self, rows: usize) -> f64 {
        let freedom = rows.saturating_sub(1) as f64;
        freedom / (freedom - self.fitted as f64).max(1.0)
    }

    fn gate(&self, class: usize, (names, rising): (&[String], usize), rate: f64) -> Result<Gate, Error> {
        let (healthy, all, rows) = (&self.table, names.len(), self.table.rows.len());
        let refuse = |dependent| singular(&format!("class {}", healthy.names[0]), rows, 1, names, dependent);
        let (limit, rows_needed) = (-rate.ln(), spread::rows_needed(all, rate));
        // The law of a rising coordinate is skewed where its scores are.
        let skewed = self.skewed(&names[..all - rising]);
        let gate = |mean, covariance, law: DistanceLaw, runs: Option<RunSpread>| {
            let freedom = runs.as_ref().map_or(rows as f64 - 1.0, |runs| runs.freedom);
            let rising = self.rising(rising, (&mean, &covariance), freedom, (names, rate))?;
            let knots = knots::knots(&law, limit);
            let skewed = skewed.clone();
            Ok(Gate { class, mean, covariance, knots, limit, law, rising, rows, runs, rows_needed, skewed })
        };
        if let Some((runs, count)) = &self.runs {
            let runs::NextRun { mean, covariance, law, spread } =
                runs::next_run(healthy, runs, *count).map_err(refuse)?;
            let covariance = covariance * self.wider(*count);
            let law = law.corrected(&surprises(healthy, runs, *count), skewed.is_some());
            return gate(mean, covariance, law, Some(spread));
        }
        let statistics = ClassStatistics::of(healthy, names)?;
        let (mean, covariance) = (statistics.means[0].clone(), statistics.pooled * self.wider(rows));
        whitening(&covariance).map_err(refuse)?;
        let law = self.law((&mean, &covariance), (all, skewed.is_some())).ok_or_else(|| refuse(0))?;
        gate(mean, covariance, law, None)
    }

    /// Returns the coordinate that is most skewed, of the means of runs if these count; `None` if none is.
    fn skewed(&self, names: &[String]) -> Option<String> {
        let available = |row: &usize, k: usize| self.table.variances[*row][k].is_finite();
        let values = |k: usize| -> Vec<f64> {
            let rows = (0..self.table.rows.len()).filter(|row| available(row, k));
            let Some((runs, count)) = &self.runs else { return rows.map(|row| self.table.rows[row][k]).collect() };
            let mut sums = vec![(0.0, 0.0); *count];
            rows.for_each(|row| {
                let sum = &mut sums[runs[row]];
                *sum = (sum.0 + self.table.rows[row][k], sum.1 + 1.0);
            });
            sums.into_iter().filter(|(_, n)| *n > 0.0).map(|(sum, n)| sum / n).collect()
        };
        let scores = names.iter().enumerate().map(|(k, name)| (skewness(&values(k)).abs(), name));
        let (most, name) = scores.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let chance = 2.0 * Normal::standard().sf(most) * names.len() as f64;
        (chance < IMPROBABLE).then(|| name.clone())
    }

    /// Returns the law of the distance of independent segments from this mean and covariance.
    fn law(
        &self,
        (mean, covariance): (&DVector<f64>, &DMatrix<f64>),
        (all, skewed): (usize, bool),
    ) -> Option<DistanceLaw> {
        let found = Moments { means: vec![mean.clone()], covariance: covariance.clone() };
        let squared = moments::left_out(&self.table.observed(), &found)?;
        let squared: Vec<f64> = squared.into_iter().map(|(squared, k)| law::equivalent(squared, k, all)).collect();
        let law = DistanceLaw::of(all, rows_of(&self.table, 0).0 - self.fitted, &squared);
        let surprises: Vec<(f64, usize)> = squared.iter().map(|squared| law.surprise(*squared)).zip(0..).collect();
        Some(law.corrected(&surprises, skewed))
    }

    /// Returns the laws of the last coordinates, which rise; `None` without any.
    fn rising(
        &self,
        count: usize,
        healthy: (&DVector<f64>, &DMatrix<f64>),
        freedom: f64,
        (names, rate): (&[String], f64),
    ) -> Result<Option<Rising>, Error> {
        if count == 0 {
            return Ok(None);
        }
        let first = names.len() - count;
        let law = |table: FeatureTable, names: &[String]| {
            let alone = Self { table, runs: self.runs.clone(), fitted: self.fitted };
            alone.gate(0, (names, 0), rate).map(|gate| gate.law)
        };
        let of_others = || law(self.table.select(&(0..first).collect::<Vec<_>>()), &names[..first]);
        let others = (first > 0).then(of_others).transpose()?;
        let singular = || Error::Training("the healthy covariance is singular".into());
        let scores = self.conditional(healthy).ok_or_else(singular)?;
        let each = |k: usize| {
            let own = scores.select(&[k]);
            if self.runs.is_some() {
                return law(own, &names[k..=k]).map(|law| ScoreLaw::symmetric(&law));
            }
            let rows = own.with(0, 0).count().saturating_sub(self.fitted + k).max(2);
            Ok(ScoreLaw::of(rows, &left_out(&own).ok_or_else(singular)?))
        };
        let laws = (first..names.len()).map(each).collect::<Result<_, _>>()?;
        Ok(Some(Rising { freedom, laws, others }))
    }

    /// Returns each value less its mean given those before it, in standard deviations.
    fn conditional(&self, healthy: (&DVector<f64>, &DMatrix<f64>)) -> Option<FeatureTable> {
        let mut table = self.table.clone();
        for (value, variance) in table.rows.iter_mut().zip(&mut table.variances) {
            for (k, y) in moments::conditional_scores(healthy, value, variance)? {
                (value[k], variance[k]) = (y, 0.0);
            }
        }
        Some(table)
    }
}

/// Returns each value of one coordinate that is available less the mean of the others, in their standard deviations;
/// `None` if they are constant.
fn left_out(scores: &FeatureTable) -> Option<Vec<f64>> {
    let found = moments::moments(&scores.observed(), 1);
    let mean = found.means.first()?[0];
    let squared = moments::left_out(&scores.observed(), &found)?;
    let all = squared.into_iter().zip(&scores.rows).filter(|((_, available), _)| *available > 0);
    // The mean of the others is on the same side of the value as that of all.
    Some(all.map(|((squared, _), row)| squared.sqrt().copysign(row[0] - mean)).collect())
}

/// Parts of the runs, of which one at a time is judged by the others.
const FOLDS: usize = 10;

/// Returns the surprise of each segment by mean, covariance and law of other runs, with its run; none if these have no
/// law, or of fewer than ten runs. A tenth of the runs is left out at a time.
pub(crate) fn surprises(table: &FeatureTable, runs: &[usize], count: usize) -> Vec<(f64, usize)> {
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
