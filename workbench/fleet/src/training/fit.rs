//! Sums → everything of a model but the gate.
//!
//! Means, covariances, projection, discriminant and the spread of runs are functions of the sums: they are those that
//! training on the segments themselves finds, up to rounding.

use nalgebra::{DMatrix, DVector};

use super::errors::allowed;
use crate::sums::PatternSums;
use crate::{Level, Plan, Sums};
use model::Error;
use model::core::coordinates;
use model::near::among;
use model::train::moments::{Cell, moments_of};
use model::train::novelty::of_sums::HealthySums;
use model::train::novelty::runs::RunMoments;
use model::train::{AffineMap, ClassStatistics, LeftOut, Recipe, Shrink, projection};

/// What is independent of each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Independent {
    /// Segments.
    Segments,
    /// Runs: the rates are those of the next one.
    Runs,
    /// Drives: the rates are those of the next one.
    Units,
}

/// The chosen features, and what sums must have for them.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The chosen features among all of the plan.
    pub(super) chosen: Vec<usize>,
    /// Names of the features to sum.
    pub features: Vec<String>,
}

impl Choice {
    /// Chooses by the recipe.
    ///
    /// # Errors
    /// Unknown names, and what needs the segments themselves: covariates, and shrinkage by cross-validation.
    pub fn new(plan: &Plan, recipe: &Recipe) -> Result<Self, Error> {
        if !recipe.covariates.is_empty() {
            let problem = "--covariates are fitted to segments, not to sums: train on the traces";
            return Err(Error::Usage(problem.into()));
        }
        if recipe.shrink == Shrink::Chosen {
            let problem =
                "--discriminant shrunk is chosen by cross-validation, which sums do not allow; give --shrinkage";
            return Err(Error::Usage(problem.into()));
        }
        let catalogue = plan.catalogue();
        let chosen = recipe.rising_last(&catalogue, catalogue.choose(&recipe.features)?)?;
        let regression = plan.structure_parameters() + 1;
        // The core's parameters are sums of raw ones: their centre is the mean of all of these.
        let needed = |place: usize| {
            chosen.contains(&place) || place < regression && chosen.iter().any(|chosen| *chosen < regression)
        };
        let features = (0..plan.features.len()).filter(|place| needed(*place)).map(|k| plan.features[k].clone());
        Ok(Self { features: features.collect(), chosen })
    }
}

/// Everything of a model but the gate.
#[derive(Clone, Debug)]
pub struct Fit {
    pub(super) recipe: Recipe,
    pub(super) plan: Plan,
    pub(super) classes: Vec<String>,
    pub(super) independent: Independent,
    /// Names of the chosen features, and their usual errors.
    pub(super) names: Vec<String>,
    pub(super) usual: DVector<f64>,
    pub(super) projection: AffineMap,
    pub(super) coordinate_names: Vec<String>,
    /// Number of the last coordinates that only rise with a defect.
    pub(super) rising: usize,
    pub(super) healthy: Option<HealthySums>,
    /// Segments in healthy runs of more than one.
    pub(super) in_runs: u64,
    pub(super) statistics: ClassStatistics,
    pub(super) sizes: Vec<[usize; 2]>,
    /// Mean of all features of the plan, and 0 for those that were not summed.
    pub(super) means: DVector<f64>,
    pub(super) chosen: Vec<usize>,
    pub(super) left_out: LeftOut,
}

/// The rows of a pattern as a cell of all features.
fn cell(pattern: &PatternSums, class: usize, features: usize) -> Cell {
    let there: Vec<usize> = (0..features).filter(|k| (pattern.mask >> k) & 1 == 1).collect();
    let (mut mean, mut variance) = (DVector::zeros(features), DVector::repeat(features, f64::INFINITY));
    let mut scatter = DMatrix::zeros(features, features);
    let allowed = allowed(&pattern.rows, &pattern.excess);
    for (i, &row) in there.iter().enumerate() {
        (mean[row], variance[row]) = (pattern.rows.mean[i], pattern.excess[i] * allowed);
        there.iter().enumerate().for_each(|(j, &column)| scatter[(row, column)] = pattern.rows.scatter[(i, j)]);
    }
    Cell { class, count: pattern.rows.count as f64, variance, mean, scatter }
}

/// The classes that are asked for, or all: those of the plan first.
///
/// # Errors
/// A class without rows.
pub fn classes(sums: &Sums, asked: &[String]) -> Result<Vec<String>, Error> {
    let present: Vec<&str> = sums.names().collect();
    if let Some(name) = asked.iter().find(|name| !present.contains(&name.as_str())) {
        let near = among(name, &present);
        return Err(Error::Usage(format!("--classes: no segment of class {name}{near}")));
    }
    if !asked.is_empty() {
        return Ok(asked.to_vec());
    }
    let known = sums.plan.classes.iter().filter(|name| present.contains(&name.as_str())).cloned();
    let others = present.iter().filter(|name| !sums.plan.classes.iter().any(|own| own == *name));
    Ok(known.chain(others.map(ToString::to_string)).collect())
}

impl Fit {
    /// Fits the recipe to sums of all features of its [`Choice`].
    ///
    /// # Errors
    /// Too few rows of a class, and features that are constant or depend on each other.
    pub fn new(sums: &Sums, classes: &[String], recipe: &Recipe, independent: Independent) -> Result<Self, Error> {
        let plan = sums.plan.clone();
        let Choice { chosen, .. } = Choice::new(&plan, recipe)?;
        check(classes, sums, recipe)?;
        let names: Vec<String> = chosen.iter().map(|place| plan.features[*place].clone()).collect();
        let place = |name: &String| sums.features.iter().position(|own| own == name).unwrap_or(0);
        let places: Vec<usize> = names.iter().map(place).collect();
        let of_class = |(class, name): (usize, &String)| {
            let patterns = sums.of_class(name).map_or_else(Vec::new, |own| own.patterns(&places));
            patterns.iter().map(|pattern| cell(pattern, class, names.len())).collect::<Vec<_>>()
        };
        let cells: Vec<Cell> = classes.iter().enumerate().flat_map(of_class).collect();
        let raw = ClassStatistics::of_cells(&cells, classes, &names)?;
        let projection = projection::of_statistics(&raw, &names, recipe.projection)?;
        let statistics = raw.map(&projection);
        let coordinate_names = coordinates::of_map(&projection.matrix, &names);
        let levels =
            |name: &String| sums.of_class(name).map(|own| level(own, independent).map(|of| of.select(&places)));
        let healthy = recipe.alarms.healthy.and_then(|class| Some((class, levels(classes.get(class)?)?)));
        let in_runs = healthy.as_ref().and_then(|(_, own)| own.as_ref()).map_or(0, |own| own.rows - own.single);
        let healthy = healthy.map(|(class, own)| of_healthy(&cells, class, own.as_ref(), &projection));
        let size = |(name, rows): (&String, &usize)| {
            let groups = levels(name).flatten().map(|own| own.count as usize);
            [*rows, groups.unwrap_or(*rows).clamp(1, *rows)]
        };
        let empty = |name: &String| sums.of_class(name).map_or(0, |own| own.empty as usize);
        let lost = classes.iter().map(empty).sum::<usize>();
        let left_out =
            LeftOut { count: lost, of: lost + raw.counts.iter().sum::<usize>(), in_pieces: true, first: None };
        Ok(Self {
            usual: DVector::from_iterator(chosen.len(), chosen.iter().map(|place| plan.usual[*place])),
            means: means(sums, classes),
            sizes: classes.iter().zip(&raw.counts).map(size).collect(),
            rising: recipe.rising(&coordinate_names),
            recipe: recipe.clone(),
            classes: classes.to_vec(),
            plan,
            independent,
            names,
            projection,
            coordinate_names,
            healthy,
            in_runs,
            statistics,
            chosen,
            left_out,
        })
    }

    /// Whether the gate's rate is that of the next run or drive.
    #[must_use]
    pub fn counts_groups(&self) -> bool {
        self.healthy.as_ref().is_some_and(|healthy| healthy.runs.is_some())
    }

    /// Number of coordinates.
    pub(super) fn coordinates(&self) -> usize {
        self.projection.matrix.nrows()
    }
}

/// Refuses classes that cannot be trained.
fn check(classes: &[String], sums: &Sums, recipe: &Recipe) -> Result<(), Error> {
    if classes.is_empty() {
        return Err(Error::Training("the parts have no row; give parts with segments or a wider selection".into()));
    }
    if classes.len() < 2 && recipe.alarms.healthy.is_none() {
        let only = classes.join(", ");
        return Err(Error::Training(format!(
            "training needs at least two classes, but there is only {only}; give more parts, or say that it is healthy"
        )));
    }
    for name in classes {
        let count = sums.of_class(name).map_or(0, crate::ClassSums::count);
        if count < 2 {
            let problem = format!("class {name} has {count} segment(s), too few for a spread");
            return Err(Error::Training(problem + "; give more or leave it out by --classes"));
        }
    }
    Ok(())
}

/// The groups of a class that count.
const fn level(own: &crate::ClassSums, independent: Independent) -> Option<&Level> {
    match independent {
        Independent::Segments => None,
        Independent::Runs => Some(&own.runs),
        Independent::Units => Some(&own.units),
    }
}

fn of_healthy(cells: &[Cell], class: usize, groups: Option<&Level>, projection: &AffineMap) -> HealthySums {
    let own: Vec<Cell> =
        cells.iter().filter(|cell| cell.class == class).map(|cell| Cell { class: 0, ..cell.clone() }).collect();
    let found = moments_of(&own, 1);
    let with = |k: usize| {
        let rows = own.iter().filter(|cell| cell.variance[k].is_finite()).map(|cell| cell.count).sum::<f64>();
        (rows as usize, Some(k))
    };
    let rows = own.iter().map(|cell| cell.count).sum::<f64>() as usize;
    let scarcest = (0..found.covariance.nrows()).map(with).filter(|(count, _)| *count < rows).min();
    let exact = own.len() == 1 && own[0].variance.iter().all(|v| *v <= 0.0);
    let covariance = if exact { &own[0].scatter / (own[0].count - 1.0).max(1.0) } else { found.covariance };
    let matrix = &projection.matrix;
    // Groups of one segment each are independent segments.
    let runs = groups.filter(|own| own.longest > 1).map(|groups| {
        let (k, means) = (groups.count as f64, groups.means());
        let mut within = groups.within() / (groups.rows - groups.count) as f64;
        within_without_errors(&mut within, &own);
        let runs = RunMoments {
            count: groups.count as usize,
            rows: groups.rows as usize,
            longest: groups.longest as usize,
            inverse_size: groups.inverse_size(),
            mean: means.mean,
            between: means.scatter / (k - 1.0).max(1.0),
            within,
        };
        runs.map(matrix, &projection.mean)
    });
    HealthySums {
        rows: scarcest.unwrap_or((rows, None)),
        mean: projection.apply(&found.means[0]),
        covariance: model::train::covariance::symmetric(&(matrix * covariance * matrix.transpose())),
        runs,
    }
}

/// Subtracts the mean excess of the errors' variances from the covariance within groups, as long as it stays regular.
fn within_without_errors(within: &mut DMatrix<f64>, own: &[Cell]) {
    let complete = own.iter().find(|cell| cell.variance.iter().all(|v| v.is_finite()));
    let Some(cell) = complete.filter(|cell| cell.variance.iter().any(|v| *v > 0.0)) else { return };
    let less = &*within - DMatrix::from_diagonal(&cell.variance);
    if less.clone().cholesky().is_some() {
        *within = less;
    }
}

/// Mean of all features over the rows of the classes that have them.
fn means(sums: &Sums, classes: &[String]) -> DVector<f64> {
    let mut means = DVector::zeros(sums.plan.features.len());
    for (k, name) in sums.features.iter().enumerate() {
        let of_class = |class: &String| sums.of_class(class).map_or_else(Vec::new, |own| own.patterns(&[k]));
        let (mut sum, mut count) = (0.0, 0.0);
        for own in classes.iter().flat_map(of_class) {
            sum += own.rows.mean[0] * own.rows.count as f64;
            count += own.rows.count as f64;
        }
        if let Some(place) = sums.plan.features.iter().position(|own| own == name) {
            means[place] = sum / f64::max(count, 1.0);
        }
    }
    means
}
