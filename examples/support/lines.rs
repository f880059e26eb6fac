//! The start of a drive's watch on a recording, and the lines that its main loop prints: `drive` and the crates of
//! `frameworks` share them.

use bearing_watch::{Conclusion, Verdict};

use crate::model::{Drive, FRONT_END, MODEL, WATCH};
use crate::support::hash::Hash;

/// Starts the watch; returns the text of the error if it does not start.
pub fn start() -> Result<(), &'static str> {
    WATCH.start(&MODEL, &FRONT_END).map_err(|error| error.message())?;
    // The first call tests the arithmetic of its context, which is no work of a row.
    WATCH.collect();
    Ok(())
}

/// Reports printed so far.
#[derive(Default)]
pub struct Lines {
    segments: u32,
}

impl Lines {
    /// One step of the main loop. Prints a report where a drive sends it.
    pub fn advance(&mut self) {
        WATCH.advance(|now| {
            print(self.segments, now);
            self.segments += 1;
        });
    }

    /// Solves what waits, and prints the last line.
    pub fn end(&mut self) {
        // More steps than a solve has.
        (0..99).for_each(|_| self.advance());
        let status = WATCH.status();
        let clear = status.faults.is_some_and(|faults| faults.is_clear());
        say!("{} segments, {} lost, front end clear: {clear}", self.segments, status.lost_segments);
    }
}

/// Prints a report with the bits of its log-likelihoods and the hash of all its numbers.
fn print(number: u32, Conclusion { report, alarm, .. }: Conclusion<'_, Drive>) {
    let rows = report.rows;
    let end = if alarm.is_some() { ", ALARM" } else { "" };
    match report.verdict {
        Verdict::Undetermined(reason) => say!("segment {number}: {rows} rows, {reason}{end}"),
        verdict => say!("segment {number}: {rows} rows, {}{end}", MODEL.verdict_name(verdict)),
    }
    let mut hash = Hash::new();
    report.estimate().into_iter().for_each(|estimate| hash.add_estimate(estimate));
    report.shaft().into_iter().for_each(|shaft| hash.add_shaft(shaft));
    for (class, value) in report.decision.iter().flat_map(|decision| decision.log_likelihoods()).enumerate() {
        hash.add(&[*value]);
        say!("  log-likelihood {class} {:08x}", value.to_bits());
    }
    say!("  all numbers {:08x}", hash.bits());
}
