//! Plans, channels and constants of the core, from few numbers.

use bearing_watch::model::{
    Channel, Classifier, Constants, Covariate, Covariates, Discriminant, EvidenceConstants, Feature, Label, Name,
    Novelty, Projection, Regression, Sampling, ShaftConstants,
};
use bearing_watch::plan::Structure;
use bearing_watch::plan::{Cells, Kind, Layout, Memory, Method, Plan, RegressionLayout, Signal};

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
