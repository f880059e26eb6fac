//! `cargo attack fuzz | mutants`: what attacks the project's inputs, and its tests.

mod fuzz;
mod mutants;

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, ensure};
use clap::Parser;

/// Attacks on inputs, by random bytes, and on tests, by mistakes in the source.
#[derive(Parser, Debug)]
#[command(name = "cargo attack", bin_name = "cargo attack")]
enum Attack {
    /// Attacks every door with any bytes, guided by coverage, and prints a table; what a door must hold is in
    /// docs/trust.md.
    Fuzz(fuzz::Options),
    /// Makes the changes of `attack/mutants` in a copy of the tree, one after the other, and tells which of them the
    /// room's own tests do not notice.
    Mutants(mutants::Options),
}

fn main() -> ExitCode {
    let outcome = match Attack::parse() {
        Attack::Fuzz(options) => fuzz::run(&options),
        Attack::Mutants(options) => mutants::run(&options),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The workspace's root.
fn root() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).unwrap_or(own).to_path_buf()
}

/// Cargo's target directory.
fn target_dir() -> Result<PathBuf> {
    let named = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    Ok(std::path::absolute(named)?)
}

/// The cargo that started this program.
fn cargo(arguments: &[&str], folder: &Path) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(folder);
    command
}

/// What a program prints; fails unless it succeeds.
fn printed(command: &mut Command) -> Result<String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.stderr(std::process::Stdio::inherit()).output().with_context(|| program.clone())?;
    ensure!(output.status.success(), "{program} failed ({})", output.status);
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
