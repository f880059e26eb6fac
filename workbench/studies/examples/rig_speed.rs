//! Number of traces of the standard rig that one core simulates per second, by class.
//!
//! `cargo run --release -p bearing-watch-studies --example rig_speed`

use std::hint::black_box;
use std::time::Instant;

use rig::{Defect, DefectKind, Scenario, simulate};

/// Number of traces per batch; small, so that other processes do not disturb the fastest of many batches.
const TRACES: u32 = 5;
const BATCHES: u64 = 40;

fn main() -> Result<(), rig::RigError> {
    println!("class, traces a second on one core ({} samples a trace)", Scenario::STANDARD.samples);
    for kind in DefectKind::ALL {
        let scenario = Scenario::STANDARD.with_defect(Defect::full(kind));
        let mut fastest_s = f64::INFINITY;
        for batch in 0..BATCHES {
            let start = Instant::now();
            for k in 0..u64::from(TRACES) {
                black_box(simulate(&scenario, 1000 * batch + k)?);
            }
            fastest_s = fastest_s.min(start.elapsed().as_secs_f64());
        }
        println!("{}, {:.0}", kind.name(), f64::from(TRACES) / fastest_s);
    }
    Ok(())
}
