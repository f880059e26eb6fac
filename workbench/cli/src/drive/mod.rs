//! `drive.toml`: what a drive is, said once. Its keys stand for options; those on the command line go first.
//!
//! ```text
//! bearing-watch train drive.toml --model m.bwm
//! [data]      traces = ["runs"]  labels = "labels.csv"       files, relative to this one
//! [channels]  y = "iq_A"  u1 = "speed_ref_rpm-speed_rpm"     as --y, --u1
//! [model]     order = [2, 2, 0, 1, 1]                        as --order 2,2,0,1,1
//! ```

mod expand;
mod guess;
pub(super) mod init;
mod names;
mod proposal;
mod schema;

pub(super) use guess::{Guess, is_reference};
pub use schema::Value;

use std::cell::RefCell;
use std::ffi::OsString;
use std::path::Path;

use clap::ArgMatches;

use model::Error;

thread_local! {
    /// The text of the file that the command of this thread was given.
    static GIVEN: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Returns the arguments with those of the drive file that follows the command, if one does.
pub(super) fn arguments(command: &clap::Command, given: Vec<OsString>) -> Result<Vec<OsString>, Error> {
    let Some(at) = expand::place(command, &given) else { return Ok(given) };
    let path = Path::new(&given[at]).to_path_buf();
    let text = std::fs::read_to_string(&path).map_err(Error::io(&path))?;
    let entries = schema::entries(&path, &text)?;
    let rest: Vec<OsString> = given[..at].iter().chain(&given[at + 1..]).cloned().collect();
    let arguments = expand::with_entries(command, rest, &path, &entries)?;
    GIVEN.set(Some(text));
    Ok(arguments)
}

/// Returns the arguments of a command without subcommands: these options, and those of the drive file that they do not
/// have.
pub(super) fn of_options(
    command: &clap::Command,
    options: &[(String, Value)],
    path: Option<&Path>,
) -> Result<Vec<OsString>, Error> {
    GIVEN.set(None);
    let given = expand::of_options(command, options)?;
    let Some(path) = path else { return Ok(given) };
    let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
    let arguments = expand::with_entries(command, given, path, &schema::entries(path, &text)?)?;
    GIVEN.set(Some(text));
    Ok(arguments)
}

/// The text of the drive file that the command was given, if it was.
pub(super) fn given() -> Option<String> {
    GIVEN.with_borrow(Clone::clone)
}

/// Adds the drive file of the command to a page.
pub(super) fn on_page(page: String) -> String {
    let Some(text) = given() else { return page };
    let section = format!("<section><h2>Drive file</h2><pre>{}</pre></section>\n</main>", pages::escape::escape(&text));
    page.replacen("</main>", &section, 1)
}

/// Writes the options of this command line that a drive file can have.
pub(super) fn save(path: &Path, command: &clap::Command, matches: &ArgMatches) -> Result<(), Error> {
    super::output::plan(&[path], &[])?;
    super::output::write(path, expand::text(path, command, matches))
}
