//! The monitor's verdicts as `defmt` logs them: texts stay in the ELF file, the wire carries a few bytes a line. Run by
//! `cargo xtask firmware logging`, which decodes them.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

#[cfg(target_os = "none")]
#[path = "support/standard_rig/mod.rs"]
mod standard_rig;

main!(run);

#[cfg(not(target_os = "none"))]
fn run() {
    say!("defmt logs on the target only: cargo xtask firmware logging");
}

#[cfg(target_os = "none")]
fn run() {
    use bearing_watch::Verdict;
    use standard_rig::model::{MODEL, Monitor};

    let mut monitor = match Monitor::new(&MODEL) {
        Ok(monitor) => monitor,
        Err(error) => return defmt::error!("the model is refused: {}", defmt::Display2Format(&error)),
    };
    for (number, sample) in standard_rig::samples().enumerate() {
        let Some(report) = monitor.step(sample) else { continue };
        match report.verdict {
            Verdict::Class(class) => defmt::info!("sample {}: verdict: {=str}", number + 1, MODEL.label(class)),
            Verdict::Undetermined(reason) => defmt::warn!("undetermined: {}", defmt::Display2Format(&reason)),
        }
        if let Some(decision) = report.decision {
            defmt::info!("{}", decision);
        }
        // The next trace does not go on from this one. A running drive would not restart.
        monitor.restart();
    }
}
