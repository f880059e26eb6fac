//! `cargo xtask frameworks`: the drive monitor under RTIC and embassy, and beside another crate's current loop, in the
//! emulated chip.

use anyhow::{Result, ensure};

use crate::board::DRIVE;
use crate::stages::Stages;
use crate::tally::Tally;
use crate::target::brief;
use crate::toolchain::Way;
use crate::{closed_loop, firmware, on_board, pil, qemu, workspace};

/// The crates in the folder `frameworks`; their packages have the prefix `drive-`.
const CRATES: [&str; 2] = ["rtic", "embassy"];

/// Runs the checks and prints them; whether nothing failed.
pub fn run(way: Way) -> bool {
    let mut stages = Stages::default();
    stages.stage("frameworks", |tally| checks(tally, way));
    stages.end()
}

/// Each program must print the lines of the example `drive` on the host.
pub fn checks(tally: &mut Tally, way: Way) {
    for name in CRATES {
        let title = format!("drive under {name}");
        tally.check(&title, brief(compare(way, name)));
    }
    tally.check("a foreign drive in closed loop", brief(closed_loop::run(way)));
    tally.check("tests for boards", brief(on_board::run(way)));
}

fn compare(way: Way, name: &str) -> Result<String> {
    let (folder, host) = pil::host_lines()?;
    let elf = firmware::build_crate(way, &workspace::root().join("frameworks").join(name), &format!("drive-{name}"))?;
    let target = qemu::run_in(&folder, &elf, DRIVE.machine, qemu::Echo::Off)?;
    pil::same_lines(&host, &target)?;
    ensure!(host.iter().any(|line| line.contains("spall")), "no segment is called a spall: {host:?}");
    Ok(format!("{} lines", target.len()))
}
