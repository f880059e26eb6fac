//! What the repository's own commands do: `cargo xtask test | long | firmware | c | pil | frameworks | newcomer |
//! measure | peers | python | fuzz | trace | coverage | mutants | docs | book | times | release | setup`.

mod beside;
mod board;
mod book;
mod bounds;
mod c_library;
mod c_link;
mod c_symbols;
mod child;
#[cfg(test)]
mod circles;
mod closed_loop;
mod coverage;
mod cycles;
mod dependencies;
mod docs;
#[cfg(test)]
mod doctests;
mod elf;
mod field_peers;
mod firmware;
mod frameworks;
mod fuzz;
#[cfg(test)]
mod links;
mod log;
mod long;
mod measure;
mod mutants;
mod newcomer;
mod on_board;
mod peers;
mod pil;
mod processes;
mod public;
mod python;
mod qemu;
mod release;
mod reports;
mod rivals;
mod setup;
mod size_profile;
mod stages;
mod tally;
mod target;
mod test;
mod times;
mod toolchain;
mod tools;
mod trace;
mod workspace;

use std::env;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use board::DRIVE;
use toolchain::Way;

/// Set-up, tests, firmware builds, emulator runs, instruction and size tables.
#[derive(Parser, Debug)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    /// How to build firmware; without it the environment variable `BEARING_WATCH_FIRMWARE` decides,
    /// and without that what is installed.
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
    /// Builds the C library and its examples for the drive's chip, as C and as C++, runs them in the emulator, and
    /// compares their lines with those of the Rust examples on the host.
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
    /// Builds the drive monitor under RTIC and embassy, runs both in the emulator on a simulated recording, and
    /// compares every line with the host's.
    Frameworks,
    /// Follows the documents into firmware, in an empty crate, in a copy of the template and in an empty C project, and
    /// compares the verdicts in the emulator with the host's.
    Newcomer,
    /// Counts the kernels' instructions and bytes on the emulated chip.
    Measure {
        /// A JSON list instead of a table.
        #[arg(long, conflicts_with = "peers")]
        json: bool,
        /// Instead, the core's kernels beside those of CMSIS-DSP, nalgebra, oxictl and C by hand on the same data.
        #[arg(long)]
        peers: bool,
    },
    /// Times the workbench and other identification programs on the same traces, and compares the table of the field
    /// with that of a plain program; installs them in a virtual environment.
    Peers,
    /// Builds the Python package, installs it in a virtual environment of the target directory, and runs its tests.
    Python,
    /// Attacks every door with any bytes, guided by coverage, and prints a table; what a door must hold is in
    /// docs/trust.md.
    Fuzz(fuzz::Options),
    /// Checks that each requirement of docs/requirements.toml has tests that exist, that book/src/faults.md names such
    /// tests only, and that it lists every `unsafe`.
    Trace,
    /// Prints which lines and regions of the core its tests reach.
    Coverage(coverage::Options),
    /// Makes the changes of `attack/mutants` in a copy of the tree, one after the other, and tells which of them the
    /// room's own tests do not notice.
    Mutants(mutants::Options),
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
    /// Builds what `cargo demo` builds in an empty target directory and prints the times of its crates.
    Times(times::Options),
    /// Makes everything that is published, in `target/dist`, and checks it; publishes nothing.
    Release(release::Options),
    /// Fetches what firmware builds, emulator runs and tests of pages need and the system does not have, into the
    /// target directory; other commands fetch what they need themselves.
    Setup,
}

fn main() -> ExitCode {
    if let Some(file) = env::var_os(times::wrapper::VARIABLE) {
        return times::wrapper::run(Path::new(&file));
    }
    let outcome = processes::end_by_signal().and_then(|()| run(&Arguments::parse()));
    processes::settle();
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// What a command needs that builds firmware this way.
fn needs(command: &Command, way: Way) -> Result<Vec<&'static setup::Need>> {
    let mut needs = setup::firmware(way)?;
    match command {
        Command::C | Command::Measure { peers: true, .. } => needs.push(&setup::C_COMPILER),
        Command::Newcomer => needs.extend([&setup::C_COMPILER, &setup::MAKE, &setup::CMAKE]),
        Command::Setup => needs.extend(setup::ALL),
        _ => {}
    }
    Ok(needs)
}

/// Whether everything that was asked for succeeded.
fn run(arguments: &Arguments) -> Result<bool> {
    if let Command::Test(options) = &arguments.command {
        return test::run(options, arguments.way);
    }
    if let Command::Times(options) = &arguments.command {
        return times::run(options).map(|()| true);
    }
    if matches!(arguments.command, Command::Peers) {
        return peers::run();
    }
    if matches!(arguments.command, Command::Python) {
        return Ok(python::run());
    }
    if matches!(arguments.command, Command::Long) {
        return long::run();
    }
    if matches!(arguments.command, Command::Book) {
        println!("{}", book::build()?.display());
        return Ok(true);
    }
    if let Command::Docs { names, check } = &arguments.command {
        return docs::run(names, *check, arguments.way);
    }
    if let Command::Fuzz(options) = &arguments.command {
        return fuzz::run(options);
    }
    if let Command::Mutants(options) = &arguments.command {
        return mutants::run(options);
    }
    if matches!(arguments.command, Command::Trace) {
        return trace::run();
    }
    if let Command::Coverage(options) = &arguments.command {
        return coverage::run(options);
    }
    let way = toolchain::choose(arguments.way)?;
    setup::ensure(&needs(&arguments.command, way)?)?;
    match &arguments.command {
        Command::Firmware { example } => {
            let elf = firmware::build(way, DRIVE, example)?;
            qemu::run(&elf, DRIVE.machine, qemu::Echo::On)?;
        }
        Command::C => return c_library::run(way),
        Command::Frameworks => return Ok(frameworks::run(way)),
        Command::Newcomer => return Ok(newcomer::run(way)),
        Command::Release(options) => return release::run(options, way),
        Command::Pil { trace, model, rust } => {
            let [trace, binary, source] = [trace, model, rust].map(std::path::absolute);
            pil::run(way, &trace?, &pil::Model { binary: binary?, source: Some(source?) })?;
        }
        Command::Measure { peers: true, .. } => print!("{}", rivals::table(way)?),
        Command::Measure { json, .. } => {
            let figures = measure::figures(way)?;
            if *json {
                println!("{}", measure::json(&figures));
            } else {
                print!("{}", measure::table(&figures));
            }
        }
        Command::Setup => {
            println!("ready: firmware the {way} way, emulator, C compiler, browser, Python");
        }
        Command::Test(_)
        | Command::Long
        | Command::Peers
        | Command::Python
        | Command::Fuzz(_)
        | Command::Mutants(_)
        | Command::Trace
        | Command::Coverage(_)
        | Command::Docs { .. }
        | Command::Book
        | Command::Times(_) => {}
    }
    Ok(true)
}
