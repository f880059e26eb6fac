//! The smallest program with a detector of five coordinates and five directions, and no evidence of its decisions: what
//! `footprint_evidence` is compared with.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[path = "support/directed.rs"]
#[allow(dead_code, reason = "its decisions are those of the detector")]
mod directed;
#[macro_use]
#[path = "support/footprint.rs"]
mod footprint;
#[path = "support/law.rs"]
mod law;

use bearing_watch::Detector;

program!(run);

fn run() -> ! {
    let mut detector = Detector::new(&directed::MODEL);
    loop {
        let [a, b, c] = footprint::inputs();
        if let Some(report) = detector.step(&directed::Sample { a, b, c, d: a, e: b }) {
            footprint::tell(report.verdict);
        }
    }
}
