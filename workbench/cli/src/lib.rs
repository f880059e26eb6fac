//! The program `bearing-watch`: files and options enter, models, pages and tables leave.
//!
//! Each command is a module that reads its arguments, calls one of the crates below, and writes what it returns. On bad
//! input a command prints one line with file, place and remedy, writes no file, and returns exit code 2.
//!
//! | crate | commands |
//! |---|---|
//! | `bearing-watch-model` | `identify`, `structure`, `validate`, `grey-box` |
//! | `bearing-watch-model` | `train`, `evaluate` |
//! | `bearing-watch-traces` | `init`, `audit`, `convert`, and the files that the others read |
//! | `bearing-watch-fleet` | `features`, `train-features` |
//! | `bearing-watch-pages` | `view`, `replay`, `listen`, and the pages that the others write |
//! | `bearing-watch-studies` | `simulate`; its own program has the studies |

mod command_line;
mod commands;
mod drive;
mod identification;
mod recordings;
mod schema;
mod server;
mod training;
#[doc(hidden)]
pub mod untrusted;
mod view;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{ArgAction, CommandFactory as _, FromArgMatches as _, Parser};

use command_line::failure::{self, Failure};
use command_line::{arguments, help, output};
use commands::Command;
use model::Error;

/// Bearing-fault detection for motor drives: simulate, identify, train, evaluate, export to firmware
#[derive(Debug, Parser)]
#[command(name = "bearing-watch", version, max_term_width = 110, disable_help_flag = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

/// The options of every command.
#[derive(Debug, clap::Args)]
struct Common {
    /// Also write the settings of this command as a drive file, which takes their place next time; of train, with
    /// what it has chosen
    #[arg(long, global = true, value_name = "DRIVE_TOML")]
    save: Option<PathBuf>,
    /// Leave out the drive.toml of the current folder, which is taken if no drive file is given
    #[arg(long, global = true)]
    no_drive: bool,
    /// Print no progress, notes and warnings
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Also print the files that are read, and choices with reasons
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Print this help; --help prints all options
    #[arg(short, long, global = true, action = ArgAction::Help)]
    help: Option<bool>,
}

/// Runs the command line of this process. Returns 0 on success; on bad input it prints one line with the problem and
/// its place, and returns 2.
#[must_use]
pub fn run() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().collect();
    let as_json = failure::wants_json(&words);
    execute(words).unwrap_or_else(|failure| failure.print(as_json))
}

/// The commands with their help.
fn described() -> clap::Command {
    help::of_program(Cli::command())
}

fn execute(words: Vec<OsString>) -> Result<ExitCode, Failure> {
    let commands = described();
    let given = arguments::split(&commands, words)?;
    let commands = if given.drive.is_some() { arguments::relaxed(commands, &given.words) } else { commands };
    let matches = commands.try_get_matches_from(given.words)?;
    let Cli { mut command, common } = Cli::from_arg_matches(&matches)?;
    output::set_verbosity(common.quiet, common.verbose);
    if given.found {
        output::note("drive file: drive.toml of this folder; --no-drive leaves it out");
    }
    command.join(given.drive.as_ref())?;
    if let Some(path) = common.save {
        keep(&mut command, &path)?;
    }
    Ok(command.run(described)?)
}

/// Writes the settings of a command as a drive file; a training writes them again with what it chooses.
fn keep(command: &mut Command, path: &Path) -> Result<(), Error> {
    output::plan(&[path], &[])?;
    output::write(path, command.text(path)?)?;
    if let Command::Train(args) = command {
        args.save = Some(path.to_path_buf());
    }
    Ok(())
}
