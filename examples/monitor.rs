//! The monitor on the drive: a trained model in flash, traces of the standard rig as the converter's counts, and the
//! detector's verdict on each.
//!
//! The same file runs on a board, in QEMU (`cargo xtask firmware`) and on the host (`cargo run --example monitor`),
//! and prints the same lines everywhere, down to the last bit of every estimate. `cargo demo --model DIR` makes the
//! two files of `support/standard_rig`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "support/standard_rig/mod.rs"]
mod standard_rig;

use bearing_watch::{Detector, Verdict};

use standard_rig::model::MODEL;

main!(run);

fn run() {
    let mut monitor = Detector::new(&MODEL);
    for (number, sample) in standard_rig::samples().enumerate() {
        if let Some(report) = monitor.step(&sample) {
            say!("segment ending at sample {}", number + 1);
            if let Some(estimate) = report.estimate() {
                for (k, x) in estimate.delta().iter().enumerate() {
                    say!("  parameter {k}  {:08x}", x.to_bits());
                }
                say!("  variance     {:08x}, {} rows", estimate.variance.to_bits(), estimate.rows);
                for x in estimate.packed_covariance() {
                    say!("  covariance   {:08x}", x.to_bits());
                }
            }
            if let Some(decision) = &report.decision {
                let values = decision.log_likelihoods().iter().zip(decision.posteriors());
                for (label, (likelihood, posterior)) in MODEL.constants().labels.iter().zip(values) {
                    let (likelihood, bits) = (likelihood.to_bits(), posterior.to_bits());
                    say!("  {:10} log-likelihood {likelihood:08x}, posterior {bits:08x}", label.as_str());
                }
            }
            match report.verdict {
                Verdict::Class(class) => say!("verdict: {}", MODEL.label(class)),
                Verdict::Novel => say!("verdict: novel"),
                Verdict::Ambiguous => say!("verdict: ambiguous"),
                Verdict::Undetermined(reason) => say!("undetermined: {reason}"),
            }
            // The next trace does not go on from this one. A running drive would not restart.
            monitor.restart();
        }
    }
}
