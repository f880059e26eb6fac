//! A model of eight parameters by least squares, for the plant of [`super::refined`].

use bearing_watch::Model;
use bearing_watch::model::{Constants, EvidenceConstants, Regression, Sampling};
use bearing_watch::plan::{Kind, Layout, Memory, Method, RegressionLayout};

use super::classifier::classifier;
use super::refined::{CHANNELS, FEATURES, FORGETTING, LABELS, NOMINAL, STRUCTURE};

bearing_watch::plan! {
    /// The plan.
    pub struct Squares;
    /// One sample of the plant.
    pub struct Sample { y: "A", u1: "rad/s", u2: "N·m" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: STRUCTURE,
            method: Method::LeastSquares,
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

/// The model.
pub static MODEL: Model<Squares> = match Squares::model(Constants {
    sampling: Sampling { interval_s: 0.001, park: None, block_mean: 1, segment_samples: 600 },
    channels: CHANNELS,
    regression: [Regression {
        scale: [1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 1.0, 1.0, 2.0],
        nominal: NOMINAL,
        forgetting: FORGETTING,
        rest: 0.0,
        settle: 40,
        handover: 0,
    }],
    shaft: [],
    classifier: classifier!(FEATURES),
    evidence: EvidenceConstants::NONE,
    labels: LABELS,
}) {
    Ok(model) => model,
    Err(error) => panic!("{}", error.message()),
};
