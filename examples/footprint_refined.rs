//! The smallest program with a detector of eight parameters by instrumental variables: `cargo xtask measure` prints its
//! flash.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "the plant is not wanted here")]
#[path = "support/refined.rs"]
mod refined;

use refined::{MODEL, Monitor};

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
