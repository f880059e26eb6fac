//! `cargo xtask test`: every check of the repository, in one run with one count.

use std::env;
use std::process::Command;

use anyhow::{Result, bail, ensure};
use clap::ValueEnum;

use crate::beside::Beside;
use crate::reports::Libtest;
use crate::setup::{self, Need};
use crate::stages::Stages;
use crate::tally::Tally;
use crate::toolchain::{self, Way};
use crate::{book, c_library, child, dependencies, frameworks, newcomer, pil, python, target, times, trace, workspace};

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

/// A part of the run. Those of the host come first, in the order in which they use what others have built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Stage {
    /// The first `cargo demo` takes no more than its bound.
    Demo,
    /// Source is formatted.
    Format,
    /// Clippy finds nothing.
    Lints,
    /// Requirements have tests, and every `unsafe` is listed.
    Trace,
    /// The documentation of the crates builds.
    Documentation,
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

    /// Its name in the table.
    fn title(self) -> &'static str {
        match self {
            Self::Demo => "demo",
            Self::Format => "format",
            Self::Lints => "lints",
            Self::Trace => "requirements",
            Self::Documentation => "documentation",
            Self::Host => "host tests",
            Self::Python => "Python",
            Self::Dependencies => "dependencies",
            Self::Firmware => "firmware builds",
            Self::NoPanic => "no panic",
            Self::Bounds => "instructions, stack",
            Self::Twins => "host = target",
            Self::Logging => "logging",
            Self::Pil => "processor in the loop",
            Self::C => "C library",
            Self::Frameworks => "frameworks",
            Self::Newcomer => "newcomer",
            Self::Boards => "other boards",
        }
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
            Self::Demo => times::checks(tally),
            Self::Format => format(tally),
            Self::Lints => lints(tally),
            Self::Trace => trace::checks(tally),
            Self::Documentation => documentation(tally),
            Self::Host => host_tests(tally),
            Self::Python => python::checks(tally),
            Self::Dependencies => dependencies::checks(tally),
            Self::Firmware => target::builds(tally, way),
            Self::NoPanic => target::no_panic(tally, way),
            Self::Bounds => target::bounds(tally, way),
            Self::Twins => target::same_lines(tally, way),
            Self::Logging => target::logging(tally, way),
            Self::Pil => pil::check(tally, way),
            Self::C => c_library::checks(tally, way),
            Self::Frameworks => frameworks::checks(tally, way),
            Self::Newcomer => newcomer::checks(tally, way),
            Self::Boards => target::other_boards(tally, way),
        }
    }
}

/// Runs the stages, prints the table and the count; whether nothing failed. What cannot be set up is an error before
/// the first stage. A failing stage does not keep later ones from running. The stages of the target run beside those of
/// the host, since the emulator and many builds use one processor.
pub fn run(options: &Options, asked: Option<Way>) -> Result<bool> {
    let chosen = if options.stages.is_empty() { Stage::value_variants() } else { &options.stages };
    let (mut host, target): (Vec<Stage>, Vec<Stage>) = chosen.iter().partition(|stage| stage.is_of_host());
    host.sort_unstable();
    let first = host.iter().take_while(|stage| **stage == Stage::Demo).count();
    let mut stages = Stages::default();
    let way = stages.stage("set-up", |tally| set_up(tally, chosen, asked))?;
    if options.beside {
        workspace::tests_are_beside();
        stages = Stages::default();
    }
    // Alone: nothing else may build what it measures.
    for stage in host.drain(..first) {
        stages.stage(stage.title(), |tally| stage.checks(tally, way));
    }
    let beside = (!host.is_empty() && !target.is_empty()).then(|| Beside::start(way, &target));
    let here = if beside.is_some() { host } else { [host, target].concat() };
    for stage in here {
        stages.stage(stage.title(), |tally| stage.checks(tally, way));
    }
    if let Some(beside) = beside {
        beside.end(&mut stages);
    }
    if options.beside {
        print!("{}", stages.rows());
        return Ok(stages.total().failed == 0);
    }
    Ok(stages.end())
}

/// Makes ready what the stages need; the way to build firmware.
fn set_up(tally: &mut Tally, stages: &[Stage], asked: Option<Way>) -> Result<Way> {
    for (stage, command, component) in [(Stage::Format, "fmt", "rustfmt"), (Stage::Lints, "clippy", "clippy")] {
        let works = || child::works(&mut workspace::cargo(&[command, "--version"]));
        ensure!(
            !stages.contains(&stage) || works(),
            "{component} is not installed; run\n    rustup component add {component}"
        );
    }
    let mut needs: Vec<&Need> = stages.iter().flat_map(|stage| stage.needs()).collect();
    let mut way = Way::Rustup;
    if stages.iter().any(|stage| !stage.is_of_host()) {
        way = toolchain::choose(asked)?;
        needs.extend(setup::firmware(way)?);
        tally.check::<_, &str>("firmware", Ok(format!("the {way} way")));
    }
    setup::ensure(&needs)?;
    tally.check::<_, &str>("programs", Ok(""));
    Ok(way)
}

fn format(tally: &mut Tally) {
    for manifest in ["Cargo.toml", "frameworks/Cargo.toml", "template/Cargo.toml"] {
        let mut cargo = workspace::cargo(&["fmt", "--all", "--check", "--manifest-path", manifest]);
        tally.check(&format!("cargo fmt, {manifest}"), silent(&mut cargo));
    }
}

fn lints(tally: &mut Tally) {
    let mut cargo = workspace::cargo(&["clippy", "--workspace", "--all-targets", "--all-features"]);
    cargo.args(["--", "--deny", "warnings"]);
    tally.check("cargo clippy", silent(&mut cargo));
}

fn documentation(tally: &mut Tally) {
    // With the features of the lints, whose metadata of dependencies it uses again.
    let mut cargo = workspace::cargo(&["doc", "--workspace", "--no-deps", "--all-features"]);
    let flags = env::var("RUSTDOCFLAGS").unwrap_or_default();
    cargo.env("RUSTDOCFLAGS", format!("{flags} -Dwarnings"));
    tally.check("cargo doc", silent(&mut cargo));
    // Includes and links are tests of this crate; mdBook only draws them.
    tally.check("mdbook", target::brief(book::build().map(|_| "")));
}

/// With overflow and debug checks on; the development profile is optimised, since the numeric tests simulate minutes
/// of drive time. Documentation examples are among the tests. What passing tests print is shown: their figures, and
/// which data they had to do without.
fn host_tests(tally: &mut Tally) {
    // Without the examples, which have no tests: clippy has read them, and those that are needed are built later.
    for kind in [workspace::TESTS, "--doc"] {
        let mut cargo = workspace::cargo(&["test", "--workspace", kind, "--no-fail-fast", "--", "--show-output"]);
        let (before, mut report) = (tally.failed, Libtest::default());
        let status = child::lines(&mut cargo, |line| {
            println!("{line}");
            report.read(line, tally);
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

/// Success without a word of praise, since the program has printed its own.
fn silent(command: &mut Command) -> Result<&'static str> {
    let status = child::lines(command, |line| println!("{line}"))?;
    if !status.success() {
        bail!("{status}");
    }
    Ok("")
}
