//! Means and covariances of labelled rows.
//!
//! Values with errors or missing values are accounted for ([`super::moments`]): the covariances are those of the values
//! without their errors. Without errors and missing values they are the sample covariances.

use nalgebra::{DMatrix, DVector};

use super::covariance::symmetric;
use super::moments::{Cell, Observed, cells, moments_of};
use crate::Error;
use crate::train::{AffineMap, FeatureTable};

/// Returns the mean of rows of equal length.
pub(crate) fn mean(rows: &[DVector<f64>]) -> DVector<f64> {
    let mut sum = DVector::zeros(rows.first().map_or(0, DVector::len));
    for row in rows {
        sum += row;
    }
    sum / rows.len().max(1) as f64
}

/// Returns the scatter Σ (x − m)(x − m)ᵀ.
fn scatter<'a>(rows: impl Iterator<Item = &'a DVector<f64>>, mean: &DVector<f64>) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(mean.len(), mean.len());
    for row in rows {
        let centred = row - mean;
        sum += &centred * centred.transpose();
    }
    sum
}

/// First and second moments of a labelled table.
#[derive(Clone, Debug)]
pub struct ClassStatistics {
    /// Mean of all rows.
    pub total_mean: DVector<f64>,
    /// Covariance of all rows, divisor N − 1.
    pub total: DMatrix<f64>,
    /// Mean of each class.
    pub means: Vec<DVector<f64>>,
    /// Covariance of each class, divisor N_k − 1.
    pub covariances: Vec<DMatrix<f64>>,
    /// Number of rows of each class.
    pub counts: Vec<usize>,
    /// Pooled within-class covariance, divisor N − C.
    pub pooled: DMatrix<f64>,
}

impl ClassStatistics {
    /// Computes the moments of a table in which every class has rows; `names` are those of the features.
    ///
    /// # Errors
    /// A feature that fewer than two rows of a class have, if the class has more rows.
    pub fn of(table: &FeatureTable, names: &[String]) -> Result<Self, Error> {
        if table.is_exact() {
            return Ok(Self::new(table));
        }
        require_values(table, names)?;
        // Rows without any value, such as those of a defect outside the range of a covariate, tell nothing.
        let rows: Vec<Observed<'_>> = table.observed().into_iter().filter(Observed::has_any).collect();
        let count = |class: usize| table.classes.iter().filter(|c| **c == class).count();
        Ok(Self::estimated(&cells(&rows), (0..table.names.len()).map(count).collect()))
    }

    /// Computes the moments of rows whose sums are given, of every class.
    ///
    /// # Errors
    /// A feature that fewer than two rows of a class have.
    pub fn of_cells(sums: &[Cell], classes: &[String], names: &[String]) -> Result<Self, Error> {
        let of = |class: usize| sums.iter().filter(move |cell| cell.class == class);
        let rows = |class: usize| of(class).map(|cell| cell.count).sum::<f64>() as usize;
        for (class, class_name) in classes.iter().enumerate() {
            for (feature, name) in names.iter().enumerate() {
                let with = of(class).filter(|cell| cell.variance[feature].is_finite());
                let found = with.map(|cell| cell.count).sum::<f64>() as usize;
                if found < 2 {
                    let problem =
                        format!("{found} of the {} segments of class {class_name} have feature {name}", rows(class));
                    return Err(Error::Training(problem + "; give more, or leave the feature or the class out"));
                }
            }
        }
        let counts: Vec<usize> = (0..classes.len()).map(rows).collect();
        let exact = sums.len() == classes.len() && sums.iter().all(|cell| cell.variance.iter().all(|v| *v <= 0.0));
        if !exact {
            return Ok(Self::estimated(sums, counts));
        }
        let means: Vec<DVector<f64>> = sums.iter().map(|cell| cell.mean.clone()).collect();
        let covariances = sums.iter().map(|cell| &cell.scatter / (cell.count - 1.0).max(1.0)).collect();
        let freedom = counts.iter().sum::<usize>().saturating_sub(counts.len()).max(1) as f64;
        let pooled = sums.iter().map(|cell| &cell.scatter).sum::<DMatrix<f64>>() / freedom;
        let (total_mean, total) = total(&means, &counts, &pooled);
        Ok(Self { total_mean, total, means, covariances, counts, pooled })
    }

    /// Estimates the moments of rows with errors or missing values, `counts` of each class.
    fn estimated(sums: &[Cell], counts: Vec<usize>) -> Self {
        let classes = counts.len();
        let pooled = moments_of(sums, classes);
        let of_class = |class: usize| {
            let own = sums.iter().filter(|cell| cell.class == class).map(|cell| Cell { class: 0, ..cell.clone() });
            moments_of(&own.collect::<Vec<_>>(), 1).covariance
        };
        let covariances =
            if classes > 1 { (0..classes).map(of_class).collect() } else { vec![pooled.covariance.clone()] };
        let (total_mean, total) = total(&pooled.means, &counts, &pooled.covariance);
        Self { total_mean, total, means: pooled.means, covariances, counts, pooled: pooled.covariance }
    }

    /// Computes the moments of a table without errors and missing values, in which every class has rows.
    #[must_use]
    pub fn new(table: &FeatureTable) -> Self {
        let total_mean = mean(&table.rows);
        let divide = |scatter: DMatrix<f64>, degrees: usize| scatter / degrees.max(1) as f64;
        let total = divide(scatter(table.rows.iter(), &total_mean), table.rows.len() - 1);
        let of_class = |class: usize| {
            let rows = table.rows.iter().zip(&table.classes);
            rows.filter(move |(_, c)| **c == class).map(|(row, _)| row.clone()).collect::<Vec<_>>()
        };
        let (mut means, mut covariances, mut counts) = (vec![], vec![], vec![]);
        let mut within = DMatrix::zeros(total_mean.len(), total_mean.len());
        for class in 0..table.names.len() {
            let rows = of_class(class);
            let centre = mean(&rows);
            let scatter = scatter(rows.iter(), &centre);
            within += &scatter;
            covariances.push(divide(scatter, rows.len() - 1));
            means.push(centre);
            counts.push(rows.len());
        }
        let pooled = divide(within, table.rows.len().saturating_sub(table.names.len()));
        Self { total_mean, total, means, covariances, counts, pooled }
    }

    /// Returns the moments of the coordinates by this map, which are in `coordinates`.
    pub(crate) fn mapped(&self, map: &AffineMap, coordinates: &FeatureTable) -> Self {
        // A coordinate that is missing has lost what its other features contribute; the moments have it.
        if coordinates.is_exact() { Self::new(coordinates) } else { self.map(map) }
    }

    /// Returns the moments of the coordinates by this map.
    #[must_use]
    pub fn map(&self, map: &AffineMap) -> Self {
        let matrix = |covariance: &DMatrix<f64>| symmetric(&(&map.matrix * covariance * map.matrix.transpose()));
        Self {
            total_mean: map.apply(&self.total_mean),
            total: matrix(&self.total),
            means: self.means.iter().map(|mean| map.apply(mean)).collect(),
            covariances: self.covariances.iter().map(matrix).collect(),
            counts: self.counts.clone(),
            pooled: matrix(&self.pooled),
        }
    }
}

/// Returns mean and covariance of all rows from those of the classes.
fn total(means: &[DVector<f64>], counts: &[usize], pooled: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let rows: usize = counts.iter().sum();
    let weighted = means.iter().zip(counts).map(|(mean, &count)| mean * count as f64);
    let mean = weighted.sum::<DVector<f64>>() / rows as f64;
    let mut scatter = pooled * rows.saturating_sub(means.len()) as f64;
    for (own, &count) in means.iter().zip(counts) {
        let away = own - &mean;
        scatter += &away * away.transpose() * count as f64;
    }
    (mean, scatter / rows.saturating_sub(1).max(1) as f64)
}

/// Returns an error if a class has too few values of a feature for a mean and a spread.
fn require_values(table: &FeatureTable, names: &[String]) -> Result<(), Error> {
    for (class, class_name) in table.names.iter().enumerate() {
        let rows = table.classes.iter().filter(|c| **c == class).count();
        for (feature, name) in names.iter().enumerate() {
            let found = table.with(class, feature).count();
            if found < rows.min(2) {
                return Err(Error::Training(format!(
                    "only {found} of the {rows} traces of class {class_name} have feature {name}; give more traces, or \
                     leave the feature out"
                )));
            }
        }
    }
    Ok(())
}
