//! The program `bearing-watch`: files and options enter, models, pages and tables leave.
//!
//! Each command is a module that reads its arguments, calls one of the crates below, and writes what it returns. On bad
//! input a command prints one line with file, place and remedy, writes no file, and returns exit code 2.
//!
//! | crate | commands |
//! |---|---|
//! | `bearing-watch-model` | `identify`, `piecewise`, `structure`, `validate`, `grey-box` |
//! | `bearing-watch-model` | `audit`, `train`, `evaluate` |
//! | `bearing-watch-traces` | `convert`, `resample`, and the files that the others read |
//! | `bearing-watch-fleet` | `features`, `features-sum`, `train-features` |
//! | `bearing-watch-pages` | `view`, `replay`, `listen`, and the pages that the others write |
//! | `bearing-watch-studies` | `demo`, `simulate`, `simulate-features`, `campaign`, `tables` |

mod arguments;
mod audit;
mod campaign;
mod commands;
mod convert;
mod demo;
mod drive;
mod evaluate;
mod features;
mod features_sum;
mod fit;
mod grey_box;
mod identify;
mod jobs;
mod listen;
mod options;
mod output;
mod piecewise;
mod recordings;
mod replay;
mod schema;
mod serve;
mod simulate;
mod simulate_features;
mod simulated_fleet;
mod structure;
mod tables;
mod train;
mod train_features;
mod validate;
mod view;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory as _, FromArgMatches as _, Parser};

use commands::Command;
use model::Error;

/// Bearing-fault detection for motor drives: simulate, identify, train, evaluate, and export to firmware.
#[derive(Debug, Parser)]
#[command(name = "bearing-watch", version, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Also write the settings of this command as a drive file, which takes their place next time
    #[arg(long, global = true, value_name = "DRIVE_TOML")]
    save: Option<PathBuf>,
}

/// Runs the command line of this process. Returns 0 on success; on bad input it prints one line with the problem and
/// its place, and returns 2.
#[must_use]
pub fn run() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().collect();
    let commands = Cli::command();
    let (words, drive) = match arguments::split(&commands, words) {
        Ok(split) => split,
        Err(error) => return refuse(&error),
    };
    let commands =
        if drive.is_some() { arguments::relaxed(commands, words.get(1..).unwrap_or_default()) } else { commands };
    let parsed = commands.try_get_matches_from(words).and_then(|matches| Cli::from_arg_matches(&matches));
    let Cli { mut command, save } = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return usage(&error),
    };
    let joined = command.join(drive.as_ref()).and_then(|()| save.map_or(Ok(()), |path| keep(&mut command, &path)));
    match joined.and_then(|()| command.run()) {
        Ok(code) => code,
        Err(error) => refuse(&error),
    }
}

/// Writes the settings of a command as a drive file.
fn keep(command: &mut Command, path: &Path) -> Result<(), Error> {
    output::plan(&[path], &[])?;
    output::write(path, command.text(path)?)
}

fn refuse(error: &Error) -> ExitCode {
    eprintln!("error: {}", error.to_string().replace('\n', " "));
    ExitCode::from(2)
}

/// Prints help and version unchanged, and an error in the arguments as one line.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    eprintln!("{} (more by --help)", usage_line(error));
    ExitCode::from(2)
}

/// An error in the arguments as one line.
fn usage_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let said = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let said: Vec<&str> = said.filter(|line| !line.is_empty()).collect();
    // If the command is missing, clap returns the whole help instead of an error.
    if text.starts_with("error:") { said.join(" ") } else { "error: a command is missing".into() }
}
