//! The smallest program with a detector as `train` chooses it for a drive with a load sensor, friction and two bearing
//! orders of three harmonics: `cargo xtask measure` prints its flash.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;
#[path = "../../examples/support/classifier.rs"]
mod classifier;
#[path = "support/law.rs"]
mod law;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "../../examples/support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "only its constants are wanted here")]
#[path = "../../examples/support/refined.rs"]
mod refined;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "support/shaft.rs"]
mod shaft;

use bearing_watch::{Angle, Detector};

program!(run);

fn run() -> ! {
    let mut detector = Detector::new(&shaft::CHOSEN);
    loop {
        let [current_a, velocity_rad_s, load_nm] = footprint::inputs();
        let angle = Angle::from_bits(current_a.to_bits());
        let sample = shaft::ChosenSample { current_a, velocity_rad_s, load_nm, angle };
        if let Some(report) = detector.step(&sample) {
            footprint::tell(report.verdict);
        }
    }
}
