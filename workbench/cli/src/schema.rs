//! `bearing-watch schema`

use super::output;
use model::Error;
use model::settings::schema::of_drive_file;

/// Print the JSON Schema of drive.toml: its keys with their meaning, for editors and other programs
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch schema > drive.schema.json\n\nAn editor with a language server for TOML \
takes it by a first line in drive.toml: #:schema ./drive.schema.json"
)]
pub(super) struct Args {}

pub(super) fn run(_: &Args) -> Result<(), Error> {
    output::json(&of_drive_file())
}
