//! The words of the command line: the drive file among them, and what it makes unnecessary.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::Command;

use model::Error;
use model::settings::{DriveFile, keys};

/// The drive file that is taken from the current folder.
const USUAL: &str = "drive.toml";

/// The words of a command line, and its drive file.
#[derive(Debug)]
pub(crate) struct Words {
    /// The words without the drive file.
    pub(crate) words: Vec<OsString>,
    /// The drive file, if there is one.
    pub(crate) drive: Option<DriveFile>,
    /// Whether it is that of the current folder.
    pub(crate) found: bool,
}

/// Flags of every command, which may stand before a command and before a drive file.
fn is_flag(word: &OsStr) -> bool {
    ["-q", "--quiet", "-v", "--verbose", "--no-drive"].iter().any(|flag| word == *flag)
}

/// The command of the words with its subcommands, and the place of the word behind it.
fn chosen<'c>(command: &'c Command, words: &[OsString]) -> (Vec<&'c Command>, usize) {
    let (mut path, mut at) = (vec![command], 1);
    let behind_flags = |mut at: usize| {
        while words.get(at).is_some_and(|word| is_flag(word)) {
            at += 1;
        }
        at
    };
    loop {
        at = behind_flags(at);
        let next = path.last().zip(words.get(at)).and_then(|(command, word)| command.find_subcommand(word));
        let Some(next) = next else { return (path, at) };
        (path, at) = ([&path[..], &[next]].concat(), at + 1);
    }
}

/// Whether a command takes settings that a drive file can give; `init` writes one.
fn takes_drive(command: &Command) -> bool {
    command.get_name() != "init" && command.get_arguments().any(|arg| keys().any(|(_, key)| arg.get_id() == key))
}

/// Takes the drive file out of the words: the one right behind the command, or else the one of the current folder.
pub(crate) fn split(command: &Command, mut words: Vec<OsString>) -> Result<Words, Error> {
    let (path, at) = chosen(command, &words);
    let named = path[path.len() - 1];
    let is_file = |word: &OsString| Path::new(word).extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    if path.len() > 1 && named.get_name() != "init" && words.get(at).is_some_and(is_file) {
        let drive = DriveFile::read(Path::new(&words.remove(at)))?;
        return Ok(Words { words, drive: Some(drive), found: false });
    }
    let refuses = ["--no-drive", "-h", "--help"].iter().any(|flag| words.iter().any(|word| word == *flag));
    if refuses || !takes_drive(named) || !Path::new(USUAL).is_file() {
        return Ok(Words { words, drive: None, found: false });
    }
    let drive = DriveFile::read(Path::new(USUAL)).map_err(|error| {
        Error::Usage(format!("{error} (the file is taken from this folder; --no-drive leaves it out)"))
    })?;
    Ok(Words { words, drive: Some(drive), found: true })
}

/// The commands; the one of these words does without the settings that a drive file can give.
pub(crate) fn relaxed(command: Command, words: &[OsString]) -> Command {
    let (path, _) = chosen(&command, words);
    let names: Vec<String> = path.iter().skip(1).map(|own| own.get_name().to_string()).collect();
    without_required(command, &names)
}

fn without_required(command: Command, names: &[String]) -> Command {
    if let Some((name, rest)) = names.split_first() {
        return command.mut_subcommand(name, |own| without_required(own, rest));
    }
    let required = |key: &&str| command.get_arguments().any(|arg| arg.get_id() == *key && arg.is_required_set());
    let taken: Vec<&str> = keys().map(|(_, key)| key).filter(required).collect();
    taken.into_iter().fold(command, |command, key| command.mut_arg(key, |arg| arg.required(false)))
}
