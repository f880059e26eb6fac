//! Combinations of the core's features, by cargo-hack: none, each, and each pair; on the host and on chips. All
//! features together are a check of `cargo xtask test`.
//!
//! In a copy whose workspace has the core alone: cargo-hack leaves the choice of the package to cargo, which would take
//! the default members of the workspace, and with them features that they want.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use super::copy;
use crate::board::{Board, DRIVE, NO_FPU};
use crate::tally::Tally;
use crate::target::brief;
use crate::toolchain::{self, Way};
use crate::tools::HACK;
use crate::{child, firmware, workspace};

/// Checks the library for the host, a chip with and a chip without floating-point hardware.
pub fn checks(tally: &mut Tally, way: Way) {
    let source = match source() {
        Ok(source) => source,
        Err(reason) => return tally.check::<&str, _>("pairs of features", Err(format!("{reason:#}"))),
    };
    tally.check("pairs of features on the host", brief(on_host(&source)));
    for board in [DRIVE, NO_FPU] {
        let title = format!("pairs of features on {}", board.target);
        match toolchain::hindrance(way, board.target) {
            Some(hindrance) => tally.missing(&title, &hindrance),
            None => tally.check(&title, brief(on_chip(way, board, &source))),
        }
    }
}

/// A copy of the tree with the core alone.
fn source() -> Result<PathBuf> {
    let source = copy::of_tree("features")?;
    copy::keep_only(&source, "")?;
    Ok(source)
}

fn on_host(source: &Path) -> Result<String> {
    let mut hack = HACK.command(&[])?;
    hack.env("CARGO_TARGET_DIR", workspace::target_dir().join("features/target"));
    check(hack, source, &[], None)
}

fn on_chip(way: Way, board: Board, source: &Path) -> Result<String> {
    let mut hack = HACK.command(&[])?;
    let options = firmware::prepare(&mut hack, way);
    check(hack, source, options, Some(board))
}

/// Runs `cargo hack check` and returns the number of combinations.
fn check(mut hack: Command, source: &Path, options: &[&str], board: Option<Board>) -> Result<String> {
    hack.current_dir(source).args(["hack", "check", "--lib", "--feature-powerset", "--depth", "2"]);
    if let Some(board) = board {
        hack.args(["--target", board.target]);
    }
    hack.args(options);
    let mut dry = Command::new(hack.get_program());
    dry.args(hack.get_args()).arg("--print-command-list");
    dry.current_dir(source);
    let count = child::output(&mut dry).map_or(0, |list| list.lines().count());
    ensure!(count > 2, "cargo hack names {count} combinations");
    child::succeed(&mut hack)?;
    Ok(format!("{count} combinations"))
}
