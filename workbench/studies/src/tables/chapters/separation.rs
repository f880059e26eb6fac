//! Separation of a feature: its shift with a defect, in units of its standard deviation.
//!
//! ```text
//! s = (m_d − m_h) / √½(s_d² + s_h²)        m, s²: mean and variance (N − 1) over the traces of a class     (1)
//! w = Σ⁻¹ (m_d − m_h)                      of the training set; s of wᵀf on the validation set             (2)
//! ```
//!
//! For two normal classes at distance s with the threshold in the middle, the error rate is Φ(−s/2): 31 % for s = 1,
//! 16 % for s = 2, 0.6 % for s = 5, the distance that the source requires (§2.2.5).

use nalgebra::DVector;

use model::train::FeatureTable;
use model::train::covariance::whitening;
use model::train::statistics::ClassStatistics;

/// Equation (1) for column `feature`: class `defect` against class 0.
#[must_use]
pub fn of_feature(table: &FeatureTable, feature: usize, defect: usize) -> f64 {
    let statistics = ClassStatistics::new(table);
    let variance = |class: usize| statistics.covariances[class][(feature, feature)];
    let pooled = 0.5 * (variance(0) + variance(defect));
    (statistics.means[defect][feature] - statistics.means[0][feature]) / pooled.sqrt()
}

/// Equation (2): the linear combination of all columns that separates the training set best, evaluated on the
/// validation set. `None` if the covariance of the training set is singular.
#[must_use]
pub fn of_combination(training: &FeatureTable, validation: &FeatureTable, defect: usize) -> Option<f64> {
    let statistics = ClassStatistics::new(training);
    let pooled = (&statistics.covariances[0] + &statistics.covariances[defect]) * 0.5;
    let (u, _) = whitening(&pooled).ok()?;
    let direction = u.transpose() * (u * (&statistics.means[defect] - &statistics.means[0]));
    let rows = validation.rows.iter().map(|row| DVector::from_vec(vec![direction.dot(row)])).collect();
    Some(of_feature(&FeatureTable::exact(rows, validation.classes.clone(), validation.names.clone()), 0, defect))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(shift: [f64; 2]) -> FeatureTable {
        // Standard deviation 3 along x + y, 0.1 along x − y.
        let along = [-1.0, 0.0, 1.0, 0.5, -0.5];
        let across = [0.4, -1.0, 0.3, -0.6, 0.9];
        let place = |k: usize, [x, y]: [f64; 2]| {
            DVector::from_vec(vec![x + 3.0 * along[k] + 0.1 * across[k], y + 3.0 * along[k] - 0.1 * across[k]])
        };
        let rows = (0..5).map(|k| place(k, [0.0, 0.0])).chain((0..5).map(|k| place(k, shift)));
        let names = ["healthy", "defect"].map(String::from).to_vec();
        FeatureTable::exact(rows.collect(), [[0; 5], [1; 5]].concat(), names)
    }

    #[test]
    fn a_shift_of_known_size() {
        // Feature 0 only: rows 3·along + 0.1·across, shifted by 1.
        let values: Vec<f64> = table([0.0; 2]).rows[..5].iter().map(|row| row[0]).collect();
        let mean = values.iter().sum::<f64>() / 5.0;
        let sd = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 4.0).sqrt();
        let found = of_feature(&table([1.0, 0.0]), 0, 1);
        assert!((found - 1.0 / sd).abs() < 1e-12, "{found}");
    }

    #[test]
    fn a_combination_sees_what_no_feature_shows() {
        let moved = table([0.5, -0.5]);
        let single = of_feature(&moved, 0, 1).abs().max(of_feature(&moved, 1, 1).abs());
        let both = of_combination(&moved, &moved, 1).expect("regular");
        // Along x − y the shift is 1 and the standard deviation is 0.2 times that of `across` (0.81).
        assert!(single < 0.3 && both > 5.0, "{single} {both}");
    }
}
