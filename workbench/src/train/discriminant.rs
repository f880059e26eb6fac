//! Gaussian class densities for linear and quadratic discriminants (thesis Eq. 2.64–2.67).

use bearing_watch::decide::Kind;
use nalgebra::{DMatrix, DVector};

use super::statistics::{singular, whitening};
use super::{ClassStatistics, FeatureTable, Recipe};
use crate::Error;

/// Class densities, priors and costs in double precision; fields as in [`bearing_watch::decide::Discriminant`].
#[derive(Clone, Debug)]
pub struct GaussianClasses {
    /// Linear or quadratic.
    pub kind: Kind,
    /// μ of each class.
    pub means: Vec<DVector<f64>>,
    /// U with UᵀU = Σ⁻¹: one (linear) or one a class.
    pub whitening: Vec<DMatrix<f64>>,
    /// −½ (d ln 2π + ln |Σ|) of each class.
    pub log_normaliser: Vec<f64>,
    /// Prior of each class.
    pub priors: Vec<f64>,
    /// `cost[i][k]`.
    pub cost: Vec<Vec<f64>>,
}

impl GaussianClasses {
    /// ln p(z|k) of every class, in double precision.
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
}

/// Densities of the coordinates of `table`, which are called `names`.
pub(crate) fn train(table: &FeatureTable, names: &[String], recipe: &Recipe) -> Result<GaussianClasses, Error> {
    let statistics = ClassStatistics::new(table);
    let (classes, features) = (table.names.len(), statistics.total_mean.len());
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
    let normaliser = |log_determinant: f64| -0.5 * (features as f64 * std::f64::consts::TAU.ln() + log_determinant);
    let log_normaliser = (0..classes).map(|k| normaliser(factors.get(k).unwrap_or(&factors[0]).1)).collect();
    Ok(GaussianClasses {
        kind: recipe.discriminant,
        means: statistics.means,
        whitening: factors.into_iter().map(|(u, _)| u).collect(),
        log_normaliser,
        priors: priors(&recipe.priors, classes)?,
        cost: costs(&recipe.cost, classes)?,
    })
}

fn priors(asked: &[f64], classes: usize) -> Result<Vec<f64>, Error> {
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
