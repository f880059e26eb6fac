//! The core's estimators as the tests set them up: scaled to the samples, from a plant's nominal model.

use bearing_watch::model::{Channel, Feature, Forgetting, Regression};
use bearing_watch::plan::{Layout, Memory, Method, Plan, RegressionLayout, RunTime, RunTimeSample, Structure};
use bearing_watch::{Detector, Model, Reason};
use nalgebra::{DMatrix, DVector};

use crate::Inputs;
use crate::oracle::{self, Course, Fit};
use crate::plans::{constants, layout};
use crate::plants::Plant;

/// An estimate of a structure that was chosen at run time.
pub type Estimate = bearing_watch::Estimate<RunTime>;

/// A regression alone, its structure chosen at run time. Output and inputs with terms have a channel each.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The plan.
    pub plan: RunTime,
    /// The channels.
    pub channels: Vec<Channel>,
    /// The constants; unscaled, with a nominal model of zeros.
    pub constants: Regression<RunTime>,
}

impl Setup {
    /// From the largest plausible y, u1, u2.
    ///
    /// # Panics
    /// If the structure does not suit the method.
    #[must_use]
    pub fn new(structure: Structure, method: Method, memory: Memory, limits: [f32; 3]) -> Self {
        let plan = RunTime::of(layout(structure, method, memory)).expect("a structure for this method");
        let used = [true, structure.nb > 0, structure.nc > 0];
        let signals = ["y", "u1", "u2"].into_iter().zip(limits).zip(used);
        let channels = signals.filter(|(_, used)| *used).map(|((name, limit), _)| Channel::within(name, "", limit));
        Self { plan, channels: channels.collect(), constants: Regression::new(plan) }
    }

    /// The same constants with a constant term of scale 1 behind the others.
    #[must_use]
    pub fn with_offset(&self) -> Self {
        let layout = self.plan.layout();
        let regression = layout.regression.map(|r| RegressionLayout { structure: r.structure.with_offset(), ..r });
        let plan = RunTime::of(Layout { regression, ..layout }).expect("one column more");
        let mut constants = self.constants.clone();
        constants.scale.insert(layout.parameters(), 1.0);
        constants.nominal.push(0.0);
        Self { plan, channels: self.channels.clone(), constants }
    }

    /// A detector with nothing sampled yet, whose segments have this length.
    ///
    /// # Panics
    /// If the constants are refused.
    #[must_use]
    pub fn stream(&self, segment_samples: usize) -> Stream {
        let layout = self.plan.layout();
        let features: Vec<Feature> = (0..layout.features).map(Feature::Parameter).collect();
        let limits: Vec<f32> = self.channels.iter().map(|channel| channel.limit).collect();
        let mut constants = constants(self.plan, segment_samples as u32, &limits, &features, None);
        (constants.channels, constants.regression) = (self.channels.clone(), vec![self.constants.clone()]);
        let model = Box::leak(Box::new(Model::new(self.plan, constants).expect("good constants")));
        let sample = RunTimeSample { values: vec![0.0; self.channels.len()], ..RunTimeSample::default() };
        let used = layout.regression.map_or([false; 2], |r| [r.structure.nb > 0, r.structure.nc > 0]);
        Stream { detector: Detector::new(model), closed: None, sample, used }
    }
}

/// A detector that takes y, u1, u2.
#[derive(Clone, Debug)]
pub struct Stream {
    /// The detector.
    pub detector: Detector<'static, RunTime>,
    closed: Option<Estimate>,
    sample: RunTimeSample,
    /// Whether the inputs have channels.
    used: [bool; 2],
}

impl Stream {
    /// Takes one sample.
    pub fn step(&mut self, Inputs { y, u1, u2 }: &Inputs) {
        let inputs = [u1, u2].into_iter().zip(self.used).filter(|(_, used)| *used).map(|(x, _)| x);
        let values = std::iter::once(y).chain(inputs);
        self.sample.values.iter_mut().zip(values).for_each(|(cell, x)| *cell = *x);
        if let Some(report) = self.detector.step(&self.sample) {
            self.closed = report.estimate().cloned();
        }
    }

    /// The estimate of the segment that the last sample has closed.
    ///
    /// # Panics
    /// If it has closed none.
    pub fn closed(&mut self) -> Estimate {
        assert_eq!(self.detector.pending(), 0, "the last sample closes a segment");
        self.closed.take().expect("a segment")
    }

    /// The estimate of the open segment, which stays open.
    ///
    /// # Panics
    /// If there is no regression.
    #[must_use]
    pub fn open(&self) -> Estimate {
        self.detector.preview().estimate().cloned().expect("a regression")
    }
}

/// Least squares over segments, without a constant term, scaled to these samples.
#[must_use]
pub fn least_squares(structure: Structure, samples: &[Inputs]) -> Setup {
    scaled(structure, Method::LeastSquares, samples)
}

/// Refined instrumental variables for a plant, from its nominal model.
#[must_use]
pub fn refined(plant: &Plant, samples: &[Inputs]) -> Setup {
    let structure = plant.structure();
    let mut setup = scaled(structure, Method::Instruments, samples);
    setup.constants.nominal = single(&oracle::delta(structure, &plant.nominal()));
    // Transients of an exchanged auxiliary model die out with the slowest pole, 50 ms: exp(−3) of them is left.
    setup.constants.settle = (0.15 * plant.rate_hz) as u16;
    setup
}

/// With fading memory of 1e4 rows.
///
/// # Panics
/// If there is no regression.
#[must_use]
pub fn fading(setup: &Setup, floor: f32) -> Setup {
    let layout = setup.plan.layout();
    let regression = layout.regression.map(|regression| RegressionLayout { memory: Memory::Fading, ..regression });
    let plan = RunTime::of(Layout { regression, ..layout }).expect("the same columns");
    let mut fading = Setup { plan, ..setup.clone() };
    fading.constants.forgetting = Forgetting { lambda: 0.9999, floor };
    // A memory that fades has a limit of rest; this one is met by any motion.
    fading.constants.rest = fading.constants.rest.max(1e-12);
    fading
}

/// Numbers in single precision.
#[must_use]
pub fn single(x: &DVector<f64>) -> Vec<f32> {
    x.iter().map(|x| *x as f32).collect()
}

fn scaled(structure: Structure, method: Method, samples: &[Inputs]) -> Setup {
    let mut setup = Setup::new(structure, method, Memory::Segment, [1e6; 3]);
    let scales = scales(structure, samples);
    setup.constants.scale.iter_mut().zip(scales).for_each(|(cell, scale)| *cell = scale);
    setup
}

/// Powers of two that bring levels, differences and the target y − y₁ to an rms near one.
fn scales(structure: Structure, samples: &[Inputs]) -> Vec<f32> {
    let scale = |of: &dyn Fn(usize) -> f32| {
        let square: f64 = (1..samples.len()).map(|t| f64::from(of(t)).powi(2)).sum();
        let rms = (square / (samples.len() - 1) as f64).sqrt();
        (-rms.log2().round()).exp2() as f32
    };
    let signals: [fn(&Inputs) -> f32; 3] = [|s| s.y, |s| s.u1, |s| s.u2];
    let difference = |x: fn(&Inputs) -> f32| scale(&|t| x(&samples[t]) - x(&samples[t - 1]));
    let mut scales = vec![];
    for (x, count) in signals.into_iter().zip([structure.na, structure.nb, structure.nc]) {
        scales.extend((0..count).map(|k| if k == 0 { scale(&|t| x(&samples[t])) } else { difference(x) }));
    }
    scales.push(difference(|s| s.y));
    scales
}

/// The estimate, or the reason why there is none.
///
/// # Errors
/// The reason.
pub fn outcome(estimate: Estimate) -> Result<Estimate, Reason> {
    estimate.reason.map_or(Ok(estimate), Err)
}

/// Covariance of the δ-parameters without the constant.
#[must_use]
pub fn covariance(estimate: &Estimate, terms: usize) -> DMatrix<f64> {
    DMatrix::from_fn(terms, terms, |i, j| f64::from(estimate.covariance(i, j)))
}

/// What became of consecutive segments of one length.
#[derive(Debug)]
pub struct Run {
    /// One result a segment.
    pub segments: Vec<Result<Estimate, Reason>>,
    /// What the oracle needs to follow.
    pub course: Course,
    length: usize,
}

impl Run {
    /// Streams all samples through segments.
    ///
    /// # Panics
    /// If the set-up has no structure.
    #[must_use]
    pub fn new(setup: &Setup, samples: &[Inputs], length: usize) -> Self {
        let structure = setup.plan.layout().regression.expect("a regression").structure;
        let mut auxiliaries = vec![(0, oracle::raw(structure, &setup.constants.nominal))];
        let mut stream = setup.stream(length);
        let mut segments = vec![];
        for (number, segment) in samples.chunks_exact(length).enumerate() {
            segment.iter().for_each(|sample| stream.step(sample));
            let result = outcome(stream.closed());
            if let Ok(estimate) = &result {
                auxiliaries.push(((number + 1) * length, oracle::raw(structure, estimate.delta())));
            }
            segments.push(result);
        }
        let filled = structure.nkb.max(structure.nkc);
        Self { segments, course: Course { auxiliaries, rest_on: Some(filled.into()) }, length }
    }

    /// The rows of a segment: its last samples.
    #[must_use]
    pub fn rows(&self, number: usize) -> std::ops::Range<usize> {
        let end = (number + 1) * self.length;
        let rows = self.segments[number].as_ref().map_or(0, |estimate| estimate.rows as usize);
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
