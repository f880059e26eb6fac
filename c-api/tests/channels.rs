//! What is said of each channel: its mean, its root mean square, and whether it is stuck.
#![allow(
    clippy::cast_possible_truncation,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::panic,
    reason = "a test fails by a panic"
)]

#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::mem::MaybeUninit;

use bearing_watch::Model;
use bearing_watch::model::{
    Channel, Classifier, Constants, Covariates, Directions, Discriminant, EvidenceConstants, Feature, Forgetting,
    KNOTS, Label, Novelty, Projection, Regression, Sampling,
};
use bearing_watch::plan::{Layout, Memory as Rows, Method, RegressionLayout, Structure};
use bearing_watch_c::*;

use support::{Memory, bytes, step, values};

bearing_watch::plan! {
    /// Three channels of a regression, and as many beside them as the library averages.
    struct Channels;
    struct Sample { a: "A", b: "A", c: "A", d: "A", e: "A", f: "A", g: "A" }
    layout: Layout {
        regression: Some(RegressionLayout {
            structure: Structure::new(1, 1, 1, 1, 1),
            method: Method::LeastSquares,
            memory: Rows::Segment,
            y: b,
            u1: c,
            u2: d,
        }),
        averaged: a.mask() | e.mask() | f.mask() | g.mask(),
        features: 1,
        coordinates: 1,
        classes: 1,
        ..Layout::EMPTY
    }
}

const CHANNELS: usize = 7;
const SEGMENT: u32 = 100;

fn model() -> Model<Channels> {
    let channel = |name| Channel { stuck_samples: 20, ..Channel::within(name, "A", 64.0) };
    Channels::model(Constants {
        sampling: Sampling { interval_s: 0.001, park: None, block_mean: 1, segment_samples: SEGMENT },
        channels: ["a", "b", "c", "d", "e", "f", "g"].map(channel),
        regression: [Regression {
            scale: [1.0; 4],
            nominal: [-1.0; 3],
            forgetting: Forgetting { lambda: 0.9999, floor: 100.0 },
            rest: 1e-6,
            settle: 0,
            handover: 0,
        }],
        shaft: [],
        classifier: Classifier {
            features: [Feature::ChannelMean(0)],
            covariates: Covariates { list: [], map: [] },
            projection: Projection { matrix: [1.0], mean: [0.0], usual: [0.0] },
            discriminant: Discriminant {
                means: [0.0],
                factors: [1.0],
                log_prior: [0.0],
                costs: [0.0],
                reject_cost: f32::INFINITY,
            },
            novelty: Novelty {
                class: None,
                mean: [0.0],
                factor: [0.0],
                knots: [[0.0; 2]; KNOTS],
                laws: [],
                rises: [],
                freedom: 1.0,
                acceptable: f32::INFINITY,
                limit: f32::INFINITY,
                directions: Directions::NONE,
            },
        },
        evidence: EvidenceConstants::NONE,
        labels: [Label::constant("healthy")],
    })
    .expect("a good model")
}

/// A state with the report of a segment of these samples.
fn reported(memory: &mut Memory, of: impl Fn(u32) -> [f32; CHANNELS]) -> (*mut BwState, BwReport) {
    let state = memory.state(&bytes(&model())).expect("a model that fits");
    let mut report = MaybeUninit::<BwReport>::uninit();
    // SAFETY: the state is initialised, and the values are there; the report is written if the code says so.
    let report = unsafe {
        (0..SEGMENT).for_each(|k| _ = step(state, &of(k), 0));
        assert_eq!(bw_report(state, report.as_mut_ptr()), BwCode::Ok);
        report.assume_init()
    };
    (state, report)
}

/// Four values of the mean 1.5 and the mean square 3.5, times a factor.
fn wave(k: u32, factor: f32) -> f32 {
    factor * (k % 4) as f32
}

#[test]
fn a_channel_that_is_stuck_is_named_alone_also_the_last_one() {
    for channel in 0..CHANNELS {
        let mut memory = Memory::new();
        let (_, report) =
            reported(&mut memory, |k| core::array::from_fn(|place| if place == channel { 2.0 } else { wave(k, 1.0) }));
        assert_eq!(report.stuck, 1 << channel);
    }
}

#[test]
fn the_mean_and_the_root_mean_square_of_each_averaged_channel_are_given() {
    let mut memory = Memory::new();
    let (state, report) = reported(&mut memory, |k| core::array::from_fn(|place| wave(k, 1.0 + place as f32)));
    let of = |what| values(state, what).into_iter().map(|x| (1e3 * x).round()).collect::<Vec<f32>>();
    assert_eq!((report.stuck, of(BwValues::Means)), (0, vec![1500.0, 7500.0, 9000.0, 10_500.0]));
    assert_eq!(of(BwValues::RootMeanSquares), [1871.0, 9354.0, 11_225.0, 13_096.0]);
}
