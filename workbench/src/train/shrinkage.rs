//! Covariances between those of a quadratic and of a linear discriminant (Friedman 1989, Regularized Discriminant
//! Analysis).
//!
//! ```text
//! S_k(λ) = ((1 − λ) ν_k S_k + λ ν S) / ((1 − λ) ν_k + λ ν),   ν_k = N_k − 1, ν = N − C        (1)
//! Σ_k(λ, γ) = (1 − γ) S_k(λ) + γ diag S_k(λ)                                                 (2)
//! ```
//!
//! S_k is the own, S the pooled covariance: λ = 0 is quadratic, λ = 1 linear, γ = 1 takes the coordinates as
//! independent. Friedman's (2) goes towards tr(S_k(λ))/d · I, which depends on the units of the features; their
//! diagonal does not.

use nalgebra::DMatrix;

use super::ClassStatistics;

/// λ and γ of (1) and (2), each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shrinkage {
    /// λ: from the classes' own covariances to the pooled one.
    pub lambda: f64,
    /// γ: from there to its diagonal.
    pub gamma: f64,
}

/// Whether covariances are shrunk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shrink {
    /// Linear or quadratic, as the recipe says.
    Not,
    /// By these numbers.
    To(Shrinkage),
    /// By the numbers of the best cross-validated guarded log score.
    Chosen,
}

impl Shrinkage {
    /// Whether all classes have one covariance.
    #[must_use]
    pub fn is_shared(self) -> bool {
        self.lambda >= 1.0
    }

    /// Σ_k(λ, γ) of every class, or of all where it is shared.
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
