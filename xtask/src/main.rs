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
mod web;
mod workspace;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use cost::measure;
use firmware::board::DRIVE;
use firmware::way::Way;
use firmware::{build, qemu};

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
    /// The stage `c`, and what the C library takes.
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
    /// Counts the kernels' instructions and bytes on the emulated chip.
    Measure {
        /// A JSON list instead of a table.
        #[arg(long)]
        json: bool,
    },
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
    /// Writes the workbench as one page for a browser, `target/web/bearing-watch.html`, which needs no installation.
    Web {
        /// Prints how long the training takes beside the native program on one thread.
        #[arg(long)]
        measure: bool,
    },
    /// Makes everything that is published, in `target/dist`, and checks it; publishes nothing.
    Release(release::Options),
    /// Fetches what firmware builds, emulator runs and tests of pages need and the system does not have, into the
    /// target directory; other commands fetch what they need themselves.
    Setup,
    /// A stage of `test` by its name alone: `frameworks`, `newcomer`, `python`, `trace` …
    #[command(external_subcommand)]
    Stage(Vec<String>),
}

fn main() -> ExitCode {
    let Arguments { way, command } = Arguments::parse();
    match run(command, way) {
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
    let ready = || Way::ready(asked);
    match command {
        Command::Test(options) => return test::run(&options, asked),
        Command::Long => println!("\n{}", cargo::measure_long()?.join("\n")),
        Command::Firmware { example } => {
            let elf = build::build(ready()?, DRIVE, &example)?;
            println!("{}", qemu::run(&elf, DRIVE)?.join("\n"));
        }
        Command::C => {
            let passed = test::run(&test::Options { stages: vec!["c".to_owned()], beside: false }, asked)?;
            return test::measure_c(ready()?).map(|()| passed);
        }
        Command::Pil { trace, model, rust } => {
            let [trace, model, rust] = [trace, model, rust].map(std::path::absolute);
            test::run_pil(ready()?, &trace?, &model?, &rust?)?;
        }
        Command::Measure { json } => {
            let figures = measure::figures(ready()?)?;
            print!("{}", if json { measure::json(&figures) + "\n" } else { measure::table(&figures) });
        }
        Command::Docs { names, check } => return docs::run(&names, check, asked),
        Command::Web { measure } => {
            let web::Built { program, page } = web::page(asked)?;
            println!("{}, {} bytes", page.display(), std::fs::metadata(&page)?.len());
            if measure {
                web::compare::measure(&program)?;
            }
        }
        Command::Book => println!("{}", python::book()?.display()),
        Command::Release(options) => return release::run(&options, ready()?),
        Command::Setup => {
            let way = ready()?;
            setup::ensure(&setup::ALL)?;
            println!("ready: firmware the {way} way, emulator, C compiler, browser, Python");
        }
        Command::Stage(words) => {
            let arguments = ["cargo xtask".to_owned(), "test".to_owned()].into_iter().chain(words);
            return run(Arguments::parse_from(arguments).command, asked);
        }
    }
    Ok(true)
}
