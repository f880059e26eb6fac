//! The options of every command.

use std::path::PathBuf;

use clap::ArgAction;

/// The options of every command.
#[derive(Debug, clap::Args)]
pub(super) struct Common {
    /// Also write the settings of this command as a drive file, which takes their place next time; of train, with
    /// what it has chosen
    #[arg(long, global = true, value_name = "DRIVE_TOML")]
    pub(super) save: Option<PathBuf>,
    /// Leave out the drive.toml of the current folder, which is taken if no drive file is given
    #[arg(long, global = true)]
    pub(super) no_drive: bool,
    /// Print no progress, notes and warnings
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(super) quiet: bool,
    /// Also print the files that are read, and choices with reasons
    #[arg(short, long, global = true)]
    pub(super) verbose: bool,
    /// Print this help; --help prints all options
    #[arg(short, long, global = true, action = ArgAction::Help)]
    help: Option<bool>,
}
