//! Averages of channels and covariates through the whole core, against double precision.

use bearing_watch::model::{Covariate, Covariates, Feature, Field};
use bearing_watch::plan::Structure;
use bearing_watch::plan::{Layout, LayoutError, Memory, Method, RegressionLayout};
use bearing_watch::{Detector, Model, ModelError, Reason, Report};
use host_tests::plans::constants;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::model::plans::same_bits;

bearing_watch::plan! {
    /// y = −a y₁ + b u₁, and a temperature.
    pub struct Warm;
    pub struct Sample { y: "A", u: "rad/s", temperature_c: "°C" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(1, 1, 0, 1, 0),
            method: Method::LeastSquares,
            memory: Memory::Segment,
            y,
            u1: u,
            u2: u,
        }),
        averaged: y.mask() | temperature_c.mask(),
        features: 3,
        covariates: 1,
        coordinates: 3,
        classes: 2,
        ..Layout::EMPTY
    }
}

const FEATURES: [Feature; 3] = [Feature::Parameter(0), Feature::Parameter(1), Feature::ChannelRms(0)];
pub const TEMPERATURE: Covariate =
    Covariate { feature: Feature::ChannelMean(2), centre: 40.0, low: 20.0, high: 100.0, usual: 0.0 };
/// The temperature explains the first two features.
pub const MAP: [[f32; 2]; 3] = [[0.003, -2e-5], [-0.01, 1e-4], [0.0, 0.0]];
const SAMPLES: usize = 3000;

pub fn model(list: [Covariate; 1], map: [[f32; 2]; 3]) -> Result<Model<Warm>, ModelError> {
    let plain = constants(Warm, SAMPLES as u32, &[100.0, 100.0, 500.0], &FEATURES, None);
    let classifier =
        bearing_watch::model::Classifier { covariates: Covariates { list, map }, ..plain.classifier.clone() };
    Model::new(Warm, bearing_watch::model::Constants { classifier, ..plain })
}

/// A record around this temperature; some temperatures are lost.
pub fn record(temperature_c: f64, lost: f64) -> Vec<Sample> {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let (mut y, mut u) = (0.0_f64, 0.0_f64);
    (0..SAMPLES)
        .map(|_| {
            y = 0.8 * y + 0.5 * u + 0.1 * random.random_range(-1.0..1.0);
            u = random.random_range(-1.0..1.0);
            let own = temperature_c + random.random_range(-2.0..2.0);
            let own = if random.random::<f64>() < lost { f64::NAN } else { own };
            Sample { y: y as f32, u: u as f32, temperature_c: own as f32 }
        })
        .collect()
}

pub fn run(model: &Model<Warm>, samples: &[Sample]) -> Report<Warm> {
    let mut detector = Detector::new(model);
    samples.iter().find_map(|sample| detector.step(sample)).expect("a segment")
}

/// The three features and the mean temperature in double precision.
fn features(samples: &[Sample]) -> ([f64; 3], f64) {
    let (y, u) = (|k: usize| f64::from(samples[k].y), |k: usize| f64::from(samples[k].u));
    let rows = DMatrix::from_fn(SAMPLES - 1, 2, |k, place| if place == 0 { y(k) } else { u(k) });
    let target = DVector::from_fn(SAMPLES - 1, |k, _| y(k + 1));
    let found = (rows.transpose() * &rows).cholesky().expect("excited").solve(&(rows.transpose() * target));
    let rms = ((0..SAMPLES).map(|k| y(k) * y(k)).sum::<f64>() / SAMPLES as f64).sqrt();
    let known = samples.iter().map(|own| f64::from(own.temperature_c)).filter(|own| own.is_finite());
    let (sum, count) = known.fold((0.0, 0.0_f64), |(sum, count), own| (sum + own, count + 1.0));
    // δ-form: t₀ = −(1 + a), a = −found.
    ([found[0] - 1.0, found[1], rms], sum / count)
}

/// ln p of unit densities at (0, 0, 0) and (1, 1, 1) over the available features.
fn log_likelihoods(z: &[f64]) -> [f64; 2] {
    [0.0, 1.0].map(|mean| z.iter().map(|z| -0.5 * ((z - mean).powi(2) + std::f64::consts::TAU.ln())).sum())
}

fn assert_near(report: &Report<Warm>, expected: [f64; 2]) {
    let decision = report.decision.as_ref().expect("a decision");
    for (found, expected) in decision.log_likelihoods().iter().zip(expected) {
        // Roundings of a few numbers near one, and of sums over 3000 samples.
        assert!((f64::from(*found) - expected).abs() < 2e-5, "{found} {expected}");
    }
}

#[test]
fn what_the_temperature_explains_is_subtracted() {
    let model = model([TEMPERATURE], MAP).expect("good");
    for (temperature, lost) in [(40.0, 0.0), (21.0, 0.0), (99.0, 0.3), (107.0, 0.0), (13.0, 0.45)] {
        let samples = record(temperature, lost);
        let ([first, second, rms], mean) = features(&samples);
        let report = run(&model, &samples);
        let average = report.averages().iter().find(|own| own.channel() == 2).expect("averaged");
        assert!((f64::from(average.mean().expect("known")) / mean - 1.0).abs() < 2e-7);
        let c = mean - 40.0;
        let z = [first - (0.003 - 2e-5 * c) * c, second - (-0.01 + 1e-4 * c) * c, rms];
        assert_near(&report, log_likelihoods(&z));
        let decision = report.decision.as_ref().expect("a decision");
        assert_eq!((decision.outside(), decision.missing()), (&[false][..], &[false; 3][..]));
    }
}

#[test]
fn outside_the_range_the_verdict_rests_on_the_other_features() {
    let model = model([TEMPERATURE], MAP).expect("good");
    // Beyond the margin of a tenth, and unknown for more than half of the samples.
    for (temperature, lost) in [(110.0, 0.0), (10.0, 0.0), (40.0, 0.6)] {
        let samples = record(temperature, lost);
        let report = run(&model, &samples);
        let decision = report.decision.as_ref().expect("a decision");
        assert_eq!((decision.outside(), decision.missing()), (&[true][..], &[true, true, false][..]));
        assert_near(&report, log_likelihoods(&features(&samples).0[2..]));
    }
    let all = self::model([TEMPERATURE], [[0.003, 0.0]; 3]).expect("good");
    let reason = |temperature: f64, lost: f64| {
        let report = run(&all, &record(temperature, lost));
        assert_eq!(report.decision, None);
        report.verdict
    };
    let undetermined = bearing_watch::Verdict::Undetermined;
    assert_eq!(reason(110.0, 0.0), undetermined(Reason::OutOfRange { covariate: 0 }));
    assert_eq!(reason(40.0, 0.6), undetermined(Reason::LostSamples { channel: 2 }));
    let words = Reason::OutOfRange { covariate: 0 }.to_string();
    assert_eq!(words, "covariate 1 is outside the range of the training records");
}

#[test]
fn bytes_keep_the_covariates_and_a_plan_at_run_time_gives_the_same_bits() {
    let model = model([TEMPERATURE], MAP).expect("good");
    let samples = [(60.0, 0.2), (120.0, 0.0)].into_iter().flat_map(|(temperature, lost)| record(temperature, lost));
    let reports = same_bits(&model, samples);
    let outside = reports.iter().map(|report| report.decision.as_ref().expect("a decision").outside());
    assert_eq!(outside.collect::<Vec<_>>(), [[false], [true]]);
}

#[test]
fn bad_ranges_and_coefficients_are_refused() {
    let refused = Err(ModelError::OutOfRange(Field::Covariate));
    let with = |list: Covariate| model([list], MAP).map(|_| ());
    for bad in [f32::NAN, f32::INFINITY, 1e31] {
        assert_eq!(with(Covariate { low: -bad, ..TEMPERATURE }), refused, "{bad}");
        assert_eq!(with(Covariate { high: bad, ..TEMPERATURE }), refused, "{bad}");
        assert_eq!(with(Covariate { centre: bad, ..TEMPERATURE }), refused, "{bad}");
        assert_eq!(with(Covariate { usual: bad, ..TEMPERATURE }), refused, "{bad}");
    }
    assert_eq!(with(Covariate { low: 100.0, high: 20.0, ..TEMPERATURE }), refused);
    assert_eq!(with(Covariate { centre: 10.0, ..TEMPERATURE }), refused);
    assert_eq!(with(Covariate { usual: -1.0, ..TEMPERATURE }), refused);
    // The mean of a channel that is not averaged, and of one that does not exist.
    assert_eq!(with(Covariate { feature: Feature::ChannelMean(1), ..TEMPERATURE }), refused);
    assert_eq!(with(Covariate { feature: Feature::ChannelMean(200), ..TEMPERATURE }), refused);
    let map = |value: f32| model([TEMPERATURE], [[0.0, value], [0.0; 2], [0.0; 2]]).map(|_| ());
    assert_eq!((map(f32::NAN), map(f32::INFINITY), map(1.0)), (refused, refused, Ok(())));
    let many = Layout { covariates: 9, ..Warm.layout() };
    assert_eq!(many.check(), Err(LayoutError::Covariates));
    assert_eq!(Layout { averaged: 0, ..Warm.layout() }.check(), Err(LayoutError::UnusedChannel));
}
