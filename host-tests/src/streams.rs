//! The core's estimators as the tests set them up.

use bearing_watch::estimate::Regression;
use bearing_watch::{Order, Sample};
use nalgebra::DVector;

use crate::oracle::Fit;

/// A regression without a constant term, scaled to these samples.
#[must_use]
pub fn regression<const M: usize>(order: Order, samples: &[Sample]) -> Regression<M> {
    Regression { order, offset: false, scale: scales(order, samples), limit: [1e6; 3] }
}

/// Powers of two that bring levels, differences and the target y − y₁ to an rms near one.
#[must_use]
pub fn scales<const M: usize>(order: Order, samples: &[Sample]) -> [f32; M] {
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
