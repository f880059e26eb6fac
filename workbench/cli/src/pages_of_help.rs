//! `bearing-watch completions` and `bearing-watch man`: what shells and `man` show of the commands.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Command;
use clap_complete::Shell;

use super::output;
use model::Error;

/// The name of the program.
const PROGRAM: &str = "bearing-watch";

/// Print completions of commands and options for a shell
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch completions bash > ~/.local/share/bash-completion/completions/bearing-watch"
)]
pub(super) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Print the manual page of the program, or write one page per command
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch man --out ~/.local/share/man/man1")]
pub(super) struct ManArgs {
    /// Folder for the pages bearing-watch.1, bearing-watch-train.1 and so on; created if absent
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(super) fn completions(args: &CompletionsArgs, mut commands: Command) -> Result<(), Error> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut commands, PROGRAM, &mut text);
    // In the script for bash, clap_complete 4.6 has two spellings of a program's name with a hyphen.
    let text = String::from_utf8_lossy(&text).replace("bearing__subcmd__watch", "bearing__watch");
    print(text.as_bytes())
}

pub(super) fn man(args: &ManArgs, commands: Command) -> Result<(), Error> {
    let Some(folder) = &args.out else {
        let mut text = Vec::new();
        clap_mangen::Man::new(commands).render(&mut text).map_err(Error::io("standard output"))?;
        return print(&text);
    };
    std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    clap_mangen::generate_to(commands, folder).map_err(Error::io(folder))?;
    output::say(format!("{}: manual pages; man -l {}", folder.display(), folder.join("bearing-watch.1").display()))
}

/// Prints bytes; a closed pipe is not an error.
fn print(text: &[u8]) -> Result<(), Error> {
    match std::io::stdout().write_all(text) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output")(error)),
        _ => Ok(()),
    }
}
