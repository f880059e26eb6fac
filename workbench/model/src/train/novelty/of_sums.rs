//! Sums of healthy segments → the novelty gate.
//!
//! Mean, covariance and the spread of runs are functions of the sums, so that the gate is that of the rows themselves.
//! The tails follow from left-out distances, which a second pass over the rows finds in closed form:
//!
//! ```text
//! d²₋ = (n/(n−1))² q/(1 − c q),   q = d² (n−2)/(n−1),   c = n/((n−1)(n−2))                     (1)
//! ```
//!
//! (1) is (3) of `crate::train::distribution::moments` for rows without errors and missing values, by the formula of
//! Sherman and Morrison. Without a second pass the tails have their prior probabilities, and the gate is further out.

use bearing_watch::model::KNOTS;
use nalgebra::{DMatrix, DVector};

use super::alarms::Alarms;
use super::gate::{Counted, Gate, checked, scarcity};
use super::laws::law::{DistanceLaw, Likelihoods, TailDensities};
use super::laws::rising::Rising;
use super::laws::score::ScoreLaw;
use super::laws::{knots, spread};
use super::ratios::TrainingSet;
use super::runs::{self, NextRun, RunMoments};
use super::{Watch, watch};
use crate::Error;
use crate::train::distribution::covariance::{singular, whitening};
use crate::train::{GaussianClasses, Recipe};

/// Sums of healthy rows in coordinates.
#[derive(Clone, Debug)]
pub struct HealthySums {
    /// Number of rows with the coordinate that is missing most often, and this coordinate, if any is missing.
    pub rows: (usize, Option<usize>),
    /// Mean of the class.
    pub mean: DVector<f64>,
    /// Covariance of the class.
    pub covariance: DMatrix<f64>,
    /// The runs, if the rate is that of the next run.
    pub runs: Option<RunMoments>,
}

/// What a second pass has found.
#[derive(Clone, Debug, Default)]
pub struct Tails {
    /// Likelihoods of the tails of the distance of all coordinates.
    pub all: Option<Likelihoods>,
    /// Of that of the coordinates before the rising ones.
    pub others: Option<Likelihoods>,
    /// Of each rising coordinate, if runs count.
    pub of_runs: Vec<Option<Likelihoods>>,
    /// Left-out scores of each rising coordinate with the number of times that each came, if runs do not count.
    pub scores: Vec<Vec<(f64, f64)>>,
}

/// Number of rows from which one is left out, its squared distance d² from all of them → (1).
#[must_use]
pub fn left_out(rows: f64, squared: f64) -> f64 {
    let n = rows;
    let q = squared * (n - 2.0) / (n - 1.0);
    let rest = 1.0 - n / ((n - 1.0) * (n - 2.0)) * q;
    (n / (n - 1.0)).powi(2) * q / rest.max(f64::MIN_POSITIVE)
}

/// Densities for the likelihoods of left-out distances in so many coordinates.
#[must_use]
pub fn densities(healthy: &HealthySums, coordinates: usize) -> Option<TailDensities> {
    match &healthy.runs {
        Some(runs) => TailDensities::new(coordinates, runs.rows - runs.count),
        None => TailDensities::new(coordinates, healthy.rows.0 - 1),
    }
}

/// Returns the watch from sums; `sizes` are numbers of rows and of runs of each class.
pub fn train(
    (healthy, tails): (Option<&HealthySums>, &Tails),
    (names, rising): (&[String], usize),
    (sizes, segment_s): (&[[usize; 2]], Option<f64>),
    recipe: &Recipe,
    densities: &GaussianClasses,
) -> Result<Watch, Error> {
    let gate = |alarms: &Alarms| {
        let healthy = healthy.ok_or_else(|| Error::Training("no healthy class".into()))?;
        let counted = match &healthy.runs {
            Some(runs) => Counted::Runs(runs.count),
            None => Counted::Rows(healthy.rows),
        };
        let scarce = || scarcity(counted, 0, names, alarms.false_alarm);
        checked(alarms, scarce, || healthy.gate(tails, (names, rising), alarms))
    };
    watch((names, segment_s), recipe, (densities, Err(None)), &gate, &TrainingSet::Counts(sizes))
}

impl HealthySums {
    fn gate(&self, tails: &Tails, (names, rising): (&[String], usize), alarms: &Alarms) -> Result<Gate, Error> {
        let (all, rate, rows) = (names.len(), alarms.false_alarm, self.rows.0);
        let refuse = |dependent| singular("the healthy class", rows, 1, names, dependent);
        let (mean, covariance, law, runs) = match &self.runs {
            Some(own) => {
                let NextRun { mean, covariance, law, spread } = next_run(own, tails.all).map_err(refuse)?;
                (mean, covariance, law, Some(spread))
            }
            None => {
                whitening(&self.covariance).map_err(refuse)?;
                (self.mean.clone(), self.covariance.clone(), DistanceLaw::of_tails(all, rows, tails.all), None)
            }
        };
        let freedom = runs.as_ref().map_or(rows as f64 - 1.0, |runs| runs.freedom);
        let limit = -rate.ln();
        let rising = self.rising(tails, (all, rising), (&covariance, freedom)).map_err(refuse)?;
        let knots: [[f64; 2]; KNOTS] = knots::knots(&law, limit);
        let (class, rows_needed) = (alarms.healthy.unwrap_or(0), spread::rows_needed(all, rate));
        Ok(Gate { class, mean, covariance, knots, limit, law, rising, rows, runs, rows_needed, skewed: None })
    }

    /// Returns the laws of the last coordinates, which rise; `None` without any.
    fn rising(
        &self,
        tails: &Tails,
        (all, count): (usize, usize),
        (covariance, freedom): (&DMatrix<f64>, f64),
    ) -> Result<Option<Rising>, usize> {
        if count == 0 {
            return Ok(None);
        }
        let first = all - count;
        let others = match &self.runs {
            _ if first == 0 => None,
            Some(own) => {
                let some = own.map(&DMatrix::identity(first, all), &DVector::zeros(all));
                Some(next_run(&some, tails.others)?.law)
            }
            None => Some(DistanceLaw::of_tails(first, self.rows.0, tails.others)),
        };
        let scores = conditional(covariance).ok_or(0_usize)?;
        let each = |k: usize| {
            let place = k - first;
            if let Some(own) = &self.runs {
                let one = own.map(&scores.rows(k, 1).into_owned(), &self.mean);
                return next_run(&one, tails.of_runs.get(place).copied().flatten())
                    .map(|found| ScoreLaw::symmetric(&found.law))
                    .map_err(|_| k);
            }
            let found = tails.scores.get(place).map_or(&[][..], Vec::as_slice);
            Ok(ScoreLaw::of_counts(self.rows.0.saturating_sub(k).max(2), found))
        };
        let laws = (first..all).map(each).collect::<Result<_, _>>()?;
        Ok(Some(Rising { freedom, laws, others }))
    }
}

/// Returns L⁻¹ of LLᵀ = Σ: each coordinate less its mean given those before it, in standard deviations.
#[must_use]
pub fn conditional(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = covariance.nrows();
    covariance.clone().cholesky()?.l().solve_lower_triangular(&DMatrix::identity(n, n))
}

/// Mean, covariance, law and spread of the next run; sums do not tell the order of the runs, and so no trend.
fn next_run(moments: &RunMoments, tails: Option<Likelihoods>) -> Result<NextRun, usize> {
    runs::of_moments(moments.clone(), tails, (vec![], None))
}
