//! Projected coordinates → log-likelihoods, posteriors, expected costs, class.
//!
//! Enters: z, and the variance v of the error of each coordinate, infinite where it is missing. Leaves: a [`Decision`].
//!
//! ```text
//! ln p(z|k) = −½ (n ln 2π + ln |S_k| + (z − μ_k)ᵀ S_k⁻¹ (z − μ_k)),  S_k = Σ_k + diag(v)   (1)  thesis Eq. 2.67
//! P(k|z) = P(k) p(z|k) / Σ_j P(j) p(z|j)                                 (2)  thesis Eq. 2.64
//! class = argmin_i Σ_k C(i|k) P(k|z)                                     (3)  thesis Eq. 2.65
//! reject if its Σ exceeds the cost of no decision                        (4)  Chow 1970
//! ```
//!
//! (1) is computed from factors ([`super::density`]) over the n available coordinates, the same for all classes. A
//! linear discriminant has one Σ for all classes, a quadratic one has a Σ for each. The thesis pools the covariance;
//! its discriminant is linear, although the thesis calls it quadratic. Cost of (1): C·Z(Z+3)/2 multiply-adds and the
//! factors; (2) adds one exponential a class.

use super::features::FeatureValue;
use super::gates::density::Density;
use super::gates::{Departure, Fall, Most};
use crate::plan::{Array, Cells, Kind, Plan};
use crate::regression::factor::{numbered, pairs};

/// The id of a decision that was made without a model.
pub const NO_MODEL: u32 = 0;

/// Gaussian class densities with priors and costs.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Discriminant<P: Plan> {
    /// μ, one row of Z a class.
    pub means: Array<P::Means, f32>,
    /// D and R of Σ = Rᵀ D R, R unit upper triangle: of each row D and then R, `[D₁, R₁₂, R₁₃, D₂, R₂₃, D₃]` for Z = 3;
    /// one factor, or one a class. D has the variances if the coordinates are independent.
    pub factors: Array<P::Densities, f32>,
    /// ln P(k).
    pub log_prior: Array<P::Classes, f32>,
    /// C(i|k), the cost of deciding i if k is true, by rows i.
    pub costs: Array<P::Costs, f32>,
    /// Cost of no decision (4); infinite if a decision is always required.
    pub reject_cost: f32,
}

/// The result of one classification.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Decision<P: Plan> {
    /// Index of the class of least expected cost (3).
    pub class: u8,
    pub(crate) log_likelihoods: Array<P::Classes, f32>,
    pub(crate) posteriors: Array<P::Classes, f32>,
    pub(crate) expected_costs: Array<P::Classes, f32>,
    /// Whether the segment is beyond the gate of each class but the healthy one.
    pub(crate) beyond: Array<P::Classes, bool>,
    /// y of each direction that the alarm watches.
    pub(crate) directed: Array<P::Directions, FeatureValue>,
    /// The id of the model.
    pub(crate) model: u32,
    pub(crate) missing: Array<P::Features, bool>,
    pub(crate) outside: Array<P::Covariates, bool>,
    /// Distance from the healthy class in its standard deviations; 0 without a healthy class. If coordinates are
    /// missing, the distance with the same probability of all coordinates.
    pub distance: f32,
    /// −ln of the probability that a healthy segment has at least this distance, nats; 0 without a healthy class. The
    /// evidence collects it.
    pub distance_surprise: f32,
    /// The same of the distance and of features that only rise with a defect together, nats; 0 without a healthy
    /// class. The novelty gate compares it.
    pub surprise: f32,
    /// The coordinate that departs most from the healthy class, in a report that of the strongest bearing order if one
    /// has the score that a defect needs; `None` without such a class.
    pub most: Option<Most>,
    /// The rarest fall of a coordinate that a defect raises: the load or a sensor, and no bearing.
    pub fall: Fall,
}

impl<P: Plan> Decision<P> {
    pub(crate) fn empty(plan: P) -> Self {
        let layout = plan.layout();
        let zeros: Array<P::Classes, f32> = Cells::filled(layout.classes as usize, 0.0);
        Self {
            class: 0,
            log_likelihoods: zeros.clone(),
            posteriors: zeros.clone(),
            expected_costs: zeros,
            beyond: Cells::filled(layout.classes as usize, false),
            directed: Cells::filled(layout.directions as usize, FeatureValue::MISSING),
            model: NO_MODEL,
            missing: Cells::filled(layout.features as usize, false),
            outside: Cells::filled(layout.covariates as usize, false),
            distance: 0.0,
            distance_surprise: 0.0,
            surprise: 0.0,
            most: None,
            fall: Fall::default(),
        }
    }

    /// Takes distance and surprises.
    pub(crate) fn depart(&mut self, departure: Departure) {
        (self.distance, self.surprise) = (departure.distance, departure.surprise);
        (self.distance_surprise, self.most, self.fall) = (departure.distance_surprise, departure.most, departure.fall);
    }

    /// The value of each direction that the alarm watches, less the mean of drives.
    #[must_use]
    pub fn directed(&self) -> &[FeatureValue] {
        self.directed.cells()
    }

    /// Sets the values of directions, of a decision that is made again from its numbers.
    pub fn set_directed(&mut self, values: &[FeatureValue]) {
        pairs(self.directed.cells_mut(), values).for_each(|(cell, value)| *cell = *value);
    }

    /// Log-likelihood (1) of each class.
    #[must_use]
    pub fn log_likelihoods(&self) -> &[f32] {
        self.log_likelihoods.cells()
    }

    /// Posterior (2) of each class.
    #[must_use]
    pub fn posteriors(&self) -> &[f32] {
        self.posteriors.cells()
    }

    /// Expected cost of deciding each class: the sums of (3).
    #[must_use]
    pub fn expected_costs(&self) -> &[f32] {
        self.expected_costs.cells()
    }

    /// Whether the segment is too far from each class to be one of its own, as [`Novelty::excludes`] says; `false` for
    /// the healthy class, whose gate compares [`Decision::surprise`].
    ///
    /// [`Novelty::excludes`]: crate::model::Novelty::excludes
    #[must_use]
    pub fn beyond(&self) -> &[bool] {
        self.beyond.cells()
    }

    /// Sets [`Decision::beyond`], for decisions that a program makes of several segments.
    pub fn set_beyond(&mut self, beyond: &[bool]) {
        pairs(self.beyond.cells_mut(), beyond).for_each(|(cell, is_beyond)| *cell = *is_beyond);
    }

    /// Whether each feature was missing, in the order of the classifier's features.
    #[must_use]
    pub fn missing(&self) -> &[bool] {
        self.missing.cells()
    }

    /// Whether each covariate was missing or outside the range of the training records, in the order of
    /// [`Covariates::list`](super::Covariates::list). The features that it explains were then missing.
    #[must_use]
    pub fn outside(&self) -> &[bool] {
        self.outside.cells()
    }

    /// Number of missing features.
    #[must_use]
    pub fn missing_count(&self) -> usize {
        self.missing().iter().filter(|missing| **missing).count()
    }

    /// Expected cost of the decided class.
    #[must_use]
    pub fn least_cost(&self) -> f32 {
        self.expected_costs().get(self.class as usize).copied().unwrap_or(f32::INFINITY)
    }
}

impl<P: Plan> Discriminant<P> {
    /// Log-likelihood (1) of a class at the coordinates z, whose errors have these variances: infinite for a missing
    /// coordinate, 0 for coordinates without a variance.
    #[must_use]
    pub fn log_likelihood(&self, kind: Kind, z: &[f32], variances: &[f32], class: usize) -> f32 {
        let density = self.density(kind, z.len(), variances, class);
        density.log_density(self.squared_distance(&density, z, class))
    }

    /// The density of a class for coordinates of these errors.
    pub(crate) fn density(&self, kind: Kind, coordinates: usize, variances: &[f32], class: usize) -> Density<P> {
        Density::of(self.factor(kind, coordinates, class), variances, coordinates)
    }

    /// The factor of a class.
    pub(crate) fn factor(&self, kind: Kind, coordinates: usize, class: usize) -> &[f32] {
        let index = match kind {
            Kind::Linear => 0,
            Kind::Quadratic => class.wrapping_mul(crate::regression::factor::lower(coordinates, 0)),
        };
        self.factors.cells().get(index..).unwrap_or(&[])
    }

    /// (z − μ)ᵀ S⁻¹ (z − μ) by the factor of the class.
    pub(crate) fn squared_distance(&self, density: &Density<P>, z: &[f32], class: usize) -> f32 {
        let mean = self.means.cells().get(class.wrapping_mul(z.len())..).unwrap_or(&[]);
        density.squared_distance(mean, z)
    }

    /// Posteriors (2), expected costs and class (3) from log-likelihoods, which may be sums over several independent
    /// segments; returns `false` if no likelihood is finite or one is not a number.
    pub fn decide(&self, log_likelihoods: &[f32], decision: &mut Decision<P>) -> bool {
        let Some(largest) = self.join(log_likelihoods, decision) else { return false };
        let mut total = 0.0;
        for density in decision.posteriors.cells_mut() {
            *density = libm::expf(*density - largest);
            total += *density;
        }
        decision.posteriors.cells_mut().iter_mut().for_each(|density| *density /= total); // (2)
        self.choose(decision)
    }

    /// The logarithms of the joint densities in the place of the posteriors; the largest, if it is finite.
    fn join(&self, log_likelihoods: &[f32], decision: &mut Decision<P>) -> Option<f32> {
        let mut largest = f32::NEG_INFINITY;
        let cells = decision.posteriors.cells_mut().iter_mut().zip(decision.log_likelihoods.cells_mut());
        for (class, (joint, cell)) in numbered(cells) {
            let likelihood = log_likelihoods.get(class).copied().unwrap_or(f32::NAN);
            *joint = likelihood + self.log_prior.cells().get(class).copied().unwrap_or(f32::NAN);
            // A NaN stays, since nothing is greater.
            if *joint > largest || joint.is_nan() {
                largest = *joint;
            }
            *cell = likelihood;
        }
        largest.is_finite().then_some(largest)
    }

    /// The expected costs, and the class of the least; `false` if none is finite.
    fn choose(&self, decision: &mut Decision<P>) -> bool {
        let (posteriors, mut least) = (decision.posteriors.cells(), f32::INFINITY);
        for (class, cell) in (0..u8::MAX).zip(decision.expected_costs.cells_mut()) {
            let costs = self.costs.cells().get((class as usize).wrapping_mul(posteriors.len())..).unwrap_or(&[]);
            *cell = pairs(costs, posteriors).fold(0.0, |sum, (cost, posterior)| sum + cost * posterior);
            if *cell < least {
                (decision.class, least) = (class, *cell); // (3)
            }
        }
        least < f32::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Layout, Memory, Method, RunTime, Structure, testing};
    use std::vec;

    /// Two classes in the plane: at (0, 0) with Σ = I and at (2, 0) with Σ = I (linear) or diag(4, 1) (quadratic).
    fn two(kind: Kind) -> (RunTime, Discriminant<RunTime>) {
        let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
        let layout = Layout { features: 2, coordinates: 2, classes: 2, discriminant: kind, ..plain };
        let mut factors = vec![1.0, 0.0, 1.0];
        if kind == Kind::Quadratic {
            factors.extend([4.0, 0.0, 1.0]);
        }
        let discriminant = Discriminant {
            means: vec![0.0, 0.0, 2.0, 0.0],
            factors,
            log_prior: vec![libm::logf(0.5); 2],
            costs: vec![0.0, 1.0, 1.0, 0.0],
            reject_cost: f32::INFINITY,
        };
        (RunTime::of(layout).unwrap(), discriminant)
    }

    fn decide(of: &(RunTime, Discriminant<RunTime>), z: [f32; 2]) -> Option<Decision<RunTime>> {
        decide_with(of, z, [0.0; 2])
    }

    fn decide_with(
        (plan, discriminant): &(RunTime, Discriminant<RunTime>),
        z: [f32; 2],
        variances: [f32; 2],
    ) -> Option<Decision<RunTime>> {
        let kind = plan.layout().discriminant;
        let mut decision = Decision::empty(*plan);
        let likelihoods = [0, 1].map(|class| discriminant.log_likelihood(kind, &z, &variances, class));
        discriminant.decide(&likelihoods, &mut decision).then_some(decision)
    }

    #[test]
    fn linear_boundary_is_the_bisector() {
        let d = two(Kind::Linear);
        assert_eq!(decide(&d, [0.9, 5.0]).unwrap().class, 0);
        assert_eq!(decide(&d, [1.1, -5.0]).unwrap().class, 1);
        let odds = decide(&d, [1.0, 3.0]).unwrap().posteriors;
        assert!((odds[0] - 0.5).abs() < 1e-6, "{odds:?}"); // two roundings of numbers near one
    }

    #[test]
    fn quadratic_density_by_hand() {
        // ln p((0, 0) | 1) = −ln 2π − ½ ln 4 − ½ (2²/4) = −1.837877 − 0.693147 − 0.5
        let d = two(Kind::Quadratic);
        let got = decide(&d, [0.0, 0.0]).unwrap().log_likelihoods;
        assert!((got[0] + 1.837_877).abs() < 1e-5 && (got[1] + 3.031_024).abs() < 1e-5, "{got:?}");
    }

    #[test]
    fn errors_soften_the_posteriors_and_missing_coordinates_leave_the_priors() {
        // Odds of class 0 at the origin: exp(½ 2²/(1 + v)).
        let d = two(Kind::Linear);
        for variance in [0.0_f32, 1.0, 15.0, f32::INFINITY] {
            let odds = (2.0 / (1.0 + variance)).exp();
            let posteriors = decide_with(&d, [0.0, 7.0], [variance, 0.0]).unwrap().posteriors;
            assert!((posteriors[0] - odds / (1.0 + odds)).abs() < 1e-6, "{variance}: {posteriors:?}");
        }
        // ln p(0 | 1) of the second coordinate alone: −½ ln 2π.
        let d = two(Kind::Quadratic);
        let logs = decide_with(&d, [0.0, 0.0], [f32::INFINITY, 0.0]).unwrap().log_likelihoods;
        assert!(logs.iter().all(|log| (log + 0.918_938_5).abs() < 1e-6), "{logs:?}");
    }

    #[test]
    fn costs_and_priors_move_the_decision() {
        let mut d = two(Kind::Linear);
        // A missed class 1 costs 50 false alarms: P(1) > 1/51 suffices.
        d.1.costs = vec![0.0, 50.0, 1.0, 0.0];
        let decision = decide(&d, [-0.5, 0.0]).unwrap();
        assert_eq!(decision.class, 1);
        // A false alarm costs 1, with the probability of class 0: odds exp(2 − 2 z).
        assert!((decision.least_cost() - 1.0 / (1.0 + (-3.0_f32).exp())).abs() < 1e-6, "{}", decision.least_cost());
        d.1.costs = vec![0.0, 1.0, 1.0, 0.0];
        d.1.log_prior = vec![libm::logf(0.99), libm::logf(0.01)];
        assert_eq!(decide(&d, [2.0, 0.0]).unwrap().class, 0);
    }

    #[test]
    fn a_far_point_is_decided_and_nan_is_not() {
        let d = two(Kind::Linear);
        assert_eq!(decide(&d, [1e6, 0.0]).unwrap().class, 1);
        assert_eq!(decide(&d, [f32::NAN, 0.0]), None);
        assert_eq!(decide(&d, [1e30, 0.0]), None, "both likelihoods are zero");
    }
}
