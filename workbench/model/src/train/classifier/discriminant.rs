//! Gaussian class densities for linear and quadratic discriminants (thesis Eq. 2.64–2.67).
//!
//! Coordinates with errors widen the covariances, and missing coordinates are left out, as in the core.
//!
//! A defect grows from nothing, so that smaller ones lie between the healthy class and the class of the trained size.
//! With a relative spread τ of sizes, every class k other than the healthy one h has
//!
//! ```text
//! Σ_k + τ² (μ_k − μ_h)(μ_k − μ_h)ᵀ                                                            (1)
//! ```

use bearing_watch::plan::Kind;
use nalgebra::{DMatrix, DVector};

use super::shrinkage::Shrinkage;
use crate::Error;
use crate::train::distribution::covariance::{log_density, singular, whitening};
use crate::train::distribution::moments;
use crate::train::{ClassStatistics, FeatureTable, Recipe};

/// Class densities, priors and costs in double precision; fields as in [`bearing_watch::model::Discriminant`].
#[derive(Clone, Debug)]
pub struct GaussianClasses {
    /// Linear or quadratic.
    pub kind: Kind,
    /// μ of each class.
    pub means: Vec<DVector<f64>>,
    /// Σ: one (linear) or one per class.
    pub covariances: Vec<DMatrix<f64>>,
    /// U with UᵀU = Σ⁻¹, and ln |Σ|, of each covariance.
    factors: Vec<(DMatrix<f64>, f64)>,
    /// Prior of each class.
    pub priors: Vec<f64>,
    /// `cost[i][k]`: cost of deciding i if k is true.
    pub cost: Vec<Vec<f64>>,
}

impl GaussianClasses {
    /// Returns ln p(z|k) of every class at coordinates without errors.
    #[must_use]
    pub fn log_likelihoods(&self, z: &DVector<f64>) -> Vec<f64> {
        let each = |(class, mean): (usize, &DVector<f64>)| {
            let (u, log_determinant) = self.factors.get(class).unwrap_or(&self.factors[0]);
            log_density(z.len(), *log_determinant, (u * (z - mean)).norm_squared())
        };
        self.means.iter().enumerate().map(each).collect()
    }

    /// Returns ln p(z|k) of every class at coordinates whose errors have these variances, infinite if missing.
    fn log_likelihoods_with(&self, z: &DVector<f64>, variances: &DVector<f64>) -> Vec<f64> {
        if variances.iter().all(|variance| *variance <= 0.0) {
            return self.log_likelihoods(z);
        }
        let each = |(class, mean): (usize, &DVector<f64>)| {
            let covariance = self.covariances.get(class).unwrap_or(&self.covariances[0]);
            let density = moments::log_density((mean, covariance), z, variances);
            density.unwrap_or(f64::NEG_INFINITY)
        };
        self.means.iter().enumerate().map(each).collect()
    }

    /// Returns ln P(k|z) of every class at coordinates whose errors have these variances; the priors if every
    /// coordinate is missing.
    #[must_use]
    pub fn log_posteriors(&self, z: &DVector<f64>, variances: &DVector<f64>) -> Vec<f64> {
        let likelihoods = self.log_likelihoods_with(z, variances);
        let joint: Vec<f64> = likelihoods.iter().zip(&self.priors).map(|(l, p)| l + p.ln()).collect();
        let largest = joint.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total = largest + joint.iter().map(|x| (x - largest).exp()).sum::<f64>().ln();
        joint.iter().map(|x| x - total).collect()
    }

    /// Returns the class of least expected cost (thesis Eq. 2.65).
    #[must_use]
    pub fn decide(&self, log_posteriors: &[f64]) -> usize {
        let expected = |i: &usize| -> f64 { self.cost[*i].iter().zip(log_posteriors).map(|(c, l)| c * l.exp()).sum() };
        (0..self.cost.len()).min_by(|a, b| expected(a).total_cmp(&expected(b))).unwrap_or(0)
    }
}

/// Returns the densities of the coordinates of `table`; `names` are the names of the coordinates.
pub fn train(table: &FeatureTable, names: &[String], recipe: &Recipe) -> Result<GaussianClasses, Error> {
    of_statistics(&ClassStatistics::of(table, names)?, (&table.names, names), recipe)
}

/// Returns the densities of coordinates with these moments, by the names of classes and coordinates.
pub fn of_statistics(
    statistics: &ClassStatistics,
    (classes, names): (&[String], &[String]),
    recipe: &Recipe,
) -> Result<GaussianClasses, Error> {
    let rows = statistics.counts.iter().sum();
    let covariances = match recipe.discriminant {
        Kind::Linear => {
            let refuse = |dependent| singular("the pooled classes", rows, classes.len(), names, dependent);
            vec![regular(&statistics.pooled, rows - classes.len()).map_err(refuse)?]
        }
        Kind::Quadratic => {
            let each = statistics.covariances.iter().zip(classes).zip(&statistics.counts);
            each.map(|((covariance, class), &rows)| {
                let refuse = |dependent| singular(&format!("class {class}"), rows, 1, names, dependent);
                regular(covariance, rows - 1).map_err(refuse)
            })
            .collect::<Result<_, _>>()?
        }
    };
    densities(statistics, covariances, recipe.discriminant, recipe)
}

/// A covariance with its whitening matrix and ln |Σ|.
type Factored = (DMatrix<f64>, (DMatrix<f64>, f64));

/// Returns the covariance with its factor; the error is the first dependent coordinate.
fn regular(covariance: &DMatrix<f64>, freedom: usize) -> Result<Factored, usize> {
    // Missing values hide that there are too few rows: their moments are those of the start.
    if freedom < covariance.nrows() {
        return Err(freedom);
    }
    Ok((covariance.clone(), whitening(covariance)?))
}

/// Returns densities whose covariances are shrunk: between the classes' own, the pooled one, and its diagonal.
pub fn shrunk(
    statistics: &ClassStatistics,
    names: &[String],
    recipe: &Recipe,
    shrinkage: Shrinkage,
) -> Result<GaussianClasses, Error> {
    let (rows, classes) = (statistics.counts.iter().sum(), statistics.counts.len());
    let refuse = |dependent| singular("the classes", rows, classes, names, dependent);
    let covariances = shrinkage.covariances(statistics).into_iter();
    let factored = covariances.map(|own| Ok((own.clone(), whitening(&own).map_err(refuse)?)));
    let factored = factored.collect::<Result<_, Error>>()?;
    let kind = if shrinkage.is_shared() { Kind::Linear } else { Kind::Quadratic };
    densities(statistics, factored, kind, recipe)
}

/// Returns densities from the class means and one covariance, or one per class.
fn densities(
    statistics: &ClassStatistics,
    factored: Vec<Factored>,
    kind: Kind,
    recipe: &Recipe,
) -> Result<GaussianClasses, Error> {
    let classes = statistics.means.len();
    let factored = spread(factored, (&statistics.means, kind), recipe)?;
    let (covariances, factors) = factored.into_iter().unzip();
    Ok(GaussianClasses {
        kind,
        means: statistics.means.clone(),
        covariances,
        factors,
        priors: priors(&recipe.priors, classes)?,
        cost: costs(&recipe.cost, classes)?,
    })
}

/// Returns the covariances (1) with their factors.
fn spread(
    factored: Vec<Factored>,
    (means, kind): (&[DVector<f64>], Kind),
    recipe: &Recipe,
) -> Result<Vec<Factored>, Error> {
    if recipe.size_spread <= 0.0 {
        return Ok(factored);
    }
    let Some(healthy) = recipe.alarms.healthy.filter(|_| kind == Kind::Quadratic) else {
        let problem = "--size-spread needs --healthy and separate covariances (--discriminant quadratic)";
        return Err(Error::Training(problem.into()));
    };
    let wider = |(class, (covariance, factor)): (usize, Factored)| {
        if class == healthy {
            return Ok((covariance, factor));
        }
        let away = (&means[class] - &means[healthy]) * recipe.size_spread;
        let covariance = covariance + &away * away.transpose();
        let refuse = |_| Error::Training("a class is too far from the healthy one for a spread of sizes".into());
        let factor = whitening(&covariance).map_err(refuse)?;
        Ok((covariance, factor))
    };
    factored.into_iter().enumerate().map(wider).collect()
}

/// Returns the given priors, normalised to sum 1; equal priors if none are given.
pub(crate) fn priors(asked: &[f64], classes: usize) -> Result<Vec<f64>, Error> {
    if asked.is_empty() {
        return Ok(vec![1.0 / classes as f64; classes]);
    }
    let total: f64 = asked.iter().sum();
    if asked.len() != classes || asked.iter().any(|p| !p.is_finite() || *p <= 0.0) {
        return Err(Error::Training(format!("--priors needs a positive number for each of the {classes} classes")));
    }
    Ok(asked.iter().map(|p| p / total).collect())
}

fn costs(asked: &[Vec<f64>], classes: usize) -> Result<Vec<Vec<f64>>, Error> {
    if asked.is_empty() {
        return Ok((0..classes).map(|i| (0..classes).map(|k| f64::from(u8::from(i != k))).collect()).collect());
    }
    let square = asked.len() == classes && asked.iter().all(|row| row.len() == classes);
    if !square || asked.iter().flatten().any(|c| !c.is_finite() || *c < 0.0) {
        return Err(Error::Training(format!("costs need {classes} × {classes} numbers, none negative")));
    }
    Ok(asked.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::Structure;

    #[test]
    fn half_way_between_two_classes_the_posteriors_are_the_priors() {
        // Rows −2, 0 and 0, 2 of one feature: means ∓1, equal variances.
        let rows = [-2.0, 0.0, 0.0, 2.0].map(|x| DVector::from_element(1, x)).to_vec();
        let table = FeatureTable::exact(rows, vec![0, 0, 1, 1], vec!["a".into(), "b".into()]);
        let recipe = Recipe { priors: vec![9.0, 1.0], ..Recipe::new(Structure::new(1, 1, 1, 1, 1)) };
        let densities = train(&table, &["x".into()], &recipe).expect("regular");
        assert_eq!(densities.priors, [0.9, 0.1]);
        let posteriors = densities.log_posteriors(&DVector::zeros(1), &DVector::zeros(1));
        assert!(
            (posteriors[0].exp() - 0.9).abs() < 1e-12 && (posteriors[1].exp() - 0.1).abs() < 1e-12,
            "{posteriors:?}"
        );
        // ln P(b)/P(a) = ln 1/9 + 2 z/σ², and the pooled variance is 2.
        let posteriors = densities.log_posteriors(&DVector::from_element(1, 3.0), &DVector::zeros(1));
        assert!((posteriors[1] - posteriors[0] - (3.0 - 9.0_f64.ln())).abs() < 1e-12, "{posteriors:?}");
    }
}
