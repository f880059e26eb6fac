//! The monitor on the drive: a trained model in flash, traces of the standard rig as the converter's counts, and the
//! detector's verdict on each.
//!
//! The same file runs on a board, in QEMU (`cargo xtask firmware`) and on the host (`cargo run --example monitor`),
//! and prints the same lines everywhere, down to the last bit of every estimate. `cargo demo --model DIR` makes the
//! two files it includes.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[path = "support/standard_rig/model.rs"]
mod model;

use bearing_watch::{Sample, Verdict};

use model::{MODEL, Monitor};

/// Three traces of 5000 samples, held out from training; three 16-bit counts a sample.
static RECORDING: &[u8] = include_bytes!("support/standard_rig/held_out.bin");

main!(run);

fn run() {
    let mut monitor = match Monitor::new(&MODEL) {
        Ok(monitor) => monitor,
        Err(error) => {
            say!("the model is refused: {error}");
            return;
        }
    };
    for (number, sample) in RECORDING.chunks_exact(6).enumerate() {
        if let Some(report) = monitor.step(measured(sample)) {
            say!("segment ending at sample {}", number + 1);
            for (k, x) in report.estimate.delta.iter().take(report.estimate.parameters()).enumerate() {
                say!("  parameter {k}  {:08x}", x.to_bits());
            }
            say!("  variance     {:08x}, {} rows", report.estimate.variance.to_bits(), report.estimate.rows);
            for x in report.estimate.covariance {
                say!("  covariance   {:08x}", x.to_bits());
            }
            if let Some(decision) = report.decision {
                for (label, (likelihood, posterior)) in
                    MODEL.labels.iter().zip(decision.log_likelihoods.iter().zip(decision.posteriors))
                {
                    let (likelihood, bits) = (likelihood.to_bits(), posterior.to_bits());
                    say!("  {:10} log-likelihood {likelihood:08x}, posterior {bits:08x}", label.as_str());
                }
            }
            match report.verdict {
                Verdict::Class(class) => say!("verdict: {}", MODEL.label(class)),
                Verdict::Undetermined(reason) => say!("undetermined: {reason}"),
            }
            // The next trace does not go on from this one. A running drive would not restart.
            monitor.restart();
        }
    }
}

/// Counts of the converter, which spans the model's limits, as physical values.
fn measured(sample: &[u8]) -> Sample {
    let mut values = [0.0; 3];
    for ((value, count), limit) in values.iter_mut().zip(sample.chunks_exact(2)).zip(MODEL.regression.guard.limit) {
        if let [low, high] = count {
            *value = f32::from(i16::from_le_bytes([*low, *high])) * (limit / 32_768.0);
        }
    }
    let [y, u1, u2] = values;
    Sample { y, u1, u2 }
}
