//! Projections of features: principal components, Fisher's directions, or none; each is an affine map.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::Error;
use crate::train::ClassStatistics;
use crate::train::distribution::covariance::{singular, whitening};
use crate::train::rows::table::{AffineMap, FeatureTable};

/// The kind of projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProjectionKind {
    /// Every feature, centred and divided by its pooled within-class deviation.
    None,
    /// Principal components of the centred features (thesis §2.5).
    Pca {
        /// Number of components to keep.
        keep: Keep,
        /// Divide by the total deviation first, so that units do not choose the components.
        standardised: bool,
    },
    /// Fisher's directions: largest spread of the class means relative to the spread within classes.
    Fisher {
        /// Number of directions, at most classes − 1; all if not given.
        components: Option<usize>,
    },
}

/// Number of principal components to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Keep {
    /// A fixed number.
    Components(usize),
    /// The smallest number that reaches this part of the variance.
    Variance(f64),
}

/// Returns the projection of this kind for the rows of a table; `names` are those of the features.
///
/// # Errors
/// The errors of [`of_statistics`], and of [`ClassStatistics::of`].
pub fn train(table: &FeatureTable, names: &[String], kind: ProjectionKind) -> Result<AffineMap, Error> {
    of_statistics(&ClassStatistics::of(table, names)?, names, kind)
}

/// Returns the projection of features with these moments.
pub fn of_statistics(statistics: &ClassStatistics, names: &[String], kind: ProjectionKind) -> Result<AffineMap, Error> {
    let matrix = match kind {
        ProjectionKind::None => scaling(&statistics.pooled, names)?,
        ProjectionKind::Pca { keep, standardised } => principal(&statistics.total, names, keep, standardised)?,
        ProjectionKind::Fisher { components } => fisher(statistics, names, components)?,
    };
    Ok(AffineMap { matrix, mean: statistics.total_mean.clone() })
}

/// Returns the diagonal matrix of inverse deviations.
fn scaling(covariance: &DMatrix<f64>, names: &[String]) -> Result<DMatrix<f64>, Error> {
    let deviations = covariance.diagonal().map(f64::sqrt);
    if let Some(k) = (0..names.len()).find(|&k| deviations[k].is_nan() || deviations[k] <= 0.0) {
        let problem = format!("feature {} is the same in every training trace of a class; leave it out", names[k]);
        return Err(Error::Training(problem));
    }
    Ok(DMatrix::from_diagonal(&deviations.map(|d| 1.0 / d)))
}

fn principal(total: &DMatrix<f64>, names: &[String], keep: Keep, standardised: bool) -> Result<DMatrix<f64>, Error> {
    let scale = if standardised { scaling(total, names)? } else { DMatrix::identity(names.len(), names.len()) };
    let (values, vectors) = sorted_eigen(&scale * total * &scale);
    let whole: f64 = values.iter().sum();
    let count = match keep {
        Keep::Components(count) => count,
        Keep::Variance(part) => {
            let mut reached = 0.0;
            1 + values
                .iter()
                .take_while(|value| {
                    reached += *value;
                    reached < part * whole
                })
                .count()
        }
    };
    if count == 0 || count > names.len() {
        let most = names.len();
        return Err(Error::Training(format!(
            "--components {count} of {most} features; give a number from 1 to {most}"
        )));
    }
    Ok(vectors.columns(0, count).transpose() * scale)
}

fn fisher(statistics: &ClassStatistics, names: &[String], components: Option<usize>) -> Result<DMatrix<f64>, Error> {
    let features = statistics.total_mean.len();
    let most = (statistics.means.len() - 1).min(features);
    if most == 0 {
        return Err(Error::Training(
            "Fisher's projection needs two classes; choose another for healthy traces alone".into(),
        ));
    }
    let count = components.unwrap_or(most);
    if count == 0 || count > most {
        let problem = format!(
            "Fisher's projection of {} classes has 1 to {most} components, not {count}",
            statistics.means.len()
        );
        return Err(Error::Training(problem));
    }
    let rows: usize = statistics.counts.iter().sum();
    let (white, _) = whitening(&statistics.pooled)
        .map_err(|dependent| singular("the pooled classes", rows, statistics.means.len(), names, dependent))?;
    // In whitened coordinates the within-class covariance is I, so Fisher's directions are the principal directions of
    // the class means.
    let mut between = DMatrix::zeros(features, features);
    for (mean, &rows) in statistics.means.iter().zip(&statistics.counts) {
        let away = &white * (mean - &statistics.total_mean);
        between += &away * away.transpose() * rows as f64;
    }
    let (_, vectors) = sorted_eigen(between);
    Ok(vectors.columns(0, count).transpose() * white)
}

/// Returns the eigenvalues in descending order, with their vectors. The element of largest magnitude of each vector is
/// positive, so that a retrained model has the same directions of its axes.
fn sorted_eigen(matrix: DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let eigen = SymmetricEigen::new(matrix);
    let mut places: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    places.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let mut vectors = eigen.eigenvectors.select_columns(&places);
    for mut column in vectors.column_iter_mut() {
        if column[column.iamax()] < 0.0 {
            column.neg_mut();
        }
    }
    (places.iter().map(|&k| eigen.eigenvalues[k].max(0.0)).collect(), vectors)
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    fn table() -> FeatureTable {
        // Two classes that are separated along x − y, both with a large spread along x + y.
        let row = |x: f64, y: f64| DVector::from_vec(vec![x, y]);
        let spread = [-2.0, -1.0, 0.0, 1.0, 2.0];
        let rows = spread.iter().map(|s| row(s + 0.2, *s)).chain(spread.iter().map(|s| row(*s, s + 0.2 + 0.02 * s)));
        FeatureTable::exact(rows.collect(), [[0; 5], [1; 5]].concat(), vec!["p".into(), "q".into()])
    }

    fn names() -> Vec<String> {
        vec!["x".into(), "y".into()]
    }

    #[test]
    fn fisher_finds_what_principal_components_throw_away() {
        let gap = |kind| {
            let map = train(&table(), &names(), kind).expect("regular");
            let z: Vec<f64> = table().rows.iter().map(|row| map.apply(row)[0]).collect();
            let (p, q) = z.split_at(5);
            let mean = |x: &[f64]| x.iter().sum::<f64>() / 5.0;
            let spread = |x: &[f64]| x.iter().map(|v| (v - mean(x)).abs()).fold(0.0, f64::max);
            (mean(p) - mean(q)).abs() / spread(p).max(spread(q))
        };
        assert!(gap(ProjectionKind::Fisher { components: None }) > 2.0);
        assert!(gap(ProjectionKind::Pca { keep: Keep::Components(1), standardised: true }) < 0.5);
    }

    #[test]
    fn variance_rule_keeps_enough_and_no_more() {
        let rows_kept = |part| {
            let kind = ProjectionKind::Pca { keep: Keep::Variance(part), standardised: true };
            train(&table(), &names(), kind).expect("regular").matrix.nrows()
        };
        assert_eq!((rows_kept(0.9), rows_kept(1.0)), (1, 2));
    }

    #[test]
    fn too_many_components_are_refused() {
        for kind in [
            ProjectionKind::Fisher { components: Some(2) },
            ProjectionKind::Pca { keep: Keep::Components(3), standardised: false },
            ProjectionKind::Pca { keep: Keep::Components(0), standardised: false },
        ] {
            assert!(train(&table(), &names(), kind).is_err(), "{kind:?}");
        }
    }
}
