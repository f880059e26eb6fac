//! The features of all segments of a training set, whichever of them a model uses.

use bearing_watch::model::Covariates;
use bearing_watch::plan::MAX_COVARIATES;
use nalgebra::DVector;

use super::classifier::fit;
use super::estimator::estimating::{Estimating, estimating};
use super::estimator::{spans, with_segment};
use super::model::core_form::compose;
use super::novelty::{self, Rows};
use super::rows::contamination::{self, Doubted, Populations};
use super::rows::core_features;
use super::rows::dependence::{self, Dependence};
use super::rows::left_out::{Estimated, LeftOut};
use super::{Candidates, Explained, Recipe, Shrink, Sight, Trained, directions};
use crate::Error;
use crate::core::Parts;
use crate::core::features::{self, Catalogue};
use crate::near::among;
use crate::trace::labels::LabelledTrace;

/// A training set with the part of the model that estimates, and the features that it estimates.
pub(super) struct Estimates<'a> {
    /// The traces.
    pub(super) traces: &'a [LabelledTrace],
    /// Names of their classes.
    pub(super) classes: &'a [String],
    /// The recipe with the source of the velocity chosen.
    pub(super) recipe: Recipe,
    /// Channels, regression and shaft, with their constants.
    pub(super) parts: Parts,
    /// All features.
    pub(super) catalogue: Catalogue,
    /// Samples in a segment.
    pub(super) segment: usize,
    /// Sampling interval, s; 0 if unknown.
    pub(super) interval_s: f64,
    pub(super) estimated: Estimated,
}

/// The segments that a recipe uses.
pub(super) struct Used {
    /// All features of each.
    pub(super) candidates: Candidates,
    /// The places of the recipe's features.
    pub(super) chosen: Vec<usize>,
    /// The places of its covariates.
    pub(super) explaining: Vec<usize>,
    /// The trace of each.
    pub(super) origins: Vec<usize>,
    /// Segments without features.
    left_out: LeftOut,
    doubted: Option<Doubted>,
}

impl<'a> Estimates<'a> {
    /// Trains what estimates, and runs it over the traces.
    pub(super) fn of(traces: &'a [LabelledTrace], classes: &'a [String], recipe: &Recipe) -> Result<Self, Error> {
        let (segment, recipe) = with_segment(traces, recipe);
        let pieces = |own: &LabelledTrace| match recipe.estimation.segment {
            Some(_) => spans(own.trace.y.len(), segment).count(),
            None => 1,
        };
        let counts = traces.iter().map(|own| (own.class, pieces(own)));
        check_classes(counts.collect(), classes, recipe.alarms.healthy)?;
        let Estimating { recipe, parts, interval_s, .. } = estimating(traces, classes, &recipe)?;
        let catalogue = recipe.catalogue();
        // An unknown name is an error before the core runs over all traces.
        places(&catalogue, &recipe)?;
        let estimated = estimate(traces, (classes, &recipe), (&parts, &catalogue), segment)?;
        Ok(Self { traces, classes, recipe, parts, catalogue, segment, interval_s, estimated })
    }

    /// Returns the places of the recipe's features.
    pub(super) fn chosen(&self) -> Result<Vec<usize>, Error> {
        let [chosen, _] = places(&self.catalogue, &self.recipe)?;
        Ok(chosen)
    }

    /// Takes healthy segments that depend on each other by these features for runs, if nothing is said about runs.
    pub(super) fn take_runs(&mut self, places: &[usize]) -> Result<Option<Dependence>, Error> {
        let validation = &self.recipe.validation;
        let Some(columns) = validation.columns.as_ref().filter(|_| validation.groups.is_empty()) else {
            return Ok(None);
        };
        let Some(healthy) = self.recipe.alarms.healthy else { return Ok(None) };
        let (names, table) = (self.catalogue.names(), &self.estimated.candidates.table);
        // Segments of one trace follow each other.
        let of_traces =
            || ("trace".to_string(), self.traces.iter().map(|labelled| labelled.trace.id.clone()).collect());
        let cut = self.estimated.origins.windows(2).any(|two| two[0] == two[1]);
        let columns = &[columns.clone(), cut.then(of_traces).into_iter().collect()].concat();
        let (names, origins, traces) = (&names[..], &self.estimated.origins[..], self.traces);
        let found = dependence::of(&dependence::Set { table, names, origins, traces, healthy }, places, columns);
        if let Some(found) = &found {
            self.recipe.validation.groups.clone_from(&found.groups);
            self.recipe.alarms.by_run = true;
            let of_traces = groups(&found.groups, self.traces.len())?;
            let of_rows = self.estimated.origins.iter().map(|&trace| of_traces[trace]);
            self.estimated.candidates.groups = of_rows.collect();
        }
        Ok(found)
    }

    /// The class whose traces are those of a sound bearing: the healthy one, or that of the nominal model.
    pub(super) fn sound(&self) -> usize {
        self.recipe.alarms.healthy.unwrap_or(self.recipe.estimation.nominal)
    }

    /// Returns the segments that a recipe uses.
    pub(super) fn rows_of(&self, recipe: &Recipe) -> Result<Used, Error> {
        let [chosen, explaining] = places(&self.catalogue, recipe)?;
        let in_pieces = recipe.estimation.segment.is_some();
        let (mut candidates, mut origins, left_out) =
            self.estimated.usable((&chosen, &explaining), self.traces, in_pieces)?;
        let doubted = self.doubted((&candidates, &origins), (&chosen, recipe));
        if let Some(doubted) = &doubted {
            let stay: Vec<usize> = (0..origins.len()).filter(|row| !doubted.others.contains(row)).collect();
            candidates = candidates.rows(&stay);
            origins = stay.into_iter().map(|row| origins[row]).collect();
        }
        Ok(Used { candidates, chosen, explaining, origins, left_out, doubted })
    }

    /// Returns what is unusual about the healthy segments, where they are doubted; those of runs differ by run, which
    /// the gate contains.
    fn doubted(
        &self,
        (rows, origins): (&Candidates, &[usize]),
        (chosen, recipe): (&[usize], &Recipe),
    ) -> Option<Doubted> {
        let wanted = self.recipe.automatic || self.recipe.validation.doubted;
        let healthy = recipe.alarms.healthy.filter(|_| wanted && !recipe.alarms.by_run)?;
        let own: Vec<usize> = (0..origins.len()).filter(|&row| rows.table.classes[row] == healthy).collect();
        let mut alone = rows.table.keep(&own);
        (alone.classes, alone.names) = (vec![0; own.len()], vec![rows.table.names[healthy].clone()]);
        let mut sets = sets(&rows.features, chosen);
        // Friction that contains a load that is not known differs as the load does.
        let known = recipe.shaft.as_ref().is_none_or(|plan| plan.load || plan.axis.weighs());
        sets.retain(|set| known || set.iter().all(|&place| features::friction(&rows.features[place]).is_none()));
        let found = contamination::of_sets(&alone, &sets)?;
        let others: Vec<usize> = found.others.iter().map(|&row| own[row]).collect();
        let traces = others.iter().map(|&row| self.traces[origins[row]].trace.id.clone()).collect();
        let Populations { distance, far, .. } = found;
        Some(Doubted { others, traces, distance, far, of: own.len() })
    }

    /// Trains the rest of a model by a recipe with the same estimation.
    pub(super) fn train(&self, recipe: &Recipe) -> Result<Trained, Error> {
        let catalogue = &self.catalogue;
        let Used { candidates, chosen, left_out, doubted, .. } = self.rows_of(recipe)?;
        let selected = candidates.select(&chosen);
        let fit::Fitted { explained, projection, coordinates, coordinate_names, statistics, densities, choice } =
            fit::fit(&selected, recipe)?;
        let Candidates { table: raw, features: feature_names, .. } = selected;
        let centre = (candidates.table.mean(), &candidates.table.usual);
        let (used, core_projection, core_usual) = compose(centre, &chosen, catalogue, &projection);
        let core_features = used.iter().map(|&place| catalogue.core_feature(place)).collect();
        let core_covariates = match &explained {
            Some(explained) => explained.core(catalogue, &chosen, &used),
            None => Covariates { list: vec![], map: vec![] },
        };
        let segment_s = (self.interval_s > 0.0).then_some(self.segment as f64 * self.interval_s);
        let fitted = explained.as_ref().map_or(0, Explained::fitted);
        let rising = recipe.rising(&coordinate_names);
        let rows = Rows { table: &coordinates, names: &coordinate_names, fitted, rising };
        let runs = recipe.runs(&candidates);
        let shrink = choice.as_ref().map_or(recipe.shrink, |choice| Shrink::To(choice.shrinkage));
        let fixed = Recipe { shrink, ..recipe.clone() };
        let directions = directions::of_candidates((&coordinates, &coordinate_names), &candidates, recipe);
        let watch = novelty::train(rows, (runs.as_deref(), segment_s), &fixed, (&densities, directions))?;
        Ok(Trained {
            recipe: recipe.clone(),
            classes: self.classes.to_vec(),
            feature_names,
            automatic: None,
            dependence: None,
            explained,
            projection,
            raw,
            coordinates,
            coordinate_names,
            statistics,
            left_out,
            doubted,
            densities,
            choice,
            candidates,
            watch,
            sight: Sight::default(),
            core_features,
            core_covariates,
            core_projection,
            core_usual,
            parts: self.parts.clone(),
            segment_samples: self.segment,
            interval_s: self.interval_s,
            block_mean: 1,
        })
    }
}

/// Returns the features of all segments; those of a part without a result are missing.
fn estimate(
    traces: &[LabelledTrace],
    (classes, recipe): (&[String], &Recipe),
    (parts, catalogue): (&Parts, &Catalogue),
    segment: usize,
) -> Result<Estimated, Error> {
    let (table, origins, reasons) = core_features::run(traces, classes, (parts, catalogue), segment)?;
    let groups = groups(&recipe.validation.groups, traces.len())?;
    let groups = origins.iter().map(|&trace| groups[trace]).collect();
    let candidates = Candidates { table, features: catalogue.names(), groups, covariates: None };
    Ok(Estimated { candidates, origins, reasons })
}

/// Returns the places of a recipe's features and covariates.
fn places(catalogue: &Catalogue, recipe: &Recipe) -> Result<[Vec<usize>; 2], Error> {
    let chosen = recipe.rising_last(catalogue, catalogue.choose(&recipe.features)?)?;
    Ok([chosen, covariate_places(catalogue, recipe)?])
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
        let near = || among(name, &names);
        let unknown = || Error::Usage(format!("--covariates: no {name} in this model{}", near()));
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

/// Refuses a training set without segments, or with too few of a class; of each trace its class and its segments.
fn check_classes(counts: Vec<(usize, usize)>, classes: &[String], healthy: Option<usize>) -> Result<(), Error> {
    if counts.iter().all(|(_, segments)| *segments == 0) {
        return Err(Error::Training("the training set is empty; give labelled traces or a wider selection".into()));
    }
    if classes.len() < 2 && healthy.is_none() {
        let only = classes.join(", ");
        return Err(Error::Training(format!(
            "training needs at least two classes, but there is only {only}; widen the selection, or say that it is healthy"
        )));
    }
    for (class, name) in classes.iter().enumerate() {
        let count: usize = counts.iter().filter(|(own, _)| *own == class).map(|(_, segments)| segments).sum();
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

/// Returns the places of features that are tested together: each friction alone, since the parts of a friction lie on
/// curves, and by its logarithm, since it differs by a factor with the temperature; all others together.
fn sets(names: &[String], chosen: &[usize]) -> Vec<Vec<usize>> {
    let (friction, others): (Vec<usize>, Vec<usize>) = chosen.iter().partition(|&&place| {
        features::friction(&names[place]).is_some_and(|term| names[place] != format!("{term}_score"))
    });
    let logarithm = |place: usize| {
        let log = format!("{}_log", names[place]);
        let skewed = ["viscous", "coulomb", "drag"].contains(&names[place].as_str());
        names.iter().position(|other| skewed && *other == log).unwrap_or(place)
    };
    let mut sets: Vec<Vec<usize>> = friction.into_iter().map(|place| vec![logarithm(place)]).collect();
    sets.sort_unstable();
    sets.dedup();
    sets.push(others);
    sets.retain(|set| !set.is_empty());
    sets
}
