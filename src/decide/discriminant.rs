//! Projected coordinates → log-likelihoods, posteriors, expected costs, class.
//!
//! Enters: z. Leaves: a [`Decision`].
//!
//! ```text
//! ln p(z|k) = g_k − ½ ‖U_k (z − μ_k)‖²,   U_kᵀ U_k = Σ_k⁻¹               (1)  thesis Eq. 2.67
//! P(k|z) = P(k) p(z|k) / Σ_j P(j) p(z|j)                                 (2)  thesis Eq. 2.64
//! class = argmin_i Σ_k C(i|k) P(k|z)                                     (3)  thesis Eq. 2.65
//! reject where its Σ exceeds the cost of no decision                     (4)  Chow 1970
//! ```
//!
//! U is lower triangular (the inverse of Σ's Cholesky factor). Linear discriminants share one U, quadratic ones
//! have their own. The original method pools the covariance, hence is linear, though it is labelled quadratic.
//! Cost of (1): C·Z(Z+3)/2 multiply-adds; (2) adds one exponential a class.

/// Whether classes share their covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kind {
    /// One covariance for all: `whitening[0]`.
    Linear,
    /// A covariance each.
    Quadratic,
}

/// Gaussian class densities with priors and costs. Classes and coordinates beyond those in use are neutral: zero
/// rows, a normaliser and log prior of −∞.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Discriminant<const Z: usize, const C: usize> {
    /// Linear or quadratic.
    pub kind: Kind,
    /// Classes in use.
    pub classes: u8,
    /// μ, a row a class.
    pub mean: [[f32; Z]; C],
    /// U, lower triangular, by rows; a linear discriminant uses the first only.
    pub whitening: [[[f32; Z]; Z]; C],
    /// g = −½ (d ln 2π + ln |Σ|), a class each.
    pub log_normaliser: [f32; C],
    /// ln P(k).
    pub log_prior: [f32; C],
    /// `cost[i][k]` = C(i|k): what deciding i costs when k is true.
    pub cost: [[f32; C]; C],
    /// What no decision costs (4); infinite where one is always wanted.
    pub reject_cost: f32,
}

/// The outcome of one classification. Places beyond the classes in use hold what never wins: log-likelihood −∞,
/// posterior 0, expected cost +∞.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Decision<const C: usize> {
    /// Index of the class of least expected cost (3).
    pub class: u8,
    /// (1).
    pub log_likelihoods: [f32; C],
    /// (2).
    pub posteriors: [f32; C],
    /// The sums of (3).
    pub expected_costs: [f32; C],
    /// Distance from the healthy class, in its standard deviations; 0 without a healthy class.
    pub distance: f32,
    /// −ln of the probability that a healthy segment lies at least so far, nats; 0 without a healthy class.
    pub surprise: f32,
}

impl<const C: usize> Decision<C> {
    /// What the decided class is expected to cost.
    #[must_use]
    pub fn least_cost(&self) -> f32 {
        self.expected_costs.iter().copied().fold(f32::INFINITY, f32::min)
    }
}

impl<const Z: usize, const C: usize> Discriminant<Z, C> {
    /// Log-likelihoods (1).
    #[inline]
    #[must_use]
    pub fn log_likelihoods(&self, z: &[f32; Z]) -> [f32; C] {
        let shared = match self.kind {
            Kind::Linear => self.whitening.first(),
            Kind::Quadratic => None,
        };
        let mut out = [0.0; C];
        let classes = self.mean.iter().zip(&self.whitening).zip(&self.log_normaliser);
        for (out, ((mean, own), g)) in out.iter_mut().zip(classes) {
            let mut centred = *z;
            for (x, mean) in centred.iter_mut().zip(mean) {
                *x -= mean;
            }
            let whitened = whiten(shared.unwrap_or(own), &centred);
            *out = g - 0.5 * whitened.iter().fold(0.0, |sum, x| sum + x * x); // (1)
        }
        out
    }

    /// Log-likelihoods, posteriors and the class of least expected cost; nothing where no likelihood is finite. Of the
    /// distance from healthy it knows nothing: [`Classifier::decide`](super::Classifier::decide) does.
    #[must_use]
    pub fn decide(&self, z: &[f32; Z]) -> Option<Decision<C>> {
        self.decide_from(self.log_likelihoods(z))
    }

    /// (2) and (3) from given log-likelihoods, for instance sums over several independent segments.
    #[must_use]
    pub fn decide_from(&self, log_likelihoods: [f32; C]) -> Option<Decision<C>> {
        let mut joint = log_likelihoods;
        for (joint, prior) in joint.iter_mut().zip(&self.log_prior) {
            *joint += prior;
        }
        if joint.iter().any(|x| x.is_nan()) {
            return None;
        }
        let largest = joint.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        if !largest.is_finite() {
            return None;
        }
        let mut posteriors = joint.map(|x| libm::expf(x - largest));
        let total = posteriors.iter().fold(0.0, |sum, p| sum + p);
        for posterior in &mut posteriors {
            *posterior /= total; // (2)
        }
        let mut expected_costs = [f32::INFINITY; C];
        let in_use = self.classes as usize;
        for (expected, costs) in expected_costs.iter_mut().zip(&self.cost).take(in_use) {
            *expected = costs.iter().zip(&posteriors).fold(0.0, |sum, (cost, posterior)| sum + cost * posterior);
        }
        let mut class = 0;
        let mut least = f32::INFINITY;
        for (k, &expected) in (0..self.classes).zip(&expected_costs) {
            if expected < least {
                (class, least) = (k, expected); // (3)
            }
        }
        let (distance, surprise) = (0.0, 0.0);
        let decision = Decision { class, log_likelihoods, posteriors, expected_costs, distance, surprise };
        (least < f32::INFINITY).then_some(decision)
    }
}

/// `U x` for lower-triangular U.
#[inline]
pub(super) fn whiten<const Z: usize>(u: &[[f32; Z]; Z], x: &[f32; Z]) -> [f32; Z] {
    let mut out = [0.0; Z];
    for (i, (out, row)) in out.iter_mut().zip(u).enumerate() {
        *out = row.iter().zip(x).take(i + 1).fold(0.0, |sum, (u, x)| sum + u * x);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two classes in the plane: at (0, 0) with Σ = I and at (2, 0) with Σ = I (linear) or diag(4, 1) (quadratic).
    fn two(kind: Kind) -> Discriminant<2, 2> {
        let ln_2pi = 1.837_877_1_f32;
        let spread = if kind == Kind::Linear { 1.0 } else { 0.5 };
        Discriminant {
            kind,
            classes: 2,
            mean: [[0.0, 0.0], [2.0, 0.0]],
            whitening: [[[1.0, 0.0], [0.0, 1.0]], [[spread, 0.0], [0.0, 1.0]]],
            log_normaliser: [-ln_2pi, -ln_2pi + libm::logf(spread)],
            log_prior: [libm::logf(0.5); 2],
            cost: [[0.0, 1.0], [1.0, 0.0]],
            reject_cost: f32::INFINITY,
        }
    }

    #[test]
    fn linear_boundary_is_the_bisector() {
        let d = two(Kind::Linear);
        assert_eq!(d.decide(&[0.9, 5.0]).unwrap().class, 0);
        assert_eq!(d.decide(&[1.1, -5.0]).unwrap().class, 1);
        let odds = d.decide(&[1.0, 3.0]).unwrap().posteriors;
        assert!((odds[0] - 0.5).abs() < 1e-6, "{odds:?}"); // two roundings of numbers near one
    }

    #[test]
    fn quadratic_density_by_hand() {
        // ln p((0, 0) | 1) = −ln 2π − ½ ln 4 − ½ (2²/4) = −1.837877 − 0.693147 − 0.5
        let got = two(Kind::Quadratic).log_likelihoods(&[0.0, 0.0]);
        assert!((got[0] + 1.837_877).abs() < 1e-5 && (got[1] + 3.031_024).abs() < 1e-5, "{got:?}");
    }

    #[test]
    fn costs_and_priors_move_the_decision() {
        let mut d = two(Kind::Linear);
        // A missed class 1 costs 50 false alarms: P(1) > 1/51 suffices.
        d.cost = [[0.0, 50.0], [1.0, 0.0]];
        assert_eq!(d.decide(&[-0.5, 0.0]).unwrap().class, 1);
        d.cost = [[0.0, 1.0], [1.0, 0.0]];
        d.log_prior = [libm::logf(0.99), libm::logf(0.01)];
        assert_eq!(d.decide(&[2.0, 0.0]).unwrap().class, 0);
    }

    #[test]
    fn far_away_is_decided_and_nonsense_is_not() {
        let d = two(Kind::Linear);
        assert_eq!(d.decide(&[1e6, 0.0]).unwrap().class, 1);
        assert_eq!(d.decide(&[f32::NAN, 0.0]), None);
        assert_eq!(d.decide(&[1e30, 0.0]), None, "both likelihoods are zero: no opinion");
    }

    #[test]
    fn a_wider_capacity_gives_the_same_bits() {
        let narrow = two(Kind::Quadratic);
        let wide = Discriminant::<3, 4> {
            kind: Kind::Quadratic,
            classes: 2,
            mean: [[0.0; 3], [2.0, 0.0, 0.0], [0.0; 3], [0.0; 3]],
            whitening: [
                [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]],
                [[0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]],
                [[0.0; 3]; 3],
                [[0.0; 3]; 3],
            ],
            log_normaliser: [narrow.log_normaliser[0], narrow.log_normaliser[1], f32::NEG_INFINITY, f32::NEG_INFINITY],
            log_prior: [narrow.log_prior[0], narrow.log_prior[1], f32::NEG_INFINITY, f32::NEG_INFINITY],
            cost: [[0.0, 1.0, 1.0, 1.0], [1.0, 0.0, 1.0, 1.0], [1.0; 4], [1.0; 4]],
            reject_cost: f32::INFINITY,
        };
        let (a, b) = (narrow.decide(&[0.7, -0.3]).unwrap(), wide.decide(&[0.7, -0.3, 0.0]).unwrap());
        assert_eq!(a.class, b.class);
        assert_eq!(a.posteriors, b.posteriors[..2]);
        assert_eq!(a.log_likelihoods, b.log_likelihoods[..2]);
        assert_eq!(a.expected_costs, b.expected_costs[..2]);
        assert!(b.expected_costs[2..].iter().all(|cost| *cost == f32::INFINITY));
    }
}
