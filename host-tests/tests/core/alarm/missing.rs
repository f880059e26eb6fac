//! Densities of coordinates with errors and missing values, against double precision.

use bearing_watch::model::{Departure, Discriminant, Feature, KNOTS, Novelty};
use bearing_watch::plan::{Kind, Layout, Memory, Method, Plan, RunTime, Structure};
use host_tests::plans::{classifier, layout};
use model::train::novelty::law::equivalent;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const Z: usize = 6;
const INFINITY: f32 = f32::INFINITY;

fn plan() -> RunTime {
    let plain = layout(Structure::new(1, 0, 0, 0, 0), Method::LeastSquares, Memory::Segment);
    RunTime::of(Layout { coordinates: Z as u8, ..plain }).expect("a plan")
}

/// D and R of Σ = RᵀDR.
fn factor(covariance: &DMatrix<f64>) -> Vec<f32> {
    let lower = covariance.clone().cholesky().expect("positive definite").l();
    let places = (0..Z).flat_map(|i| (i..Z).map(move |j| (i, j)));
    let element = |i: usize, j: usize| if i == j { lower[(i, i)].powi(2) } else { lower[(j, i)] / lower[(i, i)] };
    places.map(|(i, j)| element(i, j) as f32).collect()
}

/// A covariance whose features differ in size and have correlations up to the given one.
fn covariance(correlation: f64, random: &mut ChaCha8Rng) -> DMatrix<f64> {
    let common = DVector::from_fn(Z, |_, _| if random.random() { 1.0 } else { -1.0 });
    DMatrix::from_fn(Z, Z, |i, j| {
        let size = 10_f64.powi(i as i32 - 3) * 10_f64.powi(j as i32 - 3);
        size * common[i] * common[j] * if i == j { 1.0 } else { correlation }
    })
}

/// d² and ln p over the available coordinates, with the errors.
fn exact(covariance: &DMatrix<f64>, away: &[f64], variances: &[f32]) -> (f64, f64) {
    let there: Vec<usize> = (0..Z).filter(|&k| variances[k] < INFINITY).collect();
    let own = |i: usize, j: usize| {
        covariance[(there[i], there[j])] + if i == j { f64::from(variances[there[i]]) } else { 0.0 }
    };
    let widened = DMatrix::from_fn(there.len(), there.len(), own);
    let x = DVector::from_iterator(there.len(), there.iter().map(|&k| away[k]));
    let factor = widened.cholesky().expect("positive definite");
    let squared = x.dot(&factor.solve(&x));
    let normaliser = there.len() as f64 * std::f64::consts::TAU.ln() + factor.ln_determinant();
    (squared, -0.5 * (normaliser + squared))
}

#[test]
fn likelihoods_and_distances_are_those_of_double_precision() {
    // Rounding of the factor is amplified by the root of the condition number, not by the number itself.
    for (correlation, within) in [(0.5, 5e-6), (0.99, 5e-6), (0.9999, 3e-5)] {
        let mut random = ChaCha8Rng::seed_from_u64(20);
        let mut worst = [0.0_f64; 2];
        for _ in 0..300 {
            let covariance = covariance(correlation, &mut random);
            let lower = covariance.clone().cholesky().expect("positive definite").l();
            let away = lower * DVector::from_fn(Z, |_, _| -> f64 { StandardNormal.sample(&mut random) });
            let z: Vec<f32> = away.iter().map(|x| *x as f32).collect();
            let away: Vec<f64> = z.iter().map(|x| f64::from(*x)).collect();
            let variances: Vec<f32> = (0..Z)
                .map(|k| match random.random_range(0..4) {
                    0 => INFINITY,
                    1 => 0.0,
                    _ => (covariance[(k, k)] * random.random::<f64>()) as f32,
                })
                .collect();
            let (squared, log) = exact(&covariance, &away, &variances);
            let discriminant = Discriminant::<RunTime> {
                means: vec![0.0; Z],
                factors: factor(&covariance),
                ..classifier(plan(), &[Feature::Parameter(0)]).discriminant
            };
            let found = f64::from(discriminant.log_likelihood(Kind::Linear, &z, &variances, 0));
            worst[0] = worst[0].max((found - log).abs() / log.abs().max(1.0));
            let novelty = Novelty { class: Some(0), factor: factor(&covariance), ..Novelty::none(plan()) };
            let available = variances.iter().filter(|v| **v < INFINITY).count();
            let expected = if available == 0 { 0.0 } else { equivalent(squared, available, Z).sqrt() };
            let found = f64::from(novelty.judge(&z, &variances).distance);
            worst[1] = worst[1].max((found - expected).abs() / expected.max(1.0));
        }
        println!("correlation {correlation}: log-likelihood {:.1e}, distance {:.1e}", worst[0], worst[1]);
        assert!(worst.iter().all(|worst| *worst < within), "{correlation}: {worst:?}");
    }
}

#[test]
fn errors_lower_the_surprise_and_never_make_it_undefined() {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let mut novelty = Novelty { class: Some(0), ..Novelty::none(plan()) };
    novelty.factor = factor(&covariance(0.9, &mut random));
    novelty.knots = std::array::from_fn::<_, KNOTS, _>(|k| [3.0 * k as f32, k as f32]);
    for _ in 0..1000 {
        let z: Vec<f32> = (0..Z).map(|k| 10_f32.powi(k as i32 - 3) * random.random_range(-9.0..9.0)).collect();
        let mut before = f32::INFINITY;
        for variance in [0.0, 1e-30, 1e-6, 1e-3, 1.0, 1e3, 1e12, 1e30, f32::MAX] {
            let Departure { distance, surprise, .. } = novelty.judge(&z, &[variance; Z]);
            assert!(distance.is_finite() && surprise <= before * 1.000_01, "{variance}: {surprise} after {before}");
            before = surprise;
        }
    }
}
