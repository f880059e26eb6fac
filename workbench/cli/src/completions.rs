//! `bearing-watch completions`: what shells show of the commands.

use std::io::Write as _;

use clap::Command;
use clap_complete::Shell;

use model::Error;

/// The name of the program.
const PROGRAM: &str = "bearing-watch";

/// Print completions of commands and options for a shell
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch completions bash > ~/.local/share/bash-completion/completions/bearing-watch"
)]
pub(super) struct Args {
    /// The shell
    shell: Shell,
}

pub(super) fn run(args: &Args, mut commands: Command) -> Result<(), Error> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut commands, PROGRAM, &mut text);
    // In the script for bash, clap_complete 4.6 has two spellings of a program's name with a hyphen.
    let text = String::from_utf8_lossy(&text).replace("bearing__subcmd__watch", "bearing__watch");
    match std::io::stdout().write_all(text.as_bytes()) {
        // A closed pipe is not an error.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output")(error)),
        _ => Ok(()),
    }
}
