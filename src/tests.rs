//! A small drive that the tests of several rooms share: its plan, a model of two classes, samples, and the report of
//! its detector.

use crate::detector::Detector;
use crate::model::{
    Channel, Classifier, Constants, Covariates, Directions, Discriminant, EvidenceConstants, Feature, Forgetting,
    Label, Model, Novelty, Projection, Regression, Sampling,
};
use crate::plan::{Kind, Layout, Memory, Method, RegressionLayout, Structure};
use crate::report::Report;
use crate::signal::Park;

/// Samples of a segment.
pub const SAMPLES: u32 = 200;

/// A plan with its sample and its model, by one of the methods; the rows have so many columns.
macro_rules! drive {
    ($plan:ident, $sample:ident, $model:ident, $method:ident, $columns:literal) => {
        crate::plan! {
            pub struct $plan;
            pub struct $sample { current_a: "A", velocity_rad_s: "rad/s" }
            layout: Layout {
                regression: Some(RegressionLayout {
                    structure: Structure::new(1, 1, 0, 1, 0),
                    method: Method::$method,
                    memory: Memory::Segment,
                    y: current_a,
                    u1: velocity_rad_s,
                    u2: velocity_rad_s,
                }),
                features: 2,
                coordinates: 1,
                classes: 2,
                discriminant: Kind::Linear,
                ..Layout::EMPTY
            }
        }

        /// Classes at the gains 0.5 and 1 of y = 0.8 y₁ + b u₁.
        pub static $model: Model<$plan> = match $plan::model(Constants {
            sampling: Sampling {
                interval_s: 0.001,
                park: Some(Park::Standard),
                block_mean: 1,
                segment_samples: SAMPLES,
            },
            channels: [
                Channel { stuck_samples: 20, ..Channel::within("current_a", "A", 100.0) },
                Channel::within("velocity_rad_s", "rad/s", 10.0),
            ],
            regression: [Regression {
                scale: [1.0; $columns],
                nominal: [-0.2, 0.5],
                forgetting: Forgetting { lambda: 0.999, floor: 10.0 },
                rest: 0.0,
                settle: 10,
                handover: 5,
            }],
            shaft: [],
            classifier: Classifier {
                features: [Feature::Parameter(0), Feature::Parameter(1)],
                covariates: Covariates { list: [], map: [] },
                projection: Projection { matrix: [0.0, 1.0], mean: [0.0, 0.0], usual: [0.0, 0.0] },
                discriminant: Discriminant {
                    means: [0.5, 1.0],
                    factors: [0.0025],
                    log_prior: [-0.693, -0.693],
                    costs: [0.0, 1.0, 1.0, 0.0],
                    reject_cost: f32::INFINITY,
                },
                novelty: Novelty {
                    class: None,
                    mean: [0.0],
                    factor: [0.0],
                    knots: [[0.0; 2]; 24],
                    laws: [],
                    rises: [],
                    acceptable: f32::INFINITY,
                    freedom: 1.0,
                    limit: f32::INFINITY,
                    directions: Directions::NONE,
                },
            },
            evidence: EvidenceConstants::NONE,
            labels: [Label::constant("half"), Label::constant("whole")],
        }) {
            Ok(model) => model,
            Err(error) => panic!("{}", error.message()),
        };
    };
}

drive!(Drive, Sample, MODEL, LeastSquares, 3);
drive!(Refined, RefinedSample, REFINED, Instruments, 4);

impl From<Sample> for RefinedSample {
    fn from(Sample { current_a, velocity_rad_s }: Sample) -> Self {
        Self { current_a, velocity_rad_s }
    }
}

/// A square wave through the model of gain `b`, with a little noise.
pub fn samples(b: f32) -> impl Iterator<Item = Sample> {
    let (mut state, mut y, mut u) = (3_u32, 0.0, 0.0);
    (0_u32..).map(move |t| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f32::from((state >> 16) as i16) / 3e7;
        y = 0.8 * y + b * u + noise;
        u = if t % 7 < 3 { 1.0 } else { -1.0 };
        Sample { current_a: y, velocity_rad_s: u }
    })
}

/// The report of the first segment.
pub fn report(mut samples: impl Iterator<Item = Sample>) -> Report<Drive> {
    let mut detector = Detector::new(&MODEL);
    loop {
        if let Some(report) = detector.step(&samples.next().unwrap()) {
            return report;
        }
    }
}
