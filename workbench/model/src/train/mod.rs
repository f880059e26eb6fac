//! Labelled traces → a trained model.
//!
//! The steps are features, their projection, and the discriminant; the result is then converted to the form that the
//! core runs ([`Trained`]). If the core computes batch least squares in single precision, the features are those of
//! batch least squares in double precision, else those that the core estimates on the training traces. A feature
//! without a result is missing in its row, and features of the torque balance have errors of known variance; means and
//! covariances account for both (`moments`). Rows without any of the chosen features are left out. The quality of the
//! model is measured by running the core on other traces ([`crate::evaluate`]), not here.

mod bench;
pub mod c_header;
mod c_text;
pub mod commissioning_source;
mod core_features;
mod core_form;
pub mod covariance;
mod covariates;
mod cross_validation;
pub mod discriminant;
mod estimation;
pub mod export;
mod fewer_harmonics;
mod filters;
mod fit;
mod folds;
mod forward;
pub mod front_end_header;
pub mod front_end_source;
mod lags;
mod left_out;
mod matrix;
pub mod moments;
mod nominal;
pub mod novelty;
pub mod projection;
mod ranking;
mod recipe;
mod reference_instruments;
#[cfg(test)]
mod reference_values;
mod refused;
mod rotor;
mod scores;
mod shaft;
mod shaft_plan;
mod shrinkage;
mod shrinkage_search;
pub mod statistics;
mod table;
mod trained;
mod velocity_choice;
mod velocity_source;

use bearing_watch::model::{Covariates, MAX_LONG_SEGMENT_ROWS};
use nalgebra::DVector;
use rayon::prelude::*;

use bearing_watch::plan::MAX_COVARIATES;

use crate::Error;
use crate::core::Parts;
use crate::core::features::{self, Catalogue};
use crate::identify::{Estimate, least_squares};
use crate::trace::labels::LabelledTrace;
use crate::trace::{Trace, same_interval};

pub use core_features::row as features_of;
pub use covariates::{Coefficient, Explained, Explaining};
pub use cross_validation::predict;
pub use discriminant::GaussianClasses;
pub use estimation::Estimation;
pub use folds::{Candidates, Folds, Validation};
pub use forward::Forward;
use left_out::Estimated;
pub use left_out::LeftOut;
pub use matrix::{Matrix, RowClassifier, RowGate};
use novelty::Rows;
pub use novelty::{AlarmInterval, Alarms, Watch};
pub use projection::{Keep, ProjectionKind};
pub use ranking::{Gain, Ranked, Ranking, rank};
pub use recipe::Recipe;
pub use rotor::{NextToRotor, Remedy, compared_turns, next_to_rotor};
pub use scores::{Bin, Decomposition, Prediction, Score, Scores};
pub use shaft_plan::ShaftPlan;
pub use shrinkage::{Shrink, Shrinkage};
pub use shrinkage_search::{Choice, GridPoint};
pub use statistics::ClassStatistics;
pub use table::{AffineMap, FeatureTable};
pub use trained::Trained;
pub use velocity_source::VelocitySource;

/// Trains on prepared traces.
///
/// # Errors
/// Estimation errors, if they leave fewer than two traces of a class; fewer than two classes, unless the only one is
/// the healthy one; a class without traces; features that are constant or collinear within classes; priors or costs
/// that do not match the classes.
pub fn train(traces: &[LabelledTrace], classes: &[String], recipe: &Recipe) -> Result<Trained, Error> {
    let segment = segment_of(traces, recipe);
    // The spread of the features depends on the segment length: trains on segments of the detector's length.
    let pieces = if recipe.estimation.segment.is_some() { cut(traces, segment) } else { traces.to_vec() };
    check_classes(&pieces, classes, recipe.alarms.healthy)?;
    let Estimating { recipe, parts, interval_s, .. } = estimating(traces, classes, recipe)?;
    let recipe = &recipe;
    let catalogue = recipe.catalogue();
    let chosen = recipe.rising_last(&catalogue, catalogue.choose(&recipe.features)?)?;
    let explaining = covariate_places(&catalogue, recipe)?;
    let estimated = estimate(traces, (classes, recipe), (&parts, &catalogue), (&pieces, segment))?;
    let pieces_only = recipe.estimation.segment.is_some();
    let (candidates, left_out) = estimated.usable((&chosen, &explaining), traces, pieces_only)?;
    let Candidates { table: raw, features: feature_names, .. } = candidates.select(&chosen);
    let fit::Fitted { explained, projection, coordinates, coordinate_names, statistics, densities, choice } =
        fit::fit(&candidates.select(&chosen), recipe)?;
    let centre = (candidates.table.mean(), &candidates.table.usual);
    let (used, core_projection, core_usual) = compose(centre, &chosen, &catalogue, &projection);
    let core_features = used.iter().map(|&place| catalogue.core_feature(place)).collect();
    let core_covariates = match &explained {
        Some(explained) => explained.core(&catalogue, &chosen, &used),
        None => Covariates { list: vec![], map: vec![] },
    };
    let segment_s = (interval_s > 0.0).then_some(segment as f64 * interval_s);
    let fitted = explained.as_ref().map_or(0, Explained::fitted);
    let rising = recipe.rising(&coordinate_names);
    let rows = Rows { table: &coordinates, names: &coordinate_names, fitted, rising };
    let runs = recipe.runs(&candidates);
    let shrink = choice.as_ref().map_or(recipe.shrink, |choice| Shrink::To(choice.shrinkage));
    let fixed = Recipe { shrink, ..recipe.clone() };
    let watch = novelty::train(rows, (runs, segment_s), &fixed, &densities)?;
    Ok(Trained {
        recipe: recipe.clone(),
        classes: classes.to_vec(),
        feature_names,
        explained,
        projection,
        raw,
        coordinates,
        coordinate_names,
        statistics,
        left_out,
        densities,
        choice,
        candidates,
        watch,
        core_features,
        core_covariates,
        core_projection,
        core_usual,
        parts,
        segment_samples: segment,
        interval_s,
        block_mean: 1,
    })
}

/// The part of a model that estimates, whose constants are trained before any feature is known.
#[expect(missing_debug_implementations, reason = "its parts have none")]
pub struct Estimating {
    /// The recipe with the source of the velocity chosen.
    pub recipe: Recipe,
    /// Its channels, regression and shaft, with their constants.
    pub parts: Parts,
    /// Samples in a segment.
    pub segment: usize,
    /// Sampling interval, s; 0 if unknown.
    pub interval_s: f64,
}

/// Trains the part of a model that estimates.
///
/// # Errors
/// Traces of several rates, or of which no nominal model can be estimated.
pub fn estimating(traces: &[LabelledTrace], classes: &[String], recipe: &Recipe) -> Result<Estimating, Error> {
    check_intervals(traces)?;
    let segment = segment_of(traces, recipe);
    let interval_s = traces.iter().find_map(|t| t.trace.interval_s).unwrap_or(0.0);
    let recipe = velocity_choice::resolved(traces, interval_s, recipe);
    let parts = parts(traces, classes, &recipe, (segment, interval_s))?;
    Ok(Estimating { recipe, parts, segment, interval_s })
}

/// Returns the usual variance of the error of each feature in these traces.
pub fn usual_errors(traces: &[LabelledTrace], classes: &[String], found: &Estimating) -> Result<Vec<f64>, Error> {
    let catalogue = found.recipe.catalogue();
    let (table, ..) = core_features::run(traces, classes, (&found.parts, &catalogue), found.segment)?;
    Ok(table.usual.iter().copied().collect())
}

/// Returns the number of samples in a segment: that of the recipe, or of the longest trace.
fn segment_of(traces: &[LabelledTrace], recipe: &Recipe) -> usize {
    let longest = traces.iter().map(|t| t.trace.y.len()).max().unwrap_or(0);
    recipe.estimation.segment.unwrap_or(longest.min(MAX_LONG_SEGMENT_ROWS as usize))
}

/// Returns the core's channels, regression and shaft with their trained constants.
fn parts(
    traces: &[LabelledTrace],
    classes: &[String],
    recipe: &Recipe,
    (segment, interval_s): (usize, f64),
) -> Result<Parts, Error> {
    /// Range of the channels, in multiples of the largest magnitude in training: a margin for other conditions.
    const LIMIT: f64 = 10.0;
    let wiring = recipe.wiring(&recipe.columns);
    let estimation = (&recipe.estimation, segment);
    let regression = estimation::regression(traces, classes, (recipe.structure, wiring.signals), estimation)?;
    let shaft = recipe.shaft.as_ref().map(|plan| {
        let sizes = (recipe.estimation.nominal, interval_s);
        shaft::model(traces, sizes, plan, &wiring)
    });
    let mut channels = wiring.core_channels(traces.iter().map(|t| &t.trace), LIMIT)?;
    estimation::guard(&mut channels, wiring.signals, &recipe.estimation)?;
    let averaged = recipe.catalogue().averaged.iter().fold(0, |mask, (_, place)| mask | 1 << place);
    Ok(Parts { channels, regression: Some(regression), shaft: shaft.transpose()?, averaged })
}

/// Returns the features of all segments; those of a part without a result are missing.
fn estimate(
    traces: &[LabelledTrace],
    (classes, recipe): (&[String], &Recipe),
    (parts, catalogue): (&Parts, &Catalogue),
    (pieces, segment): (&[LabelledTrace], usize),
) -> Result<Estimated, Error> {
    let batch = recipe.estimation.is_batch() && parts.shaft.is_none() && parts.averaged == 0;
    let (table, origins, reasons) = if batch {
        let of_trace = |(k, t): (usize, &LabelledTrace)| {
            let pieces = recipe.estimation.segment.map_or(1, |samples| spans(t.trace.y.len(), samples).count());
            std::iter::repeat_n(k, pieces)
        };
        let origins = traces.iter().enumerate().flat_map(of_trace).collect();
        let (table, reasons) = batch_features(pieces, classes, catalogue);
        (table, origins, reasons)
    } else {
        core_features::run(traces, classes, (parts, catalogue), segment)?
    };
    let groups = groups(&recipe.validation.groups, traces.len())?;
    let groups = origins.iter().map(|&trace| groups[trace]).collect();
    let candidates = Candidates { table, features: catalogue.names(), groups, covariates: None };
    Ok(Estimated { candidates, origins, reasons })
}

/// Returns the places of the covariates among all features.
///
/// # Errors
/// An unknown name, or a raw parameter that is a combination of several parameters of the core.
fn covariate_places(catalogue: &Catalogue, recipe: &Recipe) -> Result<Vec<usize>, Error> {
    if recipe.covariates.is_empty() {
        return Ok(vec![]);
    }
    if recipe.covariates.len() > MAX_COVARIATES {
        return Err(Error::Usage(format!("--covariates: at most {MAX_COVARIATES}")));
    }
    let names = catalogue.names();
    let zero = catalogue.delta_from_raw(&DVector::zeros(names.len()));
    let each = |name: &String| {
        let unknown = || Error::Usage(format!("--covariates: no {name} in this model; there are {}", names.join(", ")));
        let place = names.iter().position(|own| own == name).ok_or_else(unknown)?;
        let mut unit = DVector::zeros(names.len());
        unit[place] = 1.0;
        // The core's feature at the same place must be the same number.
        let delta = catalogue.delta_from_raw(&unit) - &zero;
        let same = delta == unit && zero[place] == 0.0 && catalogue.raw_from_delta().row(place).transpose() == unit;
        let problem = format!("--covariates: {name} is a combination of parameters; name a feature that is not");
        if same { Ok(place) } else { Err(Error::Usage(problem)) }
    };
    recipe.covariates.iter().map(each).collect()
}

/// Returns the features by batch least squares, and why a row has none.
fn batch_features(
    pieces: &[LabelledTrace],
    classes: &[String],
    catalogue: &Catalogue,
) -> (FeatureTable, Vec<Option<String>>) {
    let estimates: Vec<Result<Estimate, Error>> =
        pieces.par_iter().map(|t| least_squares(&t.trace, catalogue.structure)).collect();
    let count = catalogue.names().len();
    let row = |estimate: &Result<Estimate, Error>| match estimate {
        Ok(estimate) => (features::vector(estimate), DVector::zeros(count)),
        Err(_) => (DVector::zeros(count), DVector::repeat(count, f64::INFINITY)),
    };
    let (rows, variances) = estimates.iter().map(row).unzip();
    let names = classes.to_vec();
    let (classes, usual) = (pieces.iter().map(|t| t.class).collect(), DVector::zeros(count));
    let table = FeatureTable { rows, variances, usual, classes, names };
    (table, estimates.into_iter().map(|estimate| estimate.err().map(|error| error.to_string())).collect())
}

fn check_classes(traces: &[LabelledTrace], classes: &[String], healthy: Option<usize>) -> Result<(), Error> {
    if traces.is_empty() {
        return Err(Error::Training("the training set is empty; give labelled traces or a wider selection".into()));
    }
    if classes.len() < 2 && healthy.is_none() {
        let only = classes.join(", ");
        return Err(Error::Training(format!(
            "training needs at least two classes, but there is only {only}; widen the selection, or say that it is healthy"
        )));
    }
    for (class, name) in classes.iter().enumerate() {
        if name.len() > 16 {
            return Err(Error::Training(format!(
                "class name {name} is longer than 16 bytes; shorten it in the labels"
            )));
        }
        let count = traces.iter().filter(|t| t.class == class).count();
        if count < 2 {
            return Err(Error::Training(format!(
                "class {name} has {count} training trace(s), too few for a spread; give more or leave it out"
            )));
        }
    }
    Ok(())
}

/// Returns the number of each trace's group.
fn groups(names: &[String], traces: usize) -> Result<Vec<usize>, Error> {
    if names.is_empty() {
        return Ok((0..traces).collect());
    }
    if names.len() != traces {
        return Err(Error::Training(format!("{} groups for {traces} training traces; name one for each", names.len())));
    }
    let first = |name: &String| names.iter().position(|other| other == name).unwrap_or(0);
    Ok(names.iter().map(first).collect())
}

/// Returns an error if the sampling intervals of a training set differ: a model is valid for one rate only.
fn check_intervals(traces: &[LabelledTrace]) -> Result<(), Error> {
    let mut known = traces.iter().filter_map(|t| t.trace.interval_s.map(|step| (t.trace.id.as_str(), step)));
    let Some((first, interval)) = known.next() else { return Ok(()) };
    known.try_for_each(|(id, step)| {
        if same_interval(step, interval) {
            return Ok(());
        }
        // Single precision prints without the digits of rounding errors.
        let (step, interval) = (step as f32, interval as f32);
        let problem =
            format!("sampled every {step} s, but {first} every {interval} s; train on one rate (command resample)");
        Err(Error::trace(id, problem))
    })
}

/// Cuts traces into segments of `samples`, the detector's segment length. A remainder is kept if it is longer than half
/// a segment.
#[must_use]
pub fn cut(traces: &[LabelledTrace], samples: usize) -> Vec<LabelledTrace> {
    let pieces = traces.iter().flat_map(|labelled| {
        let trace = &labelled.trace;
        spans(trace.y.len(), samples).map(|(start, end)| {
            let piece = Trace {
                id: format!("{}[{start}..{end}]", trace.id),
                y: trace.y[start..end].to_vec(),
                u1: trace.u1[start..end].to_vec(),
                u2: trace.u2[start..end].to_vec(),
                motion: trace.motion.as_ref().map(|motion| motion.cut(start, end)),
                further: trace.further.iter().map(|column| column[start..end].to_vec()).collect(),
                ..*trace
            };
            LabelledTrace { trace: piece, class: labelled.class }
        })
    });
    pieces.collect()
}

/// Returns start and end of each piece of a trace with `length` samples.
fn spans(length: usize, samples: usize) -> impl Iterator<Item = (usize, usize)> {
    let ends = (0..length).step_by(samples.max(1)).map(move |start| (start, (start + samples).min(length)));
    ends.filter(move |(start, end)| 2 * (end - start) > samples)
}

/// Returns the map from the core's δ-features: z = W (raw − m) = W T_S (δ − δ_m), with δ_m the training mean of δ, and
/// the places of the δ-features that it uses. `raw` and `usual` are the means and usual errors of all features.
#[must_use]
pub fn compose(
    (mut raw, usual): (DVector<f64>, &DVector<f64>),
    chosen: &[usize],
    catalogue: &Catalogue,
    projection: &AffineMap,
) -> (Vec<usize>, AffineMap, DVector<f64>) {
    let map = catalogue.raw_from_delta().select_rows(chosen);
    let used: Vec<usize> = (0..map.ncols()).filter(|&k| map.column(k).amax() > 0.0).collect();
    // Both centres are the same point: of the chosen features the projection's centre, of the others any.
    chosen.iter().zip(projection.mean.iter()).for_each(|(&place, mean)| raw[place] = *mean);
    let mean = catalogue.delta_from_raw(&raw);
    let matrix = &projection.matrix * map.select_columns(&used);
    let centre = DVector::from_iterator(used.len(), used.iter().map(|&k| mean[k]));
    // The map from raw features leaves those with errors as they are.
    let usual = DVector::from_iterator(used.len(), used.iter().map(|&k| usual[k]));
    (used, AffineMap { matrix, mean: centre }, usual)
}
