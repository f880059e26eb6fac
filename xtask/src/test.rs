//! `cargo xtask test`: every check of the repository, in one run with one count.

use std::env;
use std::process::Command;

use anyhow::{Result, bail};

use crate::beside::Beside;
use crate::tally::{Stages, Tally};
use crate::toolchain::{self, Way};
use crate::{book, c_library, child, dependencies, frameworks, newcomer, pil, python, setup, target, workspace};

/// Runs all stages, prints the table and the count; whether nothing failed. A failing stage does
/// not keep later ones from running, unless they need it. The stages of the target run beside those of the host, since
/// the emulator and many builds use one processor.
pub fn run(asked: Option<Way>) -> bool {
    let mut stages = Stages::default();
    let way = stages.stage("set-up", |tally| set_up(tally, asked));
    let beside = way.map(Beside::start);
    stages.stage("format", format);
    stages.stage("lints", lints);
    stages.stage("documentation", documentation);
    stages.stage("host tests", host_tests);
    stages.stage("Python", python::checks);
    stages.stage("dependencies", dependencies::checks);
    match beside {
        Some(beside) => beside.end(&mut stages),
        None => on_target(&mut stages, None),
    }
    let total = stages.total();
    println!("\n{}\n{total}", stages.table());
    total.failed == 0
}

/// Runs the stages of the target alone, and prints their rows for [`Stages::take_row`].
pub fn run_on_target(way: Option<Way>) -> bool {
    workspace::tests_are_beside();
    let mut stages = Stages::default();
    on_target(&mut stages, way);
    print!("{}", stages.rows());
    stages.total().failed == 0
}

/// First what needs no program of the host, which the other process builds meanwhile; last the other boards.
fn on_target(stages: &mut Stages, way: Option<Way>) {
    stages.stage("firmware builds", |tally| target::builds(tally, way));
    stages.stage("no panic", |tally| target::no_panic(tally, way));
    stages.stage("instructions, stack", |tally| target::bounds(tally, way));
    stages.stage("host = target", |tally| target::same_lines(tally, way));
    stages.stage("logging", |tally| target::logging(tally, way));
    stages.stage("processor in the loop", |tally| pil::check(tally, way));
    stages.stage("C library", |tally| c_library::checks(tally, way));
    stages.stage("frameworks", |tally| frameworks::checks(tally, way));
    stages.stage("newcomer", |tally| newcomer::checks(tally, way));
    stages.stage("other boards", |tally| target::other_boards(tally, way));
}

/// The way to build firmware, once everything for it is there.
fn set_up(tally: &mut Tally, asked: Option<Way>) -> Option<Way> {
    let ready = toolchain::choose(asked).and_then(|way| setup::ensure(way).map(|()| way));
    let way = ready.as_ref().ok().copied();
    let outcome = ready.map(|way| format!("the {way} way"));
    tally.check("firmware tools", outcome.map_err(|e| format!("{e:#}")));
    match setup::ensure_chromium() {
        // Continuous integration must not do without; elsewhere the tests of pages are left out.
        Err(error) if env::var_os("CI").is_none() => tally.skip("browser", &format!("{error:#}")),
        found => tally.check("browser", found.map_err(|error| format!("{error:#}"))),
    }
    way
}

fn format(tally: &mut Tally) {
    if component(tally, "fmt", "rustfmt") {
        for manifest in ["Cargo.toml", "frameworks/Cargo.toml", "template/Cargo.toml"] {
            let mut cargo = workspace::cargo(&["fmt", "--all", "--check", "--manifest-path", manifest]);
            tally.check(&format!("cargo fmt, {manifest}"), silent(&mut cargo));
        }
    }
}

fn lints(tally: &mut Tally) {
    if component(tally, "clippy", "clippy") {
        let mut cargo = workspace::cargo(&["clippy", "--workspace", "--all-targets", "--all-features"]);
        cargo.args(["--", "--deny", "warnings"]);
        tally.check("cargo clippy", silent(&mut cargo));
    }
}

fn documentation(tally: &mut Tally) {
    // With the features of the lints, whose metadata of dependencies it uses again.
    let mut cargo = workspace::cargo(&["doc", "--workspace", "--no-deps", "--all-features"]);
    let flags = env::var("RUSTDOCFLAGS").unwrap_or_default();
    cargo.env("RUSTDOCFLAGS", format!("{flags} -Dwarnings"));
    tally.check("cargo doc", silent(&mut cargo));
    // Includes and links are tests of this crate; mdBook only draws them.
    if child::on_path("mdbook") {
        tally.check("mdbook", book::build().map(|_| ""));
    } else {
        tally.skip("mdbook", "not installed (cargo install mdbook --locked)");
    }
}

/// With overflow and debug checks on; the development profile is optimised, since the numeric tests simulate minutes
/// of drive time. Documentation examples are among the tests. What passing tests print is shown: their figures, and
/// which data they had to do without.
fn host_tests(tally: &mut Tally) {
    // Without the examples, which have no tests: clippy has read them, and those that are needed are built later.
    for kind in [workspace::TESTS, "--doc"] {
        let mut cargo = workspace::cargo(&["test", "--workspace", kind, "--no-fail-fast", "--", "--show-output"]);
        let before = tally.failed;
        let status = child::lines(&mut cargo, |line| {
            println!("{line}");
            tally.add_libtest(line);
        });
        match status {
            Ok(status) if status.success() => {}
            // The tests that failed are counted already.
            Ok(_) if tally.failed > before => {}
            Ok(status) => tally.check::<&str, _>(&format!("cargo test {kind}"), Err(status)),
            Err(error) => tally.check::<&str, _>(&format!("cargo test {kind}"), Err(format!("{error:#}"))),
        }
    }
    if tally.failed == 0 {
        workspace::tests_are_built();
    }
}

/// Whether a part of the toolchain is there; a small rustup installation lacks some.
fn component(tally: &mut Tally, command: &str, name: &str) -> bool {
    let there = child::works(&mut workspace::cargo(&[command, "--version"]));
    if !there {
        let way_out = format!("not installed (rustup component add {name})");
        tally.skip(&format!("cargo {command}"), &way_out);
    }
    there
}

/// Success without a word of praise, since the program has printed its own.
fn silent(command: &mut Command) -> Result<&'static str> {
    let status = child::lines(command, |line| println!("{line}"))?;
    if !status.success() {
        bail!("{status}");
    }
    Ok("")
}
