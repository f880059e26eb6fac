//! Simulated seconds of the EMA rig that one core simulates per second, by condition.
//!
//! `cargo run --release -p bearing-watch-studies --example ema_speed`

use std::hint::black_box;
use std::time::Instant;

use rig::DefectKind;
use rig::ema::{EmaCondition, EmaDefect, EmaScenario, Race, simulate};

/// Number of records; each is short, so that other processes do not disturb the fastest of them.
const RECORDS: u64 = 40;
/// Simulated time of a record.
const RECORD_S: f64 = 1.0;

fn main() -> Result<(), rig::RigError> {
    println!("condition, class, simulated seconds a second on one core");
    for condition in EmaCondition::ALL.into_iter().filter(|condition| !condition.mixed) {
        for kind in [DefectKind::Healthy, DefectKind::SpallAndRoughness] {
            let scenario = condition.scenario(0).with_defect(EmaDefect::of(kind, 1.0, Race::Inner));
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1200 or 10 000")]
            let rows = (RECORD_S / scenario.row_interval_s()).round() as usize;
            let scenario = EmaScenario { rows, ..scenario };
            let mut fastest_s = f64::INFINITY;
            for seed in 0..RECORDS {
                let start = Instant::now();
                black_box(simulate(&scenario, seed)?);
                fastest_s = fastest_s.min(start.elapsed().as_secs_f64());
            }
            println!("{}, {}, {:.0}", condition.name, kind.name(), RECORD_S / fastest_s);
        }
    }
    Ok(())
}
