//! Labelled rows → covariates' coefficients, projection and class densities: all parts of training that use the classes.

use nalgebra::DVector;

use super::scores::Prediction;
use super::shrinkage::Shrink;
use super::shrinkage_search::{self, Choice};
use super::{discriminant, projection};
use crate::Error;
use crate::core::coordinates;
use crate::train::rows::covariates::{self, Explained};
use crate::train::rows::table::AffineMap;
use crate::train::{Candidates, ClassStatistics, FeatureTable, GaussianClasses, Recipe};

/// The result of a fit.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) explained: Option<Explained>,
    pub(crate) projection: AffineMap,
    pub(crate) coordinates: FeatureTable,
    pub(crate) coordinate_names: Vec<String>,
    pub(crate) statistics: ClassStatistics,
    pub(crate) densities: GaussianClasses,
    pub(crate) choice: Option<Choice>,
}

impl Fitted {
    /// Returns the coordinates of a row of candidates with the features of the fit, with the variances of their errors.
    pub(crate) fn coordinates_of(&self, candidates: &Candidates, row: usize) -> (DVector<f64>, DVector<f64>) {
        match &self.explained {
            Some(explained) => {
                let (value, variance) = explained.corrected_row(candidates, row);
                self.projection.apply_with(&value, &variance)
            }
            None => self.projection.apply_with(&candidates.table.rows[row], &candidates.table.variances[row]),
        }
    }

    /// Predicts the class of a row of candidates with the features of the fit.
    pub(crate) fn predict(&self, candidates: &Candidates, row: usize, weight: f64) -> Prediction {
        let (z, variances) = self.coordinates_of(candidates, row);
        let log_posteriors = self.densities.log_posteriors(&z, &variances);
        let decided = Some(self.densities.decide(&log_posteriors));
        Prediction { truth: candidates.table.classes[row], decided, log_posteriors, weight }
    }
}

/// Fits the recipe to the rows; if the recipe chooses the shrinkage, it is chosen on these rows alone.
pub(crate) fn fit(candidates: &Candidates, recipe: &Recipe) -> Result<Fitted, Error> {
    let features = &candidates.features;
    let explained = covariates::fit(candidates, recipe)?;
    let own = explained.as_ref().map(|explained| explained.corrected(candidates));
    let table = own.as_ref().unwrap_or(&candidates.table);
    let raw = ClassStatistics::of(table, features)?;
    let projection = projection::of_statistics(&raw, features, recipe.projection)?;
    let coordinates = table.map(&projection);
    let statistics = raw.mapped(&projection, &coordinates);
    let coordinate_names = coordinates::of_map(&projection.matrix, features);
    let choice = match recipe.shrink {
        Shrink::Chosen => Some(shrinkage_search::search(candidates, recipe)?),
        Shrink::Not | Shrink::To(_) => None,
    };
    let shrink = match (recipe.shrink, &choice) {
        (Shrink::To(shrinkage), _) => Some(shrinkage),
        (_, choice) => choice.as_ref().map(|choice| choice.shrinkage),
    };
    let densities = match shrink {
        Some(shrinkage) => discriminant::shrunk(&statistics, &coordinate_names, recipe, shrinkage)?,
        None => discriminant::of_statistics(&statistics, (&table.names, &coordinate_names), recipe)?,
    };
    Ok(Fitted { explained, projection, coordinates, coordinate_names, statistics, densities, choice })
}

/// Returns the candidates without what the covariates explain, by all rows.
pub(crate) fn corrected(candidates: &Candidates, recipe: &Recipe) -> Result<Candidates, Error> {
    let Some(explained) = covariates::fit(candidates, recipe)? else { return Ok(candidates.clone()) };
    Ok(Candidates { table: explained.corrected(candidates), covariates: None, ..candidates.clone() })
}

#[cfg(test)]
mod tests {
    use bearing_watch::plan::Kind;
    use nalgebra::DVector;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::identify::Structure;
    use crate::train::{FeatureTable, Shrinkage};

    fn recipe(shrink: Shrink) -> Recipe {
        let structure = Structure::new(1, 1, 1, 1, 1);
        Recipe { shrink, ..Recipe::new(structure) }
    }

    /// Returns two classes of normal rows. The mean of the second class is `shift` in the first feature, and its
    /// standard deviations are `spread` times those of the first; both classes have the correlation `correlation`.
    fn two(rows: usize, features: usize, (shift, spread, correlation): (f64, f64, f64)) -> Candidates {
        let mut rng = ChaCha8Rng::seed_from_u64(17);
        let row = |k: usize| {
            let (class, common): (_, f64) = (k % 2, StandardNormal.sample(&mut rng));
            let scale = if class == 1 { spread } else { 1.0 };
            DVector::from_fn(features, |i, _| {
                let own: f64 = StandardNormal.sample(&mut rng);
                let x = correlation.sqrt() * common + (1.0 - correlation).sqrt() * own;
                scale * x + if class == 1 && i == 0 { shift } else { 0.0 }
            })
        };
        let rows: Vec<DVector<f64>> = (0..rows).map(row).collect();
        let classes = (0..rows.len()).map(|k| k % 2).collect();
        let groups = (0..rows.len()).collect();
        let table = FeatureTable::exact(rows, classes, vec!["a".into(), "b".into()]);
        Candidates { table, features: (0..features).map(|k| format!("f{k}")).collect(), groups, covariates: None }
    }

    #[test]
    fn the_ends_are_quadratic_and_linear() {
        let candidates = two(60, 4, (1.0, 2.0, 0.3));
        for (lambda, kind) in [(0.0, Kind::Quadratic), (1.0, Kind::Linear)] {
            let shrunk = fit(&candidates, &recipe(Shrink::To(Shrinkage { lambda, gamma: 0.0 }))).expect("regular");
            let plain = fit(&candidates, &Recipe { discriminant: kind, ..recipe(Shrink::Not) }).expect("regular");
            assert_eq!(shrunk.densities.kind, kind);
            for (a, b) in shrunk.densities.covariances.iter().zip(&plain.densities.covariances) {
                assert!((a - b).amax() < 1e-12, "{a} {b}"); // the divisors cancel except for rounding
            }
        }
    }

    #[test]
    fn a_spread_of_sizes_keeps_the_name_of_a_smaller_defect() {
        let candidates = two(60, 2, (40.0, 1.0, 0.0));
        let quadratic = |size_spread: f64| {
            let mut recipe = Recipe { size_spread, discriminant: Kind::Quadratic, ..recipe(Shrink::Not) };
            recipe.alarms.healthy = Some(0);
            recipe
        };
        let of = |size_spread: f64| fit(&candidates, &quadratic(size_spread)).expect("regular").densities;
        let (plain, wide) = (of(0.0), of(0.2));
        let away = &plain.means[1] - &plain.means[0];
        assert_eq!(wide.covariances[0], plain.covariances[0]);
        let added = &wide.covariances[1] - &plain.covariances[1];
        assert!((added - &away * away.transpose() * 0.04).amax() < 1e-12);
        // A defect of 0.45 of the trained size is nearer to the healthy class.
        let small = &plain.means[0] + &away * 0.45;
        let named = |densities: &GaussianClasses| densities.decide(&densities.log_likelihoods(&small));
        assert_eq!((named(&plain), named(&wide)), (0, 1));
        let message = |recipe: Recipe| fit(&candidates, &recipe).expect_err("refused").to_string();
        let problem = "--size-spread needs --healthy and separate covariances (--discriminant quadratic)";
        assert_eq!(message(Recipe { discriminant: Kind::Linear, ..quadratic(0.2) }), problem);
        assert_eq!(message(Recipe { alarms: crate::train::Alarms::default(), ..quadratic(0.2) }), problem);
    }

    #[test]
    fn the_choice_follows_the_data() {
        let chosen = |rows, features, truth| {
            let choice =
                shrinkage_search::search(&two(rows, features, truth), &recipe(Shrink::Chosen)).expect("enough rows");
            let at = |lambda: f64, gamma: f64| {
                let point =
                    choice.grid.iter().find(|p| p.shrinkage == Shrinkage { lambda, gamma }).expect("in the grid");
                point.score
            };
            let [linear, quadratic] = [at(1.0, 0.0), at(0.0, 0.0)];
            let best = choice.grid.iter().map(|p| p.score).fold(f64::INFINITY, f64::min);
            (choice.shrinkage, best, linear, quadratic)
        };
        // Few rows with one common covariance: the choice is near the shared covariance; the classes' own are
        // inaccurate.
        let (shrinkage, best, linear, quadratic) = chosen(30, 6, (1.5, 1.0, 0.5));
        assert!(
            shrinkage.lambda >= 0.5 && best <= linear && quadratic > linear + 0.05,
            "{shrinkage:?} {linear} {quadratic}"
        );
        // Many rows whose classes differ in spread only: the choice is near the classes' own covariances; with one
        // common covariance the classes cannot be distinguished.
        let (shrinkage, best, linear, quadratic) = chosen(400, 4, (0.0, 3.0, 0.5));
        assert!(shrinkage.lambda <= 0.25 && best <= quadratic && linear > 0.65, "{shrinkage:?} {linear} {quadratic}");
        // Fewer rows per class than features, and independent features: only a diagonal covariance can be estimated.
        let (shrinkage, best, linear, quadratic) = chosen(24, 14, (2.5, 1.0, 0.0));
        assert!(shrinkage.gamma >= 0.25 && best < linear && quadratic.is_infinite(), "{shrinkage:?} {best} {linear}");
    }
}
