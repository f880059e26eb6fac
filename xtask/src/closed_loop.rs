//! A drive that knows nothing of bearing-watch, under the field-oriented control of another crate: recorded, described,
//! trained, and watched in closed loop in the emulator, as its engineers would do it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::board::DRIVE;
use crate::toolchain::Way;
use crate::{child, firmware, qemu, workspace};

/// The package, in the folder `frameworks/foc`.
const PACKAGE: &str = "drive-foc";
/// Seconds of a record, and records of each class.
const RECORDS: [&str; 2] = ["4", "40"];
/// What no recording tells: amperes a count by the data sheet, and the bearing by its number (608).
const SET: [(&str, &str, &str); 2] = [
    ("front_end.toml", "gain_a = [1.000000e0, 1.000000e0]", "gain_a = [0.01, 0.01]"),
    ("drive.toml", "# bearing = [9, 3, 17, 10]", "bearing = [7, 3.97, 15, 0]"),
];
/// What the firmware prints where the bearing gets its spall.
const DAMAGED: &str = "a spall";

/// Returns what the firmware found.
pub fn run(way: Way) -> Result<String> {
    let folder = workspace::target_dir().join("closed-loop");
    let model = train(&folder)?;
    let elf = firmware::build_crate_with_model(way, &crates().join("foc"), PACKAGE, &model)?;
    judge(&qemu::run(&elf, DRIVE.machine, qemu::Echo::Off)?)
}

fn crates() -> PathBuf {
    workspace::root().join("frameworks")
}

/// Records the drive, describes and trains; returns the model's source.
fn train(folder: &Path) -> Result<PathBuf> {
    let (recordings, target) = (folder.join("recordings"), folder.join("target"));
    if recordings.exists() {
        fs::remove_dir_all(&recordings)?;
    }
    let mut record = workspace::cargo(&["run", "--quiet", "--release", "--package", PACKAGE, "--example", "record"]);
    record.env("CARGO_TARGET_DIR", target).current_dir(crates()).arg("--").arg(&recordings);
    child::succeed(record.args(RECORDS))?;
    let workbench = || -> Result<Command> {
        let mut command = workspace::workbench()?;
        command.current_dir(&recordings);
        Ok(command)
    };
    child::succeed(workbench()?.args(["--quiet", "init", "--front-end", "."]))?;
    for (file, found, set) in SET {
        let path = recordings.join(file);
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        ensure!(text.contains(found), "{file} has no line {found}");
        fs::write(&path, text.replace(found, set))?;
    }
    child::succeed(workbench()?.args(["--quiet", "train", "drive.toml", "--model", "out.bwm", "--rust", "model.rs"]))?;
    Ok(recordings.join("model.rs"))
}

/// The wiring is right, the sound bearing is healthy, the damaged one is a spall and alarms, and nothing was lost.
fn judge(lines: &[String]) -> Result<String> {
    let all = lines.join("; ");
    let damaged = lines.iter().position(|line| line.starts_with(DAMAGED)).with_context(|| all.clone())?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alarm_before_the_spall_and_none_after_it_fail() {
        let lines = |text: &str| text.split('|').map(ToOwned::to_owned).collect::<Vec<_>>();
        let end = "lost: 0 samples, 0 segments|no faults";
        let good = format!("wiring right, 1.00|healthy, 9 rows|a spall of 1|spall, 9 rows|spall, 9 rows, ALARM|{end}");
        assert!(judge(&lines(&good)).is_ok_and(|found| found.ends_with("an alarm with segment 2 of the spall")));
        for (found, instead) in [
            ("|healthy, 9 rows", "|undetermined, 9 rows"),
            ("|spall, 9 rows|", "|healthy, 9 rows|"),
            (", ALARM", ""),
            ("a spall of 1|", ""),
            ("lost: 0", "lost: 1"),
            ("wiring right", "wrong"),
        ] {
            assert!(judge(&lines(&good.replace(found, instead))).is_err(), "{instead}");
        }
    }
}
