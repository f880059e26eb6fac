//! `cargo xtask long`: the tests that run for minutes, which the usual run leaves out, and the table they print.

use anyhow::{Result, ensure};

use crate::reports::Libtest;
use crate::tally::Tally;
use crate::{child, workspace};

/// Runs every ignored host test and ends with the table's rows alone. Returns whether all tests passed.
pub fn run() -> Result<bool> {
    let (table, passed) = measure()?;
    println!("\n{}", table.join("\n"));
    Ok(passed)
}

/// Runs every ignored host test in release and passes on what it prints. Returns the table's rows, which are the lines
/// that start with `|`, and whether all tests passed.
pub fn measure() -> Result<(Vec<String>, bool)> {
    let mut cargo = workspace::cargo(&["test", "--release", "--package", "host-tests", "--no-fail-fast"]);
    cargo.args(["--", "--ignored", "--show-output", "--test-threads", "1"]);
    let (mut table, mut libtest, mut tally) = (Vec::new(), Libtest::default(), Tally::default());
    let status = child::lines(&mut cargo, |line| {
        println!("{line}");
        libtest.read(line, &mut tally);
        if line.starts_with('|') {
            table.push(line.to_owned());
        }
    })?;
    ensure!(!table.is_empty(), "no ignored test of host-tests printed a table");
    println!("\n{}{tally}", tally.list());
    Ok((table, status.success()))
}
