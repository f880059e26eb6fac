//! A fit and the tails of its healthy distances → the gate, and the complete model.
//!
//! The tails of the gate's law follow from a second pass over the parts ([`Tails`]), or have their prior probabilities.

use bearing_watch::model::{Covariates, Feature, MAX_BLOCK_MEAN};
use nalgebra::DVector;

use super::fit::Fit;
use super::tails::Tails;
use model::Error;
use model::core::features::Catalogue;
use model::trace::Preparation;
use model::train::discriminant::{of_statistics, shrunk};
use model::train::novelty::of_sums;
use model::train::{Candidates, FeatureTable, Recipe, Shrink, Sight, Trained, compose};

impl Fit {
    /// Trains the gate and completes the model; also returns the preparation that the detector does not do itself.
    ///
    /// # Errors
    /// Too few runs or rows for the rate, if a gate is required, and as [`Fit::new`].
    pub fn train(&self, tails: Option<&Tails>) -> Result<(Trained, Preparation), Error> {
        let recipe = &self.recipe;
        let names = (&self.classes[..], &self.coordinate_names[..]);
        let densities = match recipe.shrink {
            Shrink::To(shrinkage) => shrunk(&self.statistics, &self.coordinate_names, recipe, shrinkage)?,
            Shrink::Not | Shrink::Chosen => of_statistics(&self.statistics, names, recipe)?,
        };
        let catalogue = self.plan.catalogue();
        let usual = DVector::from_column_slice(&self.plan.usual);
        let (used, core_projection, core_usual) =
            compose((self.means.clone(), &usual), &self.chosen, &catalogue, &self.projection);
        let [recorded_s, interval_s] = self.plan.intervals_s();
        let segment = self.plan.segment_samples();
        let segment_s = (interval_s > 0.0).then_some(segment as f64 * interval_s);
        let unknown = Tails::new(self);
        let tails = tails.unwrap_or(&unknown).found(self);
        let watch = of_sums::train(
            (self.healthy.as_ref(), &tails),
            (&self.coordinate_names, self.rising),
            (&self.sizes, segment_s),
            recipe,
            &densities,
        )?;
        let preparation = self.plan.preparation();
        let inside = preparation.decimate <= 1 && preparation.block_mean <= usize::from(MAX_BLOCK_MEAN);
        let trained = Trained {
            automatic: None,
            dependence: None,
            doubted: None,
            recipe: self.recipe_by_classes(),
            classes: self.classes.clone(),
            feature_names: self.names.clone(),
            explained: None,
            projection: self.projection.clone(),
            raw: empty(&self.classes),
            coordinates: empty(&self.classes),
            coordinate_names: self.coordinate_names.clone(),
            statistics: self.statistics.clone(),
            left_out: self.left_out.clone(),
            densities,
            choice: None,
            candidates: Candidates {
                table: empty(&self.classes),
                features: catalogue.names(),
                groups: vec![],
                covariates: None,
            },
            watch,
            sight: Sight::default(),
            core_features: core_features(&catalogue, &used),
            core_covariates: Covariates { list: vec![], map: vec![] },
            core_projection,
            core_usual,
            parts: self.plan.parts()?,
            segment_samples: segment,
            interval_s: if inside { recorded_s } else { interval_s },
            block_mean: if inside { preparation.block_mean } else { 1 },
        };
        // Features alone do not say what segments show.
        let sight = Sight { orders: trained.needed_scores() };
        let trained = Trained { sight, ..trained };
        Ok((trained, if inside { Preparation::NONE } else { preparation }))
    }

    /// The recipe with the nominal class of the plan at its place among these classes.
    fn recipe_by_classes(&self) -> Recipe {
        let mut recipe = self.recipe.clone();
        let nominal = self.plan.classes.get(recipe.estimation.nominal);
        recipe.estimation.nominal = self.classes.iter().position(|name| Some(name) == nominal).unwrap_or(0);
        recipe
    }
}

fn empty(classes: &[String]) -> FeatureTable {
    FeatureTable::exact(vec![], vec![], classes.to_vec())
}

fn core_features(catalogue: &Catalogue, used: &[usize]) -> Vec<Feature> {
    used.iter().map(|&place| catalogue.core_feature(place)).collect()
}
