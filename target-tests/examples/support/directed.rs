//! A model whose alarm watches runs in five directions, and decisions of segments for it.

use bearing_watch::model::{
    Background, Channel, Classifier, Constants, Covariates, Direction, Directions, Discriminant, EvidenceConstants,
    Feature, FeatureValue, Forgetting, Label, Novelty, Projection, Regression, Sampling,
};
use bearing_watch::plan::{Kind, Layout, Memory, Method, RegressionLayout, Structure};
use bearing_watch::{Decision, Model};

use super::law::LAW;

/// Coordinates and directions.
pub const DIRECTIONS: usize = 5;

bearing_watch::plan! {
    /// The means of five channels are the features and the coordinates; a plan needs a regression or a shaft.
    pub struct Directed;
    /// One sample.
    pub struct Sample { a: "A", b: "A", c: "A", d: "A", e: "A" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(1, 1, 0, 1, 0),
            method: Method::LeastSquares,
            memory: Memory::Segment,
            y: a,
            u1: b,
            u2: b,
        }),
        averaged: 0b1_1111,
        features: 5,
        coordinates: 5,
        directions: 5,
        classes: 1,
        discriminant: Kind::Linear,
        ..Layout::EMPTY
    }
}

/// Skewed, with a background: no part of the sums is left out.
const fn direction(coordinate: u8, explained_by: u8) -> Direction {
    let none = Background { coordinate: 0, weight: 0.0 };
    let background = [Background { coordinate: explained_by, weight: 0.25 }, none, none, none];
    Direction { coordinate, background, run: 0.1, segment: 1.0, between: 0.4, skewness: 0.3, ..Direction::UNIT }
}

const UNIT_FACTOR: [f32; 15] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0];

/// The model: runs of six segments, and 100 000 segments between false alarms.
pub static MODEL: Model<Directed> = match Directed::model(Constants {
    sampling: Sampling { interval_s: 0.001, park: None, block_mean: 1, segment_samples: 600 },
    channels: [
        Channel::within("a", "A", 100.0),
        Channel::within("b", "A", 100.0),
        Channel::within("c", "A", 100.0),
        Channel::within("d", "A", 100.0),
        Channel::within("e", "A", 100.0),
    ],
    regression: [Regression {
        scale: [1.0; 3],
        nominal: [-0.2, 0.5],
        forgetting: Forgetting { lambda: 0.999, floor: 10.0 },
        rest: 0.0,
        settle: 10,
        handover: 5,
    }],
    shaft: [],
    classifier: Classifier {
        features: [
            Feature::ChannelMean(0),
            Feature::ChannelMean(1),
            Feature::ChannelMean(2),
            Feature::ChannelMean(3),
            Feature::ChannelMean(4),
        ],
        covariates: Covariates { list: [], map: [] },
        projection: Projection {
            #[rustfmt::skip]
            matrix: [
                1.0, 0.0, 0.0, 0.0, 0.0,
                0.0, 1.0, 0.0, 0.0, 0.0,
                0.0, 0.0, 1.0, 0.0, 0.0,
                0.0, 0.0, 0.0, 1.0, 0.0,
                0.0, 0.0, 0.0, 0.0, 1.0,
            ],
            mean: [0.0; 5],
            usual: [0.0; 5],
        },
        discriminant: Discriminant {
            means: [0.0; 5],
            factors: UNIT_FACTOR,
            log_prior: [0.0],
            costs: [0.0],
            reject_cost: f32::INFINITY,
        },
        novelty: Novelty {
            class: Some(0),
            mean: [0.0; 5],
            factor: UNIT_FACTOR,
            knots: LAW,
            laws: [],
            rises: [],
            acceptable: f32::INFINITY,
            freedom: 100.0,
            limit: f32::INFINITY,
            directions: Directions {
                list: [direction(0, 1), direction(1, 2), direction(2, 3), direction(3, 4), direction(4, 0)],
                usual_segments: 6.0,
                margin: 1.645,
                most_runs: 60,
            },
        },
    },
    evidence: EvidenceConstants { limit: 14.2, cap: 7.7, segments_a_run: u32::MAX, ..EvidenceConstants::NONE },
    labels: [Label::constant("healthy")],
}) {
    Ok(model) => model,
    Err(error) => panic!("{}", error.message()),
};

/// The decision on a segment with these values in the directions.
pub fn decision(values: [f32; DIRECTIONS]) -> Option<Decision<Directed>> {
    let mut decision = MODEL.constants().classifier.decide(Directed, &[0.0], 0.5)?;
    decision.set_directed(&values.map(|value| FeatureValue { value, variance: 0.25 }));
    Some(decision)
}
