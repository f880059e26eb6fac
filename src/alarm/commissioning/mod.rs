//! A healthy class learned on the drive, merged with that of the test bench.
//!
//! Enters: healthy segments of this drive, at the coordinates that the novelty gate judges. Leaves: the gate's mean,
//! covariance and law for the next segment of this drive.
//!
//! ```text
//! prior   mean m₀ counts as κ₀ segments, covariance S₀ as ν₀; the model has m₀ and S₀         (1)
//! segment Ψ ← Ψ + κ/(κ + 1) x xᵀ,  m ← m + x/(κ + 1),  κ ← κ + 1,   x = z − m                 (2)
//! start   m = m₀,  κ = κ₀,  Ψ = ν₀ S₀,  f = ν₀;  f ← f + 1 with each segment where κ > 0      (3)
//! gate    mean m,  covariance S = Ψ/f,  laws of f and κ (`law`)                               (4)
//! classes every mean of the discriminant moves by m − m₀                                      (5)
//! errors  x_k √w_k in Ψ,   w_k = s_k/(s_k + v_k),   m_k ← m_k + w_k x_k/(κ_k + w_k)           (6)
//! ```
//!
//! (2) is the conjugate update of a normal-inverse-Wishart prior (Gelman et al., Bayesian Data Analysis, §3.6), and
//! with κ₀ = 0 Welford's recursion. Ψ is kept as its factor Rᵀ D R, which (2) rotates ([`super::density`]), so it stays
//! positive definite.
//!
//! A coordinate with an excess variance v of its error has the weight w of (6), where s is its variance in S₀. If the
//! variance of this drive is s, the weighted x scatters as one without errors; if it is smaller, x scatters more, so
//! that S is too wide rather than too narrow. `κ_k` is the sum of the weights of coordinate k.
//!
//! **Weights.** If S₀ is that of one drive on the bench, a drive whose constants differ has the same scatter about
//! another mean: κ₀ small, about (scatter of a drive/scatter between drives)², ν₀ as large as S₀ is trusted. If S₀ is
//! that of many drives together, it is wider than that of this drive, and ν₀ small. A defect that the drive has already
//! is learned as healthy: `farthest` limits how large it can be, in trained standard deviations.
//!
//! **What is refused.** A segment without a verdict, with a missing coordinate, with a coordinate of a weight (6) below
//! 1/11, or too far from m₀ ([`CommissioningError`]). The whole, if segments are too few, if more than a tenth of them
//! were too far, or if their mean variance exceeds `widest` times the trained one.
//!
//! The gate's limit remains: its rate of false alarms is the trained one in the mean over drives, if the segments are
//! like those that follow. Segments of one power-up are alike: gather over several of them, and over all speeds, loads
//! and temperatures of the duty. The alarm needs constants for a baseline of this size
//! ([`CommissioningConstants::evidence`]). Cost of a segment: a classification, and 2 Z² multiply-adds; of the end:
//! the quantiles of a law for each gate and each rising coordinate, by bisection; do it in the main loop.

mod error;
mod law;

pub use error::CommissioningError;

use super::evidence::EvidenceConstants;
use crate::decide::gates::density::Density;
use crate::decide::gates::rising;
use crate::decide::{Classification, Classifier, Decision, Estimates, Novelty};
use crate::plan::{Array, Cells, Plan};
use crate::regression::factor::kernels::rotate_pivot_small;
use crate::regression::factor::pairs;
use law::Size;

/// Most segments: sums in single precision stay accurate.
pub const MAX_SEGMENTS: u32 = 10_000;
/// Least degrees of freedom ν of the law of the distance.
const LEAST_FREEDOM: f32 = 3.0;
/// Largest variance of an error, relative to the variance of the coordinate in S₀.
const MOST_ERROR: f32 = 10.0;
/// One segment in so many may be too far.
const FAR_SHARE: u32 = 10;

/// Constants of a commissioning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CommissioningConstants {
    /// κ₀ of (1), segments; 0 if the trained mean does not count.
    pub mean_weight: f32,
    /// ν₀ of (1), segments, at least 1.
    pub covariance_weight: f32,
    /// Number of segments that are needed.
    pub fewest: u32,
    /// Largest distance of a segment from the trained healthy mean, trained standard deviations.
    pub farthest: f32,
    /// Largest mean variance of the segments, relative to that of the trained ones.
    pub widest: f32,
    /// Degrees of freedom of the trained covariance, about the number of segments or runs of the test bench; infinite
    /// if it is not known, and then part of them counts as heavy tails of the features. Models with rising coordinates
    /// bring their own.
    pub trained_freedom: f32,
    /// Constants of the alarm for a baseline of `fewest` segments, as the workbench computes them; `None` keeps those
    /// of the model, whose mean time between false alarms is that of its own baseline.
    pub evidence: Option<EvidenceConstants>,
}

impl CommissioningConstants {
    /// So many segments, with a prior that counts as `weight` segments; segments within 10 trained standard deviations
    /// whose mean variance is at most 4 times the trained one.
    #[must_use]
    pub const fn new(fewest: u32, weight: f32) -> Self {
        Self {
            mean_weight: weight,
            covariance_weight: weight,
            fewest,
            farthest: 10.0,
            widest: 4.0,
            trained_freedom: f32::INFINITY,
            evidence: None,
        }
    }

    fn are_good(&self, coordinates: u8) -> bool {
        let Self { mean_weight, covariance_weight, fewest, farthest, widest, trained_freedom, .. } = *self;
        let weighed = mean_weight >= 0.0 && covariance_weight >= 1.0 && mean_weight.max(covariance_weight) <= 1e5;
        let limited = farthest > 0.0 && widest > 0.0 && trained_freedom >= 1.0;
        let counted = (2..=MAX_SEGMENTS).contains(&fewest);
        let freedom = covariance_weight + fewest as f32 - f32::from(coordinates);
        weighed && limited && counted && freedom >= LEAST_FREEDOM
    }
}

/// The healthy class of a drive, from the segments gathered so far.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HealthyClass<P: Plan> {
    constants: CommissioningConstants,
    /// m, κ and f of (2) and (3), and `κ_k` of (6).
    mean: Array<P::Coordinates, f32>,
    weights: Array<P::Coordinates, f32>,
    weight: f32,
    freedom: f32,
    /// Ψ as D and R.
    scatter: Array<P::Density, f32>,
    /// Mean of the segments alone, and the sum of their squared trained distances from it.
    own_mean: Array<P::Coordinates, f32>,
    own_scatter: f32,
    gathered: u32,
    far: u32,
}

impl<P: Plan> HealthyClass<P> {
    /// Without any segment: the prior.
    pub(crate) fn new(
        plan: P,
        classifier: &Classifier<P>,
        constants: CommissioningConstants,
    ) -> Result<Self, CommissioningError> {
        let (layout, novelty) = (plan.layout(), &classifier.novelty);
        if novelty.class.is_none() {
            return Err(CommissioningError::NoHealthyClass);
        }
        if !constants.are_good(layout.coordinates) {
            return Err(CommissioningError::Constants);
        }
        let mut scatter = novelty.factor.clone();
        each_pivot(scatter.cells_mut(), layout.coordinates, |pivot| *pivot *= constants.covariance_weight);
        Ok(Self {
            constants,
            mean: novelty.mean.clone(),
            weights: Cells::filled(layout.coordinates as usize, constants.mean_weight),
            weight: constants.mean_weight,
            freedom: constants.covariance_weight,
            scatter,
            own_mean: Cells::filled(layout.coordinates as usize, 0.0),
            own_scatter: 0.0,
            gathered: 0,
            far: 0,
        })
    }

    /// Number of segments gathered.
    pub(crate) const fn gathered(&self) -> u32 {
        self.gathered
    }

    /// Number of segments that were too far from the trained mean.
    pub(crate) const fn far(&self) -> u32 {
        self.far
    }

    /// m, the merged mean so far.
    pub(crate) fn mean(&self) -> &[f32] {
        self.mean.cells()
    }

    /// Takes a healthy segment.
    pub(crate) fn take(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        estimates: Estimates<'_, P>,
    ) -> Result<(), CommissioningError> {
        let mut classification = Classification::new(plan);
        let mut decision = Decision::empty(plan);
        classification.run(plan, classifier, estimates, &mut decision).map_err(CommissioningError::NoVerdict)?;
        let (z, variances) = classification.coordinates();
        self.add(&classifier.novelty, z, variances)
    }

    fn add(&mut self, trained: &Novelty<P>, z: &[f32], variances: &[f32]) -> Result<(), CommissioningError> {
        if self.gathered >= MAX_SEGMENTS {
            return Err(CommissioningError::Full);
        }
        let mut shares: Array<P::Coordinates, f32> = Cells::filled(z.len(), 1.0);
        share(trained.factor.cells(), variances, shares.cells_mut())?;
        let density = Density::<P>::of(trained.factor.cells(), variances, z.len());
        let distance = libm::sqrtf(density.squared_distance(trained.mean.cells(), z));
        // Written so that NaN is too far.
        let near = distance <= self.constants.farthest;
        if !near {
            self.far = self.far.saturating_add(1);
            return Err(CommissioningError::TooFar { distance });
        }
        // Welford's recursion for the segments alone.
        let (before, count) = (self.gathered as f32, self.gathered as f32 + 1.0);
        self.own_scatter += before / count * density.squared_distance(self.own_mean.cells(), z);
        pairs(self.own_mean.cells_mut(), z).for_each(|(mean, z)| *mean += (z - *mean) / count);
        self.gathered = self.gathered.saturating_add(1);
        self.merge(z, shares.cells());
        Ok(())
    }

    /// (2) with the weights (6).
    fn merge(&mut self, z: &[f32], shares: &[f32]) {
        let after = self.weight + 1.0;
        let mut away = self.mean.clone();
        let means = pairs(self.mean.cells_mut(), self.weights.cells_mut());
        for ((x, (mean, weight)), (z, share)) in pairs(pairs(away.cells_mut(), means), pairs(z, shares)) {
            *x = z - *x;
            *weight += share;
            *mean += share / *weight * *x;
            *x *= libm::sqrtf(*share);
        }
        let mut weight = self.weight / after;
        let (mut x, mut rest) = (away.cells_mut(), self.scatter.cells_mut());
        while let [first, later @ ..] = x {
            let Some((row, below)) = rest.split_at_mut_checked(later.len().saturating_add(1)) else { break };
            if let [pivot, row @ ..] = row {
                rotate_pivot_small(pivot, row, *first, later, &mut weight);
            }
            (x, rest) = (later, below);
        }
        self.freedom += if self.weight > 0.0 { 1.0 } else { 0.0 };
        self.weight = after;
    }

    /// (4) and (5).
    pub(crate) fn finish(&self, plan: P, trained: &Classifier<P>) -> Result<Classifier<P>, CommissioningError> {
        let Self { gathered, far, constants: CommissioningConstants { fewest, widest, trained_freedom, .. }, .. } =
            *self;
        if gathered < fewest {
            return Err(CommissioningError::TooFew { gathered, needed: fewest });
        }
        if far.saturating_mul(FAR_SHARE) > gathered {
            return Err(CommissioningError::TooManyFar { far, gathered });
        }
        let layout = plan.layout();
        let (all, rising) = (layout.coordinates as usize, layout.rising as usize);
        let ratio = self.own_scatter / (all as f32 * (gathered as f32 - 1.0));
        let narrow = ratio <= widest;
        if !narrow {
            return Err(CommissioningError::TooWide { ratio });
        }
        let mut made = trained.clone();
        let novelty = &mut made.novelty;
        novelty.mean = self.mean.clone();
        novelty.factor = self.scatter.clone();
        each_pivot(novelty.factor.cells_mut(), layout.coordinates, |pivot| *pivot /= self.freedom);
        let factor = 1.0 + 1.0 / self.weight;
        let trained_freedom = if rising > 0 { trained.novelty.freedom } else { trained_freedom };
        let size = Size { freedom: self.freedom, factor, trained_freedom };
        novelty.knots = size.law(&trained.novelty.knots, [0, all], novelty.limit);
        if rising > 0 {
            novelty.freedom = self.freedom * factor;
            let others = all.saturating_sub(rising);
            let limit = rising::limit_of_one(novelty.limit, rising, others > 0);
            for (k, law) in (0_usize..).zip(novelty.laws.cells_mut()) {
                let place = k.checked_sub(1).map_or([0, others], |k| [others.saturating_add(k), 1]);
                let [_, count] = place;
                if count > 0 {
                    *law = size.law(law, place, limit);
                }
            }
        }
        self.move_classes(trained, &mut made);
        Ok(made)
    }

    /// (5).
    fn move_classes(&self, trained: &Classifier<P>, made: &mut Classifier<P>) {
        let moves = pairs(self.mean.cells(), trained.novelty.mean.cells());
        let (coordinates, mut k) = (self.mean.cells().len(), 0_usize);
        for (learned, trained) in moves {
            let places = made.discriminant.means.cells_mut().get_mut(k..).unwrap_or_default();
            places.iter_mut().step_by(coordinates.max(1)).for_each(|mean| *mean += learned - trained);
            k = k.wrapping_add(1);
        }
    }

    /// Constants of the alarm for this baseline, if there are any.
    pub(crate) const fn evidence(&self) -> Option<EvidenceConstants> {
        self.constants.evidence
    }
}

/// Works on each pivot D of a factor.
fn each_pivot(factor: &mut [f32], coordinates: u8, mut work: impl FnMut(&mut f32)) {
    let (mut rest, mut left) = (factor, coordinates as usize);
    while let [pivot, later @ ..] = rest {
        work(pivot);
        left = left.saturating_sub(1);
        rest = later.get_mut(left..).unwrap_or_default();
    }
}

/// The weights w of (6), where `s_k = Σ_i D_i r_ik²`; coordinates without a variance keep theirs.
fn share(factor: &[f32], variances: &[f32], shares: &mut [f32]) -> Result<(), CommissioningError> {
    let (coordinates, mut k) = (shares.len(), 0_u8);
    for (variance, share) in pairs(variances, shares) {
        if !variance.is_finite() {
            return Err(CommissioningError::Missing { coordinate: k });
        }
        let (mut rest, mut healthy) = (factor, 0.0);
        for row in 0..=k {
            let length = coordinates.saturating_sub(row as usize);
            let Some((cells, below)) = rest.split_at_checked(length) else { break };
            let pivot = cells.first().copied().unwrap_or(0.0);
            let r = if row == k { 1.0 } else { cells.get(k.wrapping_sub(row) as usize).copied().unwrap_or(0.0) };
            healthy += pivot * r * r;
            rest = below;
        }
        if *variance > MOST_ERROR * healthy {
            return Err(CommissioningError::Uncertain { coordinate: k });
        }
        *share = healthy / (healthy + variance.max(0.0));
        k = k.wrapping_add(1);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
