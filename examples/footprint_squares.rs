//! The smallest program with a detector of eight parameters by least squares: `cargo xtask measure` prints its flash.
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

use bearing_watch::estimate::{Form, Method, Shape};
use bearing_watch::{Detector, Model, Order, Regression, Regressor};

/// Two output terms and three of each input, known when compiling.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Structure;

const FORM: Form = Form { order: Order::new(2, 3, 3, 1, 1), offset: false, method: Method::LeastSquares };

impl Shape for Structure {
    const FIXED: Option<Form> = Some(FORM);
}

type Monitor = Detector<'static, 9, 36, 1, 9, 3, 3, Regressor<9, 1, Structure>>;

/// The classifier of the model by instrumental variables serves: only its size counts.
static MODEL: Model<9, 9, 3, 3> = Model {
    sampling: refined::MODEL.sampling,
    regression: Regression { guard: refined::MODEL.regression.guard, ..Regression::new(FORM.order, FORM.offset) },
    shaft: None,
    classifier: refined::MODEL.classifier,
    evidence: refined::MODEL.evidence,
    labels: refined::MODEL.labels,
};

program!(run);

fn run() -> ! {
    let Ok(mut monitor) = Monitor::new(&MODEL) else {
        loop {
            core::hint::spin_loop();
        }
    };
    loop {
        if let Some(report) = monitor.step(footprint::sample()) {
            footprint::tell(report.verdict);
        }
    }
}
