//! Combinations of the core's features, by cargo-hack: none, each, and each pair; on the host and on chips. All
//! features together are a check of `cargo xtask test`.

use std::process::Command;

use anyhow::{Result, ensure};

use crate::board::{Board, DRIVE, NO_FPU};
use crate::tally::Tally;
use crate::target::brief;
use crate::toolchain::{self, Way};
use crate::tools::HACK;
use crate::{child, firmware};

/// Checks the library for the host, a chip with and a chip without floating-point hardware.
pub fn checks(tally: &mut Tally, way: Way) {
    tally.check("pairs of features on the host", brief(HACK.command(&[]).and_then(|hack| check(hack, &[], None))));
    for board in [DRIVE, NO_FPU] {
        let title = format!("pairs of features on {}", board.target);
        match toolchain::hindrance(way, board.target) {
            Some(hindrance) => tally.skip(&title, &hindrance),
            None => tally.check(&title, brief(on_chip(way, board))),
        }
    }
}

fn on_chip(way: Way, board: Board) -> Result<String> {
    let mut hack = HACK.command(&[])?;
    let options = firmware::prepare(&mut hack, way);
    check(hack, options, Some(board))
}

/// Runs `cargo hack check` and returns the number of combinations.
fn check(mut hack: Command, options: &[&str], board: Option<Board>) -> Result<String> {
    hack.args([
        "hack",
        "check",
        "--locked",
        "--package",
        "bearing-watch",
        "--lib",
        "--feature-powerset",
        "--depth",
        "2",
    ]);
    if let Some(board) = board {
        hack.args(["--target", board.target]);
    }
    hack.args(options);
    let mut dry = Command::new(hack.get_program());
    dry.args(hack.get_args()).arg("--print-command-list");
    dry.current_dir(crate::workspace::root());
    let count = child::output(&mut dry).map_or(0, |list| list.lines().count());
    ensure!(count > 2, "cargo hack names {count} combinations");
    child::succeed(&mut hack)?;
    Ok(format!("{count} combinations"))
}
