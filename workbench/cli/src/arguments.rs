//! The words of the command line: the drive file among them, and what it makes unnecessary.

use std::ffi::OsString;
use std::path::Path;

use clap::Command;

use model::Error;
use model::settings::{DriveFile, keys};

/// The place of a drive file: right after the command and its subcommand.
fn place(command: &Command, words: &[OsString]) -> Option<usize> {
    let (mut own, mut at) = (command, 1);
    while let Some(next) = words.get(at).and_then(|word| own.find_subcommand(word)) {
        (own, at) = (next, at + 1);
    }
    let is_file = |word: &&OsString| Path::new(word).extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    words.get(at).filter(is_file).filter(|_| at > 1 && own.get_name() != "init").map(|_| at)
}

/// The words without the drive file, and the drive file if there is one.
pub(super) fn split(command: &Command, mut words: Vec<OsString>) -> Result<(Vec<OsString>, Option<DriveFile>), Error> {
    let Some(at) = place(command, &words) else { return Ok((words, None)) };
    let drive = DriveFile::read(Path::new(&words.remove(at)))?;
    Ok((words, Some(drive)))
}

/// The commands; the one of these words does without the settings that a drive file can give.
pub(super) fn relaxed(command: Command, words: &[OsString]) -> Command {
    let next = words
        .split_first()
        .and_then(|(word, rest)| Some((command.find_subcommand(word)?.get_name().to_string(), rest)));
    if let Some((name, rest)) = next {
        return command.mut_subcommand(name, |own| relaxed(own, rest));
    }
    let required = |key: &&str| command.get_arguments().any(|arg| arg.get_id() == *key && arg.is_required_set());
    let taken: Vec<&str> = keys().map(|(_, key)| key).filter(required).collect();
    taken.into_iter().fold(command, |command, key| command.mut_arg(key, |arg| arg.required(false)))
}
