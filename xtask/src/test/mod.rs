//! `cargo xtask test`: every check of the repository, in one run with one count.

mod c;
mod dependencies;
mod frameworks;
mod host;
mod pil;
mod requirements;
mod target;
mod web;

pub mod newcomer;

use std::env;
use std::fs::File;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use clap::builder::PossibleValuesParser;

use crate::cargo;
use crate::child::{self, Started};
use crate::firmware::way::Way;
use crate::report::{Stages, Tally};
use crate::setup;
use crate::workspace;

pub use c::{compared, measure as measure_c};
pub use dependencies::checks as dependencies;
pub use pil::run as run_pil;
pub use target::verdicts;

/// A part of the run: its name, what it needs besides a way to build firmware, and its checks.
type Stage = (&'static str, &'static [&'static str], fn(&mut Tally, Way));

/// Format, lints and unit tests: minutes.
const QUICK: [&str; 3] = ["format", "lints", "units"];

/// The stages of the host, in the order in which they use what others have built.
const HOST: [Stage; 9] = [
    ("format", &[], |tally, _| host::format(tally)),
    ("lints", &[], |tally, _| host::lints(tally)),
    ("trace", &[], |tally, _| requirements::checks(tally)),
    ("documentation", &["python", "pip"], |tally, _| host::documentation(tally)),
    ("units", &[], |tally, _| host::tests(tally, &["--lib"])),
    ("host", &["chromium"], |tally, _| host::tests(tally, &[cargo::TESTS, "--doc"])),
    ("python", &["python", "pip"], |tally, _| host::python(tally)),
    ("web", &["chromium", "driver", "python", "pip"], |tally, _| web::checks(tally)),
    ("dependencies", &["python", "pip"], |tally, _| dependencies::checks(tally)),
];

/// The stages of the emulated chips.
const TARGET: [Stage; 10] = [
    ("firmware", &[], target::builds),
    ("no-panic", &[], target::no_panic),
    ("bounds", &[], target::bounds),
    ("twins", &[], target::same_lines),
    ("logging", &[], target::logging),
    ("pil", &[], pil::check),
    ("c", &["c-compiler"], c::checks),
    ("frameworks", &[], frameworks::checks),
    ("newcomer", &["c-compiler", "make", "cmake"], newcomer::checks),
    ("boards", &[], target::other_boards),
];

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Stages, instead of all; `quick` is format, lints and unit tests.
    #[arg(value_parser = PossibleValuesParser::new(
        ["quick"].into_iter().chain(HOST.map(|stage| stage.0)).chain(TARGET.map(|stage| stage.0)),
    ))]
    pub stages: Vec<String>,
    /// Ends with rows for the run beside which it goes, instead of the table.
    #[arg(long, hide = true)]
    pub beside: bool,
}

/// Runs the stages, prints the table and the count; whether nothing failed. What cannot be set up is an error before
/// the first stage. A failing stage does not keep later ones from running. The stages of the target run beside those of
/// the host, since the emulator and many builds use one processor.
pub fn run(options: &Options, asked: Option<Way>) -> Result<bool> {
    let wanted = |(name, ..): &Stage| {
        let is_named = |wanted: &str| options.stages.iter().any(|own| own == wanted);
        // The unit tests are among those of `host`.
        options.stages.is_empty() && *name != "units" || is_named(name) || is_named("quick") && QUICK.contains(name)
    };
    let [host, target] = [&HOST[..], &TARGET].map(|all| all.iter().copied().filter(wanted).collect::<Vec<Stage>>());
    let mut stages = Stages::default();
    let way = stages.stage("set-up", |tally| set_up(tally, &host, &target, asked))?;
    if options.beside {
        stages = Stages::default();
    }
    if options.beside || host.iter().any(|stage| stage.0 == "host") {
        cargo::tests_are_built();
    }
    let beside = !host.is_empty() && !target.is_empty();
    let started = beside.then(|| start(way, &target));
    for (name, _, checks) in host.iter().chain(target.iter().filter(|_| !beside)) {
        stages.stage(name, |tally| checks(tally, way));
    }
    if let Some(Err(error)) = started.map(|started| end(started?, &mut stages)) {
        stages.stage("target", |tally| tally.check("stages", Err::<&str, _>(error)));
    }
    if options.beside {
        print!("{}", stages.rows());
        return Ok(stages.passed());
    }
    Ok(stages.end())
}

/// Makes ready what the stages need; the way to build firmware.
fn set_up(tally: &mut Tally, host: &[Stage], target: &[Stage], asked: Option<Way>) -> Result<Way> {
    let needs: Vec<&str> = host.iter().chain(target).flat_map(|stage| stage.1.iter().copied()).collect();
    let mut way = Way::Rustup;
    if !target.is_empty() {
        way = Way::ready(asked)?;
        tally.check("firmware", Ok(format!("the {way} way")));
    }
    setup::ensure(&needs)?;
    Ok(way)
}

/// Starts a run of these stages in a process of its own; it prints to a file, since lines of two at once are hard to
/// read.
fn start(way: Way, stages: &[Stage]) -> Result<(Started, PathBuf)> {
    let path = workspace::target_dir().join("target-stages.log");
    // One file for both streams, at one place in it.
    let printed = File::create(&path).with_context(|| path.display().to_string())?;
    let errors = printed.try_clone()?;
    println!("\nThe stages of the target run beside those of the host; they print to {}", path.display());
    let mut command = Command::new(env::current_exe().context("where is this program?")?);
    command.args(["--way", &way.to_string(), "test", "--beside"]).args(stages.iter().map(|stage| stage.0));
    Ok((child::start(command.stdin(Stdio::null()).stdout(printed).stderr(errors))?, path))
}

/// Waits for its end, shows what it printed, and adds its stages.
fn end((mut started, path): (Started, PathBuf), stages: &mut Stages) -> Result<()> {
    let status = started.0.wait()?;
    let mut rows = 0;
    child::split(File::open(path)?, |line| {
        if stages.take_row(line) {
            rows += 1;
        } else {
            println!("{line}");
        }
    })?;
    ensure!(rows > 0, "the stages of the target ended early ({status})");
    Ok(())
}
