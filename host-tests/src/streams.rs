//! The core's estimators as the tests set them up: one capacity that holds every plant.

use bearing_watch::estimate::{
    Estimate, Estimator, Fading, Guard, Instruments, Memory, Method, Nominal, Regression, Regressor,
};
use bearing_watch::{Order, Reason, Sample};
use nalgebra::DVector;

use crate::oracle::{self, Course, Fit};
use crate::plants::Plant;

/// Columns: nine parameters without, or seven with instruments of three output terms, and the target.
pub const M: usize = 12;
/// M(M−1)/2.
pub const P: usize = M * (M - 1) / 2;
/// Longest delay.
pub const L: usize = 3;

/// Least squares over segments.
pub type LeastSquares<'m> = Estimator<'m, M, P, L>;
/// Streaming refined instrumental variables.
pub type Refined<'m> = Estimator<'m, M, P, L, Instruments<M, L>>;
/// Least squares that forgets.
pub type Continuous<'m> = Estimator<'m, M, P, L, Regressor<M, L>, Fading<M, P>>;
/// Refined instrumental variables that forget.
pub type ContinuousRefined<'m> = Estimator<'m, M, P, L, Instruments<M, L>, Fading<M, P>>;

/// Least squares over segments, without a constant term, scaled to these samples.
#[must_use]
pub fn regression(order: Order, samples: &[Sample]) -> Regression<M> {
    Regression { scale: scales(order, samples), guard: Guard::within([1e6; 3]), ..Regression::new(order, false) }
}

/// Refined instrumental variables for a plant, from its nominal model.
#[must_use]
pub fn refined(plant: &Plant, samples: &[Sample]) -> Regression<M> {
    let order = plant.order();
    let mut delta = [0.0; M];
    delta.iter_mut().zip(&oracle::delta(order, &plant.nominal())).for_each(|(cell, x)| *cell = *x as f32);
    let nominal = Nominal { delta, deviation: 0.0 };
    // Transients of an exchanged auxiliary model die out with the slowest pole, 50 ms: exp(−3) of them is left.
    let settle = (0.15 * plant.rate_hz) as u16;
    Regression { method: Method::Instruments, nominal, settle, ..regression(order, samples) }
}

/// With fading memory of 1e4 rows.
#[must_use]
pub fn fading(regression: Regression<M>, floor: f32) -> Regression<M> {
    let forgetting = bearing_watch::estimate::Forgetting { lambda: 0.9999, floor };
    Regression { memory: Memory::Fading(forgetting), ..regression }
}

/// Powers of two that bring levels, differences and the target y − y₁ to an rms near one.
fn scales(order: Order, samples: &[Sample]) -> [f32; M] {
    let scale = |of: &dyn Fn(usize) -> f32| {
        let square: f64 = (1..samples.len()).map(|t| f64::from(of(t)).powi(2)).sum();
        let rms = (square / (samples.len() - 1) as f64).sqrt();
        (-rms.log2().round()).exp2() as f32
    };
    let signals: [fn(&Sample) -> f32; 3] = [|s| s.y, |s| s.u1, |s| s.u2];
    let difference = |x: fn(&Sample) -> f32| scale(&|t| x(&samples[t]) - x(&samples[t - 1]));
    let mut scales = vec![];
    for (x, count) in signals.into_iter().zip([order.na, order.nb, order.nc]) {
        scales.extend((0..count).map(|k| if k == 0 { scale(&|t| x(&samples[t])) } else { difference(x) }));
    }
    scales.push(difference(|s| s.y));
    let mut array = [1.0; M];
    array.iter_mut().zip(scales).for_each(|(cell, scale)| *cell = scale);
    array
}

/// What became of consecutive segments of one length.
#[derive(Debug)]
pub struct Run {
    /// One result a segment.
    pub segments: Vec<Result<Estimate<M, P>, Reason>>,
    /// What the oracle needs to follow.
    pub course: Course,
    length: usize,
}

impl Run {
    /// Streams all samples through segments.
    #[must_use]
    pub fn new(regression: &Regression<M>, samples: &[Sample], length: usize) -> Self {
        assert!(Refined::fits(regression));
        let order = regression.order;
        let mut auxiliaries = vec![(0, oracle::raw(order, &regression.nominal.delta))];
        let mut estimator = Refined::new(regression);
        let mut segments = vec![];
        for (number, segment) in samples.chunks_exact(length).enumerate() {
            segment.iter().for_each(|sample| estimator.step(sample));
            let result = estimator.close();
            if let Ok(estimate) = &result {
                auxiliaries.push(((number + 1) * length, oracle::raw(order, &estimate.delta)));
            }
            segments.push(result);
        }
        Self { segments, course: Course { auxiliaries, rest_on: Some(order.largest_delay()) }, length }
    }

    /// The rows of a segment: its last samples.
    #[must_use]
    pub fn rows(&self, number: usize) -> std::ops::Range<usize> {
        let end = (number + 1) * self.length;
        let rows = self.segments[number].map_or(0, |estimate| estimate.rows as usize);
        end - rows..end
    }
}

/// Distance of δ-parameters from a fit in units of its standard deviations, √(Δᵀ cov⁻¹ Δ / n).
///
/// # Panics
/// Where the fit's covariance is not positive definite.
#[must_use]
pub fn rho(delta: &[f32], fit: &Fit) -> f64 {
    let n = fit.theta.len();
    let error = DVector::from_iterator(n, delta.iter().map(|x| f64::from(*x)).take(n)) - &fit.theta;
    let whitened = fit.covariance.clone().cholesky().expect("positive definite").solve(&error);
    (error.dot(&whitened) / n as f64).sqrt()
}

/// Largest distance of a single δ-parameter from a fit in units of its standard deviation.
#[must_use]
pub fn worst(delta: &[f32], fit: &Fit) -> f64 {
    let pairs = fit.theta.iter().zip(fit.deviations()).zip(delta);
    pairs.fold(0.0, |most, ((theta, sd), x)| f64::max(most, (f64::from(*x) - theta).abs() / sd))
}
