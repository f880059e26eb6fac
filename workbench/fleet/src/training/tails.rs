//! The second pass over the parts: left-out distances of healthy segments, from which the tails of the gate's law
//! follow.
//!
//! A distance adds the logarithms of its density for 17 tails; a score of a rising coordinate is counted in a bin of
//! 1/256 of asinh y. Both merge in any order. If groups (runs, or drives) count, a distance is that from the mean
//! of its group, so that the rows of a group are kept until it is complete.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::fit::{Fit, Independent};
use crate::double::Double;
use crate::fold::{Visitor, each_slice};
use crate::{Batch, Part, Wanted};
use model::Error;
use model::train::moments;
use model::train::novelty::law::{Likelihoods, TailDensities, equivalent};
use model::train::novelty::of_sums::{self, HealthySums, conditional, left_out};

/// Bins of a score, per unit of asinh y.
const BINS: f64 = 256.0;
/// Segments of a group that are kept for its mean; of a larger group the others are left out.
const MOST: usize = 500_000;

/// Sums of likelihoods.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sum {
    count: u64,
    each: Vec<Double>,
}

impl Sum {
    fn add(&mut self, densities: Option<&TailDensities>, squared: f64) {
        let Some(densities) = densities else { return };
        let all = densities.each(squared);
        self.each.resize(all.len(), Double::default());
        self.each.iter_mut().zip(all).for_each(|(sum, x)| sum.add(x));
        self.count += 1;
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.each.resize(self.each.len().max(other.each.len()), Double::default());
        self.each.iter_mut().zip(&other.each).for_each(|(sum, more)| sum.merge(*more));
    }

    /// The likelihoods; zeros, which tell nothing, without any distance; `None` if tails cannot be told apart.
    fn likelihoods(&self, densities: Option<&TailDensities>) -> Option<Likelihoods> {
        densities.map(|_| std::array::from_fn(|k| self.each.get(k).map_or(0.0, |sum| sum.value())))
    }
}

/// Likelihoods of the tails by the left-out distances of healthy segments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tails {
    all: Sum,
    others: Sum,
    of_runs: Vec<Sum>,
    scores: Vec<BTreeMap<i32, u64>>,
}

impl Tails {
    /// Adds what other rows tell.
    pub fn merge(&mut self, other: &Self) {
        self.all.merge(&other.all);
        self.others.merge(&other.others);
        self.of_runs.iter_mut().zip(&other.of_runs).for_each(|(own, more)| own.merge(more));
        for (own, more) in self.scores.iter_mut().zip(&other.scores) {
            more.iter().for_each(|(bin, count)| *own.entry(*bin).or_default() += count);
        }
    }

    /// The likelihoods for the gate of this fit.
    pub(super) fn found(&self, fit: &Fit) -> of_sums::Tails {
        let Some(judge) = Judge::new(fit) else { return of_sums::Tails::default() };
        let values = |bins: &BTreeMap<i32, u64>| {
            bins.iter().map(|(bin, count)| ((f64::from(*bin) / BINS).sinh(), *count as f64)).collect()
        };
        of_sums::Tails {
            all: self.all.likelihoods(judge.densities.as_ref()),
            others: self.others.likelihoods(judge.of_others.as_ref()),
            of_runs: self.of_runs.iter().map(|own| own.likelihoods(judge.of_one.as_ref())).collect(),
            scores: self.scores.iter().map(values).collect(),
        }
    }

    /// No distance yet.
    pub(super) fn new(fit: &Fit) -> Self {
        Self { of_runs: vec![Sum::default(); fit.rising], scores: vec![BTreeMap::new(); fit.rising], ..Self::default() }
    }
}

/// What distances are relative to.
struct Judge<'a> {
    fit: &'a Fit,
    healthy: &'a HealthySums,
    /// L⁻¹ of the covariance that distances are relative to, times the projection; and of the mean.
    white: DMatrix<f64>,
    centre: DVector<f64>,
    /// Each rising coordinate given those before it, and its variance within groups.
    rising: Vec<(DVector<f64>, f64)>,
    /// Number of rows that one is left out of.
    rows: f64,
    densities: Option<TailDensities>,
    of_others: Option<TailDensities>,
    of_one: Option<TailDensities>,
}

impl<'a> Judge<'a> {
    fn new(fit: &'a Fit) -> Option<Self> {
        let healthy = fit.healthy.as_ref()?;
        let (all, matrix) = (fit.coordinates(), &fit.projection.matrix);
        let first = all - fit.rising;
        let (covariance, mean, rows) = match &healthy.runs {
            Some(runs) => (&runs.within, &runs.mean, fit.in_runs as f64),
            None => (&healthy.covariance, &healthy.mean, healthy.rows.0 as f64),
        };
        let white = conditional(covariance)?;
        let centre = &white * mean + &white * (matrix * &fit.projection.mean);
        let rising = match &healthy.runs {
            None => vec![],
            Some(runs) => {
                let next = &runs.between + &runs.within * (1.0 - runs.inverse_size);
                let scores = conditional(&next)?;
                let each = |k: usize| {
                    let row = scores.row(k);
                    let within = (row * &runs.within * row.transpose())[(0, 0)];
                    ((row * matrix).transpose(), within)
                };
                (first..all).map(each).collect()
            }
        };
        let densities = |coordinates: usize| of_sums::densities(healthy, coordinates);
        Some(Self {
            fit,
            healthy,
            white: white * matrix,
            centre,
            rising,
            rows,
            densities: densities(all),
            of_others: if first > 0 && first < all { densities(first) } else { None },
            of_one: densities(1),
        })
    }

    /// Adds an independent row.
    fn add(&self, tails: &mut Tails, values: &[f64], variances: &[f64]) {
        let all = self.fit.coordinates();
        let first = all - self.fit.rising;
        let value = DVector::from_column_slice(values);
        let plain = values.iter().all(|x| !x.is_nan())
            && variances.iter().zip(self.fit.usual.iter()).all(|(own, usual)| own <= usual);
        // The scores of the available coordinates, each given those before it.
        let scores: Vec<(usize, f64)> = if plain {
            (&self.white * value - &self.centre).iter().copied().enumerate().collect()
        } else {
            let (z, variance) = self.coordinates(values, variances);
            let healthy = (&self.healthy.mean, &self.healthy.covariance);
            match moments::conditional_scores(healthy, &z, &variance) {
                Some(scores) => scores,
                None => return,
            }
        };
        let (mut squared, mut counted) = (0.0, 0);
        for (k, y) in &scores {
            if *k >= first {
                let own = left_out(self.rows, y * y).sqrt().copysign(*y);
                *tails.scores[k - first].entry((own.asinh() * BINS).round() as i32).or_default() += 1;
            }
            squared += y * y;
            counted += 1;
        }
        let others: Vec<f64> = scores.iter().filter(|(k, _)| *k < first).map(|(_, y)| y * y).collect();
        let judged = |squared: f64, some: usize, all: usize| equivalent(left_out(self.rows, squared), some, all);
        if counted > 0 {
            tails.all.add(self.densities.as_ref(), judged(squared, counted, all));
        }
        if !others.is_empty() {
            tails.others.add(self.of_others.as_ref(), judged(others.iter().sum(), others.len(), first));
        }
    }

    /// The coordinates of a row, with the variances of their errors.
    fn coordinates(&self, values: &[f64], variances: &[f64]) -> (DVector<f64>, DVector<f64>) {
        let usual = self.fit.usual.iter();
        let excess = values.iter().zip(variances).zip(usual);
        let excess = excess.map(|((x, own), usual)| if x.is_nan() { f64::INFINITY } else { (own - usual).max(0.0) });
        let excess = DVector::from_iterator(values.len(), excess);
        let value = DVector::from_iterator(values.len(), values.iter().map(|x| if x.is_nan() { 0.0 } else { *x }));
        self.fit.projection.apply_with(&value, &excess)
    }

    /// Adds the rows of a complete group, which have all features.
    fn add_group(&self, tails: &mut Tails, rows: &[f64]) {
        let (width, n) = (self.fit.names.len(), rows.len() / self.fit.names.len().max(1));
        if n < 2 {
            return;
        }
        let first = self.fit.coordinates() - self.fit.rising;
        let mut sums = vec![Double::default(); width];
        rows.chunks(width).for_each(|row| sums.iter_mut().zip(row).for_each(|(sum, x)| sum.add(*x)));
        let mean = DVector::from_iterator(width, sums.iter().map(|sum| sum.value() / n as f64));
        let wider = (n as f64 / (n as f64 - 1.0)).sqrt();
        for row in rows.chunks(width) {
            let away = (DVector::from_column_slice(row) - &mean) * wider;
            let scores = &self.white * &away;
            let squared = |count: usize| left_out(self.rows, scores.rows(0, count).norm_squared());
            tails.all.add(self.densities.as_ref(), squared(scores.len()));
            if first > 0 && self.fit.rising > 0 {
                tails.others.add(self.of_others.as_ref(), squared(first));
            }
            for ((direction, within), own) in self.rising.iter().zip(&mut tails.of_runs) {
                own.add(self.of_one.as_ref(), left_out(self.rows, direction.dot(&away).powi(2) / within));
            }
        }
    }
}

/// Distances of a slice.
struct Judging<'a> {
    judge: &'a Judge<'a>,
    tails: Tails,
    healthy: &'a str,
    /// Rows of groups that are not complete, by unit and run; the run is empty if units count.
    groups: BTreeMap<(String, String), Vec<f64>>,
}

impl Visitor for Judging<'_> {
    fn rows(&mut self, batch: &Batch, rows: Range<usize>) -> Result<(), Error> {
        let [class, unit, run] = batch.texts(rows.start);
        if class != self.healthy {
            return Ok(());
        }
        if self.judge.healthy.runs.is_none() {
            rows.for_each(|row| self.judge.add(&mut self.tails, batch.values(row), batch.variances(row)));
            return Ok(());
        }
        let run = if self.judge.fit.independent == Independent::Units { "" } else { run };
        let own = self.groups.entry((unit.to_string(), run.to_string())).or_default();
        for row in rows {
            let values = batch.values(row);
            if !values.iter().any(|x| x.is_nan()) && own.len() < MOST * values.len() {
                own.extend(values);
            }
        }
        Ok(())
    }

    fn complete(&mut self) -> Result<(), Error> {
        while let Some((_, rows)) = self.groups.pop_first() {
            self.judge.add_group(&mut self.tails, &rows);
        }
        Ok(())
    }

    fn open(&self) -> usize {
        self.groups.len()
    }
}

fn join<'a>(mut one: Judging<'a>, two: Judging<'a>) -> Result<Judging<'a>, Error> {
    one.tails.merge(&two.tails);
    Ok(one)
}

/// Finds the tails for the gate of a fit, if it has a healthy class; `told` is called with numbers of rows.
///
/// # Errors
/// As [`crate::fold`].
pub fn tails(parts: &[Part], fit: &Fit, wanted: &Wanted, told: &(dyn Fn(u64) + Sync)) -> Result<Option<Tails>, Error> {
    let (Some(judge), Some(class)) = (Judge::new(fit), fit.recipe.alarms.healthy) else { return Ok(None) };
    let wanted = Wanted { features: fit.names.clone(), ..wanted.clone() };
    let healthy = fit.classes[class].as_str();
    let new = || Ok(Judging { judge: &judge, tails: Tails::new(fit), healthy, groups: BTreeMap::new() });
    each_slice(parts, &wanted, told, &new, &join).map(|found| Some(found.tails))
}
