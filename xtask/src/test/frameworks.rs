//! The drive monitor under RTIC and embassy, tests for boards, and a drive that knows nothing of bearing-watch under
//! the field-oriented control of another crate: recorded, described, trained, and watched in closed loop in the
//! emulator, as its engineers would do it.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::pil;
use super::target::equal;
use crate::cargo;
use crate::child;
use crate::firmware::board::DRIVE;
use crate::firmware::build::{MODEL, build_crate, build_suite};
use crate::firmware::way::Way;
use crate::firmware::{elf, qemu};
use crate::report::Tally;
use crate::workspace::{root, target_dir};

/// Each program must print the lines of the example `drive` on the host.
pub fn checks(tally: &mut Tally, way: Way) {
    for name in ["rtic", "embassy"] {
        tally.check(&format!("drive under {name}"), compare(way, name));
    }
    tally.check("a foreign drive in closed loop", closed_loop(way));
    tally.check("tests for boards", on_board(way));
}

fn crates() -> PathBuf {
    root().join("frameworks")
}

fn compare(way: Way, name: &str) -> Result<String> {
    let (folder, host) = pil::host_lines()?;
    let elf = build_crate(way, &crates().join(name), &format!("drive-{name}"), None)?;
    ensure!(host.iter().any(|line| line.contains("spall")), "no segment is called a spall: {host:?}");
    equal(&host, &qemu::run_in(&folder, &elf, DRIVE)?)
}

/// The tests of `frameworks/on-board`, built as a user builds them for probe-rs, and run in the emulator, which gets
/// the address of a test as probe-rs gives it. Returns their names.
fn on_board(way: Way) -> Result<String> {
    let elf = build_suite(way, &crates().join("on-board"), "suite")?;
    let tests = elf::tests(&elf)?;
    ensure!(tests.len() > 3, "tests are missing: {:?}", tests.keys());
    for (name, address) in &tests {
        qemu::run_test(&elf, DRIVE, &address.to_string()).with_context(|| name.clone())?;
    }
    // An address that the emulator cannot call must not pass for a test.
    ensure!(qemu::run_test(&elf, DRIVE, "x").is_err(), "a wrong command passes");
    Ok(tests.into_keys().collect::<Vec<_>>().join(", "))
}

/// Trains with recordings of the drive, builds it with the model, and runs it.
fn closed_loop(way: Way) -> Result<String> {
    let (target, folder) = (target_dir().join("closed-loop"), target_dir().join("closed-loop/recordings"));
    let mut train = Command::new("sh");
    train.arg("foc/train.sh").current_dir(crates()).env("CARGO_TARGET_DIR", target.join("target"));
    train.env("FOLDER", &folder).env("WORKBENCH", cargo::workbench()?.get_program());
    child::succeed(&mut train)?;
    let elf = build_crate(way, &crates().join("foc"), "drive-foc", Some((MODEL, &folder.join("model.rs"))))?;
    judge(&qemu::run(&elf, DRIVE)?)
}

/// The wiring is right, the sound bearing is healthy, the damaged one is a spall and alarms, and nothing was lost.
fn judge(lines: &[String]) -> Result<String> {
    let all = lines.join("; ");
    // What the firmware prints where the bearing gets its spall.
    let damaged = lines.iter().position(|line| line.starts_with("a spall")).with_context(|| all.clone())?;
    let (before, after) = lines.split_at(damaged);
    let of = |lines: &[String], class: &str| lines.iter().filter(|line| line.starts_with(class)).count();
    ensure!(before.first().is_some_and(|line| line.starts_with("wiring right")), "the wiring is not right: {all}");
    ensure!(of(before, "healthy") + 1 == before.len(), "the sound bearing is not called healthy: {all}");
    ensure!(of(after, "spall") + 3 >= after.len() && of(after, "healthy") == 0, "the spall is not found: {all}");
    ensure!(after.iter().any(|line| line.ends_with("ALARM")), "no alarm: {all}");
    for word in ["lost: 0 samples, 0 segments", "no faults"] {
        ensure!(after.iter().any(|line| line == word), "not `{word}`: {all}");
    }
    Ok(format!("{} segments healthy, then an alarm with segment {} of the spall", before.len() - 1, after.len() - 3))
}
