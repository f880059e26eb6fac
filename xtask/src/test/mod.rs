//! `cargo xtask test`: every check of the repository, in one run with one count.

mod c;
mod dependencies;
mod frameworks;
mod host;
mod pil;
mod requirements;
mod target;

pub mod newcomer;

use std::env;
use std::fs::File;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use clap::ValueEnum;

use crate::cargo::{self, cargo};
use crate::child::{self, Started};
use crate::firmware::way::Way;
use crate::report::{Stages, Tally};
use crate::setup::{self, Need};
use crate::workspace;

pub use c::{compared, measure as measure_c};
pub use pil::{Model, run as run_pil};
pub use target::verdicts;

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Stages, instead of all.
    #[arg(value_enum)]
    stages: Vec<Stage>,
    /// Ends with rows for the run beside which it goes, instead of the table.
    #[arg(long, hide = true)]
    beside: bool,
}

impl Options {
    /// One stage.
    pub fn of(stage: Stage) -> Self {
        Self { stages: vec![stage], beside: false }
    }
}

/// A part of the run. Those of the host come first, in the order in which they use what others have built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Stage {
    /// Format, lints, and unit tests: minutes.
    Quick,
    /// Source is formatted.
    Format,
    /// Clippy finds nothing.
    Lints,
    /// Requirements have tests, and every `unsafe` is listed.
    Trace,
    /// The documentation of the crates builds, and the book.
    Documentation,
    /// The unit tests of all crates, which are among those of `host`.
    Units,
    /// Tests on this machine.
    Host,
    /// The Python package.
    Python,
    /// Licences, sources and advisories of the dependencies.
    Dependencies,
    /// All examples build for the drive's chip.
    Firmware,
    /// Nothing in the core can panic.
    NoPanic,
    /// Instructions, bytes and stack are within their bounds.
    Bounds,
    /// The emulated chip prints the host's lines.
    Twins,
    /// What firmware logs.
    Logging,
    /// Processor in the loop.
    Pil,
    /// The C library.
    C,
    /// The drive under other frameworks.
    Frameworks,
    /// The documents' ways into firmware.
    Newcomer,
    /// Other chips.
    Boards,
}

impl Stage {
    fn is_of_host(self) -> bool {
        self < Self::Firmware
    }

    fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// What it needs besides a way to build firmware.
    fn needs(self) -> Vec<&'static Need> {
        match self {
            Self::Host => vec![&setup::BROWSER],
            Self::Documentation | Self::Python | Self::Dependencies => vec![&setup::PYTHON, &setup::PIP],
            Self::C => vec![&setup::C_COMPILER],
            Self::Newcomer => vec![&setup::C_COMPILER, &setup::MAKE, &setup::CMAKE],
            _ => Vec::new(),
        }
    }

    fn checks(self, tally: &mut Tally, way: Way) {
        match self {
            Self::Quick => {}
            Self::Format => host::format(tally),
            Self::Lints => host::lints(tally),
            Self::Trace => requirements::checks(tally),
            Self::Documentation => host::documentation(tally),
            Self::Units => host::tests(tally, &["--lib"]),
            Self::Host => host::tests(tally, &[cargo::TESTS, "--doc"]),
            Self::Python => host::python(tally),
            Self::Dependencies => dependencies::checks(tally),
            Self::Firmware => target::builds(tally, way),
            Self::NoPanic => target::no_panic(tally, way),
            Self::Bounds => target::bounds(tally, way),
            Self::Twins => target::same_lines(tally, way),
            Self::Logging => target::logging(tally, way),
            Self::Pil => pil::check(tally, way),
            Self::C => c::checks(tally, way),
            Self::Frameworks => frameworks::checks(tally, way),
            Self::Newcomer => newcomer::checks(tally, way),
            Self::Boards => target::other_boards(tally, way),
        }
    }
}

/// Licences, sources and advisories of the dependencies, for a release.
pub fn dependencies(tally: &mut Tally) {
    dependencies::checks(tally);
}

/// Runs the stages, prints the table and the count; whether nothing failed. What cannot be set up is an error before
/// the first stage. A failing stage does not keep later ones from running. The stages of the target run beside those of
/// the host, since the emulator and many builds use one processor.
pub fn run(options: &Options, asked: Option<Way>) -> Result<bool> {
    let all = Stage::value_variants().iter().filter(|stage| ![Stage::Quick, Stage::Units].contains(stage));
    let mut chosen: Vec<Stage> = options.stages.clone();
    if chosen.is_empty() {
        chosen.extend(all);
    }
    if chosen.contains(&Stage::Quick) {
        chosen.extend([Stage::Format, Stage::Lints, Stage::Units]);
        chosen.retain(|stage| *stage != Stage::Quick);
    }
    chosen.sort_unstable();
    chosen.dedup();
    let mut stages = Stages::default();
    let way = stages.stage("set-up", |tally| set_up(tally, &chosen, asked))?;
    if options.beside {
        stages = Stages::default();
    }
    if options.beside || chosen.contains(&Stage::Host) {
        cargo::tests_are_built();
    }
    let (host, target): (Vec<Stage>, Vec<Stage>) = chosen.iter().partition(|stage| stage.is_of_host());
    let beside = !host.is_empty() && !target.is_empty();
    let started = beside.then(|| start(way, &target));
    for stage in if beside { host } else { chosen } {
        stages.stage(&stage.name(), |tally| stage.checks(tally, way));
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
fn set_up(tally: &mut Tally, stages: &[Stage], asked: Option<Way>) -> Result<Way> {
    for (stage, command, component) in [(Stage::Format, "fmt", "rustfmt"), (Stage::Lints, "clippy", "clippy")] {
        let works = !stages.contains(&stage) || child::works(&mut cargo(&[command, "--version"]));
        ensure!(works, "{component} is not installed; run\n    rustup component add {component}");
    }
    let mut needs: Vec<&Need> = stages.iter().flat_map(|stage| stage.needs()).collect();
    let mut way = Way::Rustup;
    if stages.iter().any(|stage| !stage.is_of_host()) {
        way = Way::choose(asked)?;
        needs.extend(way.needs()?);
        tally.check("firmware", Ok(format!("the {way} way")));
    }
    setup::ensure(&needs)?;
    tally.check("programs", Ok(""));
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
    command.args(["--way", &way.to_string(), "test", "--beside"]).args(stages.iter().map(|stage| stage.name()));
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
