//! Why a command fails: one line on standard error and, with `--json`, an object on standard output.

use std::ffi::OsString;
use std::process::ExitCode;

use serde_json::json;

use crate::command_line::output;
use model::{Error, visible};

/// Why nothing is done.
pub(crate) enum Failure {
    /// Help or version are printed instead.
    Shown(clap::Error),
    /// The words are no command.
    Words(clap::Error),
    /// The work fails.
    Work(Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Work(error)
    }
}

impl From<clap::Error> for Failure {
    fn from(error: clap::Error) -> Self {
        if error.use_stderr() { Self::Words(error) } else { Self::Shown(error) }
    }
}

/// Whether the words want JSON; they need not be a command.
pub(crate) fn wants_json(words: &[OsString]) -> bool {
    words.iter().take_while(|word| *word != "--").any(|word| word == "--json")
}

impl Failure {
    /// Prints it; returns 0 for help and version, and otherwise 2.
    pub(crate) fn print(&self, as_json: bool) -> ExitCode {
        let (kind, message) = match self {
            Self::Shown(help) => {
                // A closed pipe (`| head`) is not an error.
                let _printed = help.print();
                return ExitCode::SUCCESS;
            }
            Self::Words(error) => ("usage", format!("{} (more by --help)", line(error))),
            Self::Work(error) => (error.kind(), error.to_string().replace('\n', " ")),
        };
        eprintln!("error: {}", visible::line(&message));
        if as_json {
            let error = json!({ "kind": kind, "message": message });
            // Nothing is left to be done if this cannot be printed either.
            let _printed = output::json_line("error", json!({ "error": error }));
        }
        ExitCode::from(2)
    }
}

/// An error in the arguments as one line.
fn line(error: &clap::Error) -> String {
    let text = error.to_string();
    let said = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let said: Vec<&str> = said.filter(|line| !line.is_empty()).collect();
    // If the command is missing, clap returns the whole help instead of an error.
    said.join(" ").strip_prefix("error: ").map_or_else(|| "a command is missing".into(), String::from)
}
