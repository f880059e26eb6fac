//! Covariances between those of a quadratic and of a linear discriminant (Friedman 1989, Regularized Discriminant
//! Analysis).
//!
//! ```text
//! S_k(λ) = ((1 − λ) ν_k S_k + λ ν S) / ((1 − λ) ν_k + λ ν),   ν_k = N_k − 1, ν = N − C        (1)
//! Σ_k(λ, γ) = (1 − γ) S_k(λ) + γ diag S_k(λ)                                                 (2)
//! ```
//!
//! S_k is the class's own covariance, S the pooled one: λ = 0 is quadratic, λ = 1 is linear, and γ = 1 treats the
//! coordinates as independent. Friedman shrinks (2) towards tr(S_k(λ))/d · I, which depends on the units of the
//! features; the diagonal of S_k(λ) does not.

use nalgebra::DMatrix;

use crate::train::ClassStatistics;

/// λ and γ of (1) and (2), each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shrinkage {
    /// λ: from the classes' own covariances to the pooled one.
    pub lambda: f64,
    /// γ: from there to its diagonal.
    pub gamma: f64,
}

/// Shrinkage of the covariances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shrink {
    /// None: linear or quadratic, as set in the recipe.
    Not,
    /// Shrinkage by these numbers.
    To(Shrinkage),
    /// Shrinkage by the numbers with the best cross-validated guarded log score.
    Chosen,
}

impl Shrinkage {
    /// Returns whether all classes have one covariance.
    pub(crate) fn is_shared(self) -> bool {
        self.lambda >= 1.0
    }

    /// Returns Σ_k(λ, γ) of every class, or one matrix if it is shared.
    #[must_use]
    pub fn covariances(self, statistics: &ClassStatistics) -> Vec<DMatrix<f64>> {
        let towards_diagonal = |mut covariance: DMatrix<f64>| {
            let diagonal = covariance.diagonal();
            covariance *= 1.0 - self.gamma; // (2)
            covariance.set_diagonal(&diagonal);
            covariance
        };
        if self.is_shared() {
            return vec![towards_diagonal(statistics.pooled.clone())];
        }
        let freedom = |rows: usize, means: usize| rows.saturating_sub(means) as f64;
        let rows = statistics.counts.iter().sum();
        let pooled = self.lambda * freedom(rows, statistics.counts.len());
        let each = statistics.covariances.iter().zip(&statistics.counts);
        each.map(|(own, &rows)| {
            let weight = (1.0 - self.lambda) * freedom(rows, 1);
            towards_diagonal((own * weight + &statistics.pooled * pooled) / (weight + pooled)) // (1)
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    #[test]
    fn degrees_of_freedom_weigh_the_covariances() {
        // Classes of 3 and 9 rows: 2 and 8 degrees of freedom; the pooled covariance has 10.
        let diagonal = |x: f64, y: f64, both: f64| DMatrix::from_row_slice(2, 2, &[x, both, both, y]);
        let (mean, pooled) = (DVector::zeros(2), diagonal(2.0, 4.0, 1.0));
        let statistics = ClassStatistics {
            total_mean: mean.clone(),
            total: pooled.clone(),
            means: vec![mean.clone(), mean],
            covariances: vec![diagonal(8.0, 10.0, -5.0), diagonal(1.0, 1.0, 0.0)],
            counts: vec![3, 9],
            pooled,
        };
        let found = Shrinkage { lambda: 0.2, gamma: 0.5 }.covariances(&statistics);
        // Weights 0.8 · 2 and 0.2 · 10 of the first class, 0.8 · 8 and 2 of the second one; then half of what is beside
        // the diagonal.
        let expected = [
            diagonal((1.6 * 8.0 + 2.0 * 2.0) / 3.6, (1.6 * 10.0 + 2.0 * 4.0) / 3.6, 0.5 * (1.6 * -5.0 + 2.0) / 3.6),
            diagonal((6.4 + 2.0 * 2.0) / 8.4, (6.4 + 2.0 * 4.0) / 8.4, 0.5 * 2.0 / 8.4),
        ];
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).amax() < 1e-12, "{found} {expected}"); // rounding
        }
        let [shared] = &Shrinkage { lambda: 1.0, gamma: 0.25 }.covariances(&statistics)[..] else { panic!("shared") };
        assert!((shared - diagonal(2.0, 4.0, 0.75)).amax() < 1e-12, "{shared}");
    }
}
