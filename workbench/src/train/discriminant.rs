//! Gaussian class densities for linear and quadratic discriminants (thesis Eq. 2.64–2.67).

use bearing_watch::plan::Kind;
use nalgebra::{DMatrix, DVector};

use super::shrinkage::Shrinkage;
use super::statistics::{singular, whitening};
use super::{ClassStatistics, FeatureTable, Recipe};
use crate::Error;

/// Class densities, priors and costs in double precision; fields as in [`bearing_watch::model::Discriminant`].
#[derive(Clone, Debug)]
pub struct GaussianClasses {
    /// Linear or quadratic.
    pub kind: Kind,
    /// μ of each class.
    pub means: Vec<DVector<f64>>,
    /// U with UᵀU = Σ⁻¹: one (linear) or one per class.
    pub whitening: Vec<DMatrix<f64>>,
    /// −½ (d ln 2π + ln |Σ|) of each class.
    pub log_normaliser: Vec<f64>,
    /// Prior of each class.
    pub priors: Vec<f64>,
    /// `cost[i][k]`: cost of deciding i if k is true.
    pub cost: Vec<Vec<f64>>,
}

impl GaussianClasses {
    /// Returns ln p(z|k) of every class, in double precision.
    #[must_use]
    pub fn log_likelihoods(&self, z: &DVector<f64>) -> Vec<f64> {
        let classes = self.means.iter().zip(&self.log_normaliser).enumerate();
        classes
            .map(|(k, (mean, g))| {
                let u = self.whitening.get(k).unwrap_or(&self.whitening[0]);
                g - 0.5 * (u * (z - mean)).norm_squared()
            })
            .collect()
    }

    /// Returns ln P(k|z) of every class.
    #[must_use]
    pub fn log_posteriors(&self, z: &DVector<f64>) -> Vec<f64> {
        let joint: Vec<f64> = self.log_likelihoods(z).iter().zip(&self.priors).map(|(l, p)| l + p.ln()).collect();
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
pub(crate) fn train(table: &FeatureTable, names: &[String], recipe: &Recipe) -> Result<GaussianClasses, Error> {
    let statistics = ClassStatistics::new(table);
    let classes = table.names.len();
    let factors = match recipe.discriminant {
        Kind::Linear => {
            let refuse = |dependent| singular("the pooled classes", table.rows.len(), classes, names, dependent);
            vec![whitening(&statistics.pooled).map_err(refuse)?]
        }
        Kind::Quadratic => {
            let each = statistics.covariances.iter().zip(&table.names).zip(&statistics.counts);
            each.map(|((covariance, class), &rows)| {
                whitening(covariance)
                    .map_err(|dependent| singular(&format!("class {class}"), rows, 1, names, dependent))
            })
            .collect::<Result<_, _>>()?
        }
    };
    densities(&statistics, factors, recipe.discriminant, recipe)
}

/// Returns densities whose covariances are shrunk: between the classes' own, the pooled one, and its diagonal.
pub(crate) fn shrunk(
    statistics: &ClassStatistics,
    names: &[String],
    recipe: &Recipe,
    shrinkage: Shrinkage,
) -> Result<GaussianClasses, Error> {
    let (rows, classes) = (statistics.counts.iter().sum(), statistics.counts.len());
    let refuse = |dependent| singular("the classes", rows, classes, names, dependent);
    let covariances = shrinkage.covariances(statistics);
    let factors = covariances.iter().map(|covariance| whitening(covariance).map_err(refuse));
    let factors = factors.collect::<Result<_, _>>()?;
    let kind = if shrinkage.is_shared() { Kind::Linear } else { Kind::Quadratic };
    densities(statistics, factors, kind, recipe)
}

/// Returns densities from the class means, and from whitening matrices with ln |Σ|: one pair, or one per class.
fn densities(
    statistics: &ClassStatistics,
    factors: Vec<(DMatrix<f64>, f64)>,
    kind: Kind,
    recipe: &Recipe,
) -> Result<GaussianClasses, Error> {
    let (classes, features) = (statistics.means.len(), statistics.total_mean.len());
    let normaliser = |log_determinant: f64| -0.5 * (features as f64 * std::f64::consts::TAU.ln() + log_determinant);
    let log_normaliser = (0..classes).map(|k| normaliser(factors.get(k).unwrap_or(&factors[0]).1)).collect();
    Ok(GaussianClasses {
        kind,
        means: statistics.means.clone(),
        whitening: factors.into_iter().map(|(u, _)| u).collect(),
        log_normaliser,
        priors: priors(&recipe.priors, classes)?,
        cost: costs(&recipe.cost, classes)?,
    })
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
