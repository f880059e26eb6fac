//! A model of eight parameters by instrumental variables, and a plant for it.

use bearing_watch::decide::{Classifier, Discriminant, EvidencePlan, Features, Kind, Novelty, Projection};
use bearing_watch::estimate::{Form, Method, Nominal, Shape};
use bearing_watch::{Detector, Guard, Instruments, Label, Model, Order, Regression, Sample, Sampling};

use super::numbers::Numbers;

/// Two output terms and three of each input, known when compiling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Structure;

const FORM: Form = Form { order: Order::new(2, 3, 3, 1, 1), offset: false, method: Method::Instruments };

impl Shape for Structure {
    const FIXED: Option<Form> = Some(FORM);
}

/// The detector of exactly this model's size.
pub type Monitor = Detector<'static, 11, 55, 1, 9, 3, 3, Instruments<11, 1, Structure>>;

/// Its report.
pub type Report = bearing_watch::Report<11, 55, 3>;

/// What it hands out for a solve elsewhere.
pub type Segment = bearing_watch::Segment<11, 55, Structure>;

/// The constants, not from a training: they only have to tell the plant from others.
pub static MODEL: Model<11, 9, 3, 3> = Model {
    sampling: Sampling { interval_s: 0.001, block_mean: 1, segment_samples: 600 },
    regression: Regression {
        method: FORM.method,
        scale: [1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 1.0, 1.0, 2.0, 1.0, 1.0],
        // A fifth off the plant, as a data sheet may be.
        nominal: Nominal { delta: [-0.12, 0.5, 0.4, -0.15, 0.0, -0.3, 0.0, 0.0, 0.0, 0.0, 0.0], deviation: 0.3 },
        guard: Guard { stuck_samples: [50, 0, 0], huber: 6.0, ..Guard::within([20.0; 3]) },
        settle: 40,
        handover: 16,
        ..Regression::new(FORM.order, FORM.offset)
    },
    shaft: None,
    classifier: Classifier {
        features: Features { index: [0, 1, 2, 3, 4, 5, 6, 7, 8], count: 9 },
        projection: Projection {
            matrix: [
                [40.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 8.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0],
                [0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5],
            ],
            mean: [-0.1, 0.6, 0.5, -0.2, -0.05, -0.25, 0.05, -0.05, -4.5],
            count: 3,
        },
        discriminant: Discriminant {
            kind: Kind::Quadratic,
            classes: 3,
            mean: [[0.0; 3], [2.0, 0.0, 1.0], [-2.0, 1.0, 0.0]],
            whitening: [[[1.0, 0.0, 0.0], [0.1, 1.0, 0.0], [0.0, -0.1, 1.0]]; 3],
            log_normaliser: [-2.756_815_6; 3],
            log_prior: [-1.098_612_3; 3],
            cost: [[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]],
            reject_cost: f32::INFINITY,
        },
        novelty: Novelty::NONE,
    },
    evidence: EvidencePlan::NONE,
    labels: [label("as built"), label("slack"), label("stiff")],
};

const fn label(name: &str) -> Label {
    match Label::new(name) {
        Some(label) => label,
        None => Label::EMPTY,
    }
}

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
