//! The smallest program with a detector of eight parameters by least squares: `cargo xtask measure` prints its flash.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;
#[path = "../../examples/support/classifier.rs"]
mod classifier;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "../../examples/support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "only its constants are wanted here")]
#[path = "../../examples/support/refined.rs"]
mod refined;
#[path = "support/squares.rs"]
mod squares;

use bearing_watch::Detector;

program!(run);

fn run() -> ! {
    let mut detector = Detector::new(&squares::MODEL);
    loop {
        let [y, u1, u2] = footprint::inputs();
        if let Some(report) = detector.step(&squares::Sample { y, u1, u2 }) {
            footprint::tell(report.verdict);
        }
    }
}
