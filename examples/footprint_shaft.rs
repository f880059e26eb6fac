//! The smallest program with a detector that watches the shaft, of eight parameters by least squares and four bearing orders:
//! `cargo xtask measure` prints its flash.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "only its constants are wanted here")]
#[path = "support/refined.rs"]
mod refined;
#[allow(dead_code, reason = "only its constants are wanted here")]
#[path = "support/shaft.rs"]
mod shaft;

use bearing_watch::decide::{Classifier, Features};
use bearing_watch::estimate::{Form, Method, Shape, Triangle};
use bearing_watch::{Angle, Detector, Model, Motion, Order, Regression, Regressor, Shaft};

/// Two output terms and three of each input, known when compiling.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Structure;

const FORM: Form = Form { order: Order::new(2, 3, 3, 1, 1), offset: false, method: Method::LeastSquares };

impl Shape for Structure {
    const FIXED: Option<Form> = Some(FORM);
}

type Monitor<'m> = Detector<'m, 9, 36, 1, 9, 3, 3, Regressor<9, 1, Structure>, Triangle<9, 36>, Shaft<4>, 4>;

program!(run);

fn run() -> ! {
    let plain = &refined::MODEL;
    let features = Features { index: [0, 1, 2, 129, 138, 144, 160, 161, 192], count: 9 };
    // A trained one is a static; the few instructions that make this one are counted with it.
    let model: Model<9, 9, 3, 3, 4> = Model {
        sampling: plain.sampling,
        regression: Regression { guard: plain.regression.guard, ..Regression::new(FORM.order, FORM.offset) },
        shaft: Some(shaft::model::<4>(1, 100)),
        classifier: Classifier { features, ..plain.classifier },
        evidence: plain.evidence,
        labels: plain.labels,
    };
    let Ok(mut monitor) = Monitor::new(&model) else {
        loop {
            core::hint::spin_loop();
        }
    };
    loop {
        let sample = footprint::sample();
        let motion = Motion {
            current_a: sample.y,
            velocity_rad_s: sample.u1,
            reference_rad_s: sample.u1,
            load_nm: sample.u2,
            angle: Angle::from_bits(sample.y.to_bits()),
        };
        if let Some(report) = monitor.step_with_motion(sample, &motion) {
            footprint::tell(report.verdict);
        }
    }
}
