//! A model of eight parameters by instrumental variables, and a plant for it.

use bearing_watch::Model;
use bearing_watch::model::{Channel, Constants, EvidenceConstants, Feature, Forgetting, Label, Regression, Sampling};
use bearing_watch::plan::{Kind, Layout, Memory, Method, RegressionLayout, Structure};

use super::classifier::classifier;
use super::numbers::Numbers;

/// Two output terms and three of each input.
pub const STRUCTURE: Structure = Structure::new(2, 3, 3, 1, 1);

bearing_watch::plan! {
    /// The plan.
    pub struct Refined;
    /// One sample of the plant.
    pub struct Sample { y: "A", u1: "rad/s", u2: "N·m" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: STRUCTURE,
            method: Method::Instruments,
            memory: Memory::Segment,
            y,
            u1,
            u2,
        }),
        features: 9,
        coordinates: 3,
        classes: 3,
        discriminant: Kind::Quadratic,
        ..Layout::EMPTY
    }
}

/// A current that does not change over 50 samples is stuck.
pub const CHANNELS: [Channel; 3] = [
    Channel { stuck_samples: 50, ..Channel::within("y", "A", 20.0) },
    Channel::within("u1", "rad/s", 20.0),
    Channel::within("u2", "N·m", 20.0),
];

/// A fifth off the plant, as a data sheet may be.
pub const NOMINAL: [f32; 8] = [-0.12, 0.5, 0.4, -0.15, 0.0, -0.3, 0.0, 0.0];

/// Not used by segments of equal weight.
pub const FORGETTING: Forgetting = Forgetting { lambda: 0.9999, floor: 100.0 };

/// All parameters and the residual variance.
pub const FEATURES: [Feature; 9] = [
    Feature::Parameter(0),
    Feature::Parameter(1),
    Feature::Parameter(2),
    Feature::Parameter(3),
    Feature::Parameter(4),
    Feature::Parameter(5),
    Feature::Parameter(6),
    Feature::Parameter(7),
    Feature::LogVariance,
];

/// The names of the classes.
pub const LABELS: [Label; 3] = [Label::constant("as built"), Label::constant("slack"), Label::constant("stiff")];

/// The model.
pub static MODEL: Model<Refined> = match Refined::model(Constants {
    sampling: Sampling { interval_s: 0.001, park: None, block_mean: 1, segment_samples: 600 },
    channels: CHANNELS,
    regression: [Regression {
        scale: [1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 1.0, 1.0, 2.0, 1.0, 1.0],
        nominal: NOMINAL,
        forgetting: FORGETTING,
        rest: 0.0,
        settle: 40,
        handover: 16,
    }],
    shaft: [],
    classifier: classifier!(FEATURES),
    evidence: EvidenceConstants::NONE,
    labels: LABELS,
}) {
    Ok(model) => model,
    Err(error) => panic!("{}", error.message()),
};

/// y = 1.5 y₁ − 0.6 y₂ + 0.3 u1₁ + 0.15 u1₂ + 0.05 u1₃ − 0.2 u2₁ − 0.1 u2₂ + 0.05 u2₃, measured with noise; one sample
/// in 701 is lost.
pub struct Plant {
    numbers: Numbers,
    y: [f32; 2],
    u1: [f32; 3],
    u2: [f32; 3],
    time: u32,
}

impl Plant {
    /// At rest.
    #[must_use]
    pub const fn new(seed: u32) -> Self {
        Self { numbers: Numbers(seed), y: [0.0; 2], u1: [0.0; 3], u2: [0.0; 3], time: 0 }
    }

    /// The next sample.
    pub fn sample(&mut self) -> Sample {
        let ([y1, y2], [b1, b2, b3], [c1, c2, c3]) = (self.y, self.u1, self.u2);
        let y = 1.5 * y1 - 0.6 * y2 + 0.3 * b1 + 0.15 * b2 + 0.05 * b3 - 0.2 * c1 - 0.1 * c2 + 0.05 * c3;
        let [u1, u2, noise] = self.numbers.array();
        (self.y, self.u1, self.u2) = ([y, y1], [u1, b1, b2], [u2, c1, c2]);
        self.time = self.time.wrapping_add(1);
        let lost = self.time.is_multiple_of(701);
        Sample { y: if lost { f32::NAN } else { y + 0.2 * noise }, u1, u2 }
    }
}
