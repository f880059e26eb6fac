//! The smallest program with the evidence of runs in five directions, the reason of its alarm, and the growth:
//! `cargo xtask measure` prints by how much its flash exceeds that of `footprint_decided`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[path = "support/directed.rs"]
#[allow(dead_code, reason = "its decisions are those of the detector")]
mod directed;
#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;
#[path = "support/law.rs"]
mod law;

use bearing_watch::{Detector, Evidence, Verdict};

program!(run);

fn run() -> ! {
    let mut detector = Detector::new(&directed::MODEL);
    let mut evidence = Evidence::new(&directed::MODEL);
    loop {
        let [a, b, c] = footprint::inputs();
        let Some(report) = detector.step(&directed::Sample { a, b, c, d: a, e: b }) else { continue };
        footprint::tell(report.verdict);
        let mut alarm = evidence.observe_outcome(report.outcome());
        if c > 0.0 {
            alarm = evidence.end_run();
        }
        let (Some(_), Some(main)) = (alarm, evidence.main_contribution()) else { continue };
        let grows = evidence.growth(main.direction).is_some_and(|growth| growth.is_growing());
        footprint::tell(if grows { Verdict::Class(main.direction) } else { Verdict::Novel });
    }
}
