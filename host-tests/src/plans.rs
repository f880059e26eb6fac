//! Plans, channels and constants of the core, from few numbers.

use bearing_watch::model::{
    Channel, Classifier, Constants, Covariate, Covariates, Discriminant, EvidenceConstants, Feature, Label, Name,
    Novelty, Projection, Regression, Sampling, ShaftConstants,
};
use bearing_watch::plan::Structure;
use bearing_watch::plan::{
    Cells, Kind, Layout, Memory, Method, Plan, RegressionLayout, RunTime, RunTimeSample, Signal,
};
use bearing_watch::{Detector, Model};

use crate::Inputs;
use crate::streams::Estimate;

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

/// The layout of a regression alone; its parameters are its features.
#[must_use]
pub fn layout(structure: Structure, method: Method, memory: Memory) -> Layout {
    let inputs = u8::from(structure.nb > 0);
    let regression = RegressionLayout {
        structure,
        method,
        memory,
        y: Signal::channel(0),
        u1: Signal::channel(1),
        u2: Signal::channel(1 + inputs),
    };
    Layout {
        channels: 1 + inputs + u8::from(structure.nc > 0),
        regression: Some(regression),
        features: structure.parameters() as u8,
        coordinates: 1,
        classes: 1,
        ..Layout::EMPTY
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

/// A classifier of unit covariances whose coordinates are the first features; class k lies at k in each coordinate.
#[must_use]
pub fn classifier<P: Plan>(plan: P, features: &[Feature]) -> Classifier<P> {
    let layout = plan.layout();
    let (count, coordinates, classes) =
        (layout.features as usize, layout.coordinates as usize, layout.classes as usize);
    let one = |equal: bool| f32::from(u8::from(equal));
    let packed = coordinates * (coordinates + 1) / 2;
    // Row i of a factor starts after rows of lengths Z, Z − 1, ….
    let diagonal = |place: usize| (0..coordinates).any(|i| place % packed == i * (2 * coordinates + 1 - i) / 2);
    let densities = if layout.discriminant == Kind::Linear { 1 } else { classes };
    Classifier {
        features: Cells::from_fn(count, |k| features[k]),
        covariates: Covariates { list: Cells::filled(0, Covariate::BLANK), map: Cells::filled(0, [0.0; 2]) },
        projection: Projection {
            matrix: Cells::from_fn(coordinates * count, |k| one(k / count == k % count)),
            mean: Cells::filled(count, 0.0),
            usual: Cells::filled(count, 0.0),
        },
        discriminant: Discriminant {
            means: Cells::from_fn(classes * coordinates, |k| (k / coordinates) as f32),
            factors: Cells::from_fn(densities * packed, |k| one(diagonal(k))),
            log_prior: Cells::filled(classes, -(classes as f32).ln()),
            costs: Cells::from_fn(classes * classes, |k| one(k / classes != k % classes)),
            reject_cost: f32::INFINITY,
        },
        novelty: Novelty::none(plan),
    }
}

/// Constants of a whole model: segments of the given length, wide limits for all channels, a regression without
/// scaling, and the given shaft. Channels are named as in the plan, or by their number.
#[must_use]
pub fn constants<P: Plan>(
    plan: P,
    segment_samples: u32,
    limits: &[f32],
    features: &[Feature],
    shaft: Option<&ShaftConstants<P>>,
) -> Constants<P> {
    let layout = plan.layout();
    let channel = |k: usize| {
        let own = P::channels().and_then(|channels| channels.get(k)).copied();
        let number = format!("channel {}", k + 1);
        let (name, unit) = own.unwrap_or((&number, ""));
        Channel {
            name: Name::new(name).expect("short"),
            unit: Name::new(unit).expect("short"),
            ..Channel::within("", "", limits[k])
        }
    };
    Constants {
        sampling: Sampling { interval_s: 0.002, park: None, block_mean: 1, segment_samples },
        channels: Cells::from_fn(layout.channels as usize, channel),
        regression: Cells::from_fn(layout.regressed(), |_| Regression::new(plan)),
        shaft: Cells::from_fn(layout.watched(), |_| shaft.expect("the plan watches a shaft").clone()),
        classifier: classifier(plan, features),
        evidence: EvidenceConstants::NONE,
        labels: Cells::from_fn(layout.classes as usize, |k| Label::new(&format!("class {k}")).expect("short")),
    }
}
