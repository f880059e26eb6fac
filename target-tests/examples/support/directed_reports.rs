//! Reports of a drive whose third feature rises: what its alarm by runs says.

use bearing_watch::{Detector, Evidence, Report, Verdict};

use super::directed::{DIRECTIONS, Directed, MODEL, decision};

/// Segments of a run, and runs.
pub const RUN: u32 = 6;
pub const RUNS: u32 = 14;
/// The feature that rises from this run on.
pub const RISES: (usize, u32) = (2, 10);

/// Gives the report of each segment with the evidence that has observed it.
pub fn run(mut take: impl FnMut(&Report<Directed>, &Evidence<Directed>)) {
    let mut evidence = Evidence::new(&MODEL);
    let mut report = Detector::new(&MODEL).finish();
    for run in 0..RUNS {
        let mut values = [0.0; DIRECTIONS];
        if run >= RISES.1 {
            values[RISES.0] = 6.0;
        }
        for segment in 1..=RUN {
            report.decision = decision(values);
            report.verdict = Verdict::Class(0);
            evidence.observe(report.decision.as_ref());
            if segment == RUN {
                evidence.end_run();
            }
            take(&report, &evidence);
        }
    }
}
