//! What the repository's own commands do: `cargo xtask --help` lists them.

mod cargo;
mod child;
mod cost;
mod docs;
mod firmware;
mod python;
mod release;
mod report;
mod setup;
mod test;
mod workspace;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use cost::measure;
use firmware::board::DRIVE;
use firmware::way::Way;
use firmware::{build, qemu};
use test::Stage;

/// Set-up, tests, firmware builds, emulator runs, instruction and size tables.
#[derive(Parser, Debug)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    /// How to build firmware; without it the environment variable `BEARING_WATCH_FIRMWARE` decides, and without that
    /// what is installed.
    #[arg(long, global = true, value_enum)]
    way: Option<Way>,

    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Every check of the repository: format, lints, documentation, host and target tests.
    Test(test::Options),
    /// The host tests that run for minutes, and their table.
    Long,
    /// Builds an example for the drive's chip and runs it in the emulator.
    Firmware {
        /// The example's name.
        #[arg(default_value = "monitor")]
        example: String,
    },
    /// Builds the C library and its examples for the drive's chip, as C and as C++, runs them in the emulator, compares
    /// their lines with those of the Rust examples on the host, and prints what the library takes.
    C,
    /// Processor in the loop: runs a recording of raw counts through the whole drive in the emulator (the example
    /// `drive`), compares every report with the host's, and counts the instructions of the interrupt.
    Pil {
        /// The recording, a CSV file at the control rate.
        trace: PathBuf,
        /// The binary model, trained with `--front-end`.
        #[arg(long)]
        model: PathBuf,
        /// The source that `train --rust` wrote with it.
        #[arg(long)]
        rust: PathBuf,
    },
    /// The stage of the same name: the drive monitor under RTIC and embassy, and beside another crate's current loop.
    Frameworks,
    /// The stage of the same name: the documents' way into firmware, in empty projects and in the template.
    Newcomer,
    /// Counts the kernels' instructions and bytes on the emulated chip.
    Measure {
        /// A JSON list instead of a table.
        #[arg(long)]
        json: bool,
    },
    /// The stage of the same name: builds the Python package, installs it and runs its tests.
    Python,
    /// The stage of the same name: requirements have tests, and every `unsafe` is listed.
    Trace,
    /// Writes the figures that README, book and docs quote: those of commands that take seconds, or those named.
    Docs {
        /// Blocks of documents, for example `target`, `campaign`, `tables`.
        names: Vec<String>,
        /// Compares instead of writing; fails with the file and a short difference.
        #[arg(long)]
        check: bool,
    },
    /// Builds the book by mdBook.
    Book,
    /// Makes everything that is published, in `target/dist`, and checks it; publishes nothing.
    Release(release::Options),
    /// Fetches what firmware builds, emulator runs and tests of pages need and the system does not have, into the
    /// target directory; other commands fetch what they need themselves.
    Setup,
}

fn main() -> ExitCode {
    let Arguments { way, command } = Arguments::parse();
    let outcome = child::end_by_signal().and_then(|()| run(command, way));
    child::settle();
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Whether everything that was asked for succeeded.
fn run(command: Command, asked: Option<Way>) -> Result<bool> {
    let ready = || {
        let way = Way::choose(asked)?;
        setup::ensure(&way.needs()?).map(|()| way)
    };
    let stage = |stage| test::run(&test::Options::of(stage), asked);
    match command {
        Command::Test(options) => return test::run(&options, asked),
        Command::Long => println!("\n{}", cargo::measure_long()?.join("\n")),
        Command::Firmware { example } => {
            let elf = build::build(ready()?, DRIVE, &example)?;
            println!("{}", qemu::run(&elf, DRIVE)?.join("\n"));
        }
        Command::C => {
            let passed = stage(Stage::C)?;
            test::measure_c(ready()?)?;
            return Ok(passed);
        }
        Command::Pil { trace, model, rust } => {
            let [trace, binary, source] = [trace, model, rust].map(std::path::absolute);
            test::run_pil(ready()?, &trace?, &test::Model { binary: binary?, source: Some(source?) })?;
        }
        Command::Frameworks => return stage(Stage::Frameworks),
        Command::Newcomer => return stage(Stage::Newcomer),
        Command::Measure { json } => {
            let figures = measure::figures(ready()?)?;
            print!("{}", if json { measure::json(&figures) + "\n" } else { measure::table(&figures) });
        }
        Command::Python => return stage(Stage::Python),
        Command::Trace => return stage(Stage::Trace),
        Command::Docs { names, check } => return docs::run(&names, check, asked),
        Command::Book => println!("{}", python::book()?.display()),
        Command::Release(options) => return release::run(&options, ready()?),
        Command::Setup => {
            let way = ready()?;
            setup::ensure(&setup::ALL)?;
            println!("ready: firmware the {way} way, emulator, C compiler, browser, Python");
        }
    }
    Ok(true)
}
