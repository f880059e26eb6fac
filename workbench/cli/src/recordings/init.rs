//! `bearing-watch init`

use std::path::PathBuf;
use std::process::ExitCode;

use crate::command_line::jobs::Init;
use crate::command_line::options::Taken;
use crate::command_line::output;
use model::Error;
use traces::describe::{Asked, describe};

/// Write drive.toml: columns, rate, labels and likely channels, by looking at the files
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch init recordings\n  bearing-watch train recordings/drive.toml --model m.bwm"
)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) taken: Taken<Init>,
    /// Labels, if they are not the labels.csv beside the traces
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
    /// Where labels are written if there are none; by default labels.csv beside the drive file. The words of a file's
    /// name are its class, and words such as Lauf01 its run: unbalanced_run2_800.csv is unbalanced. Folders are classes
    /// and runs too, also such as class=healthy/run=3; if nothing tells classes, all files are called reference
    #[arg(long, value_name = "FILE", conflicts_with = "labels")]
    labels_from_names: Option<PathBuf>,
    /// The file; by default drive.toml in the folder of the first trace, or here if that cannot be written
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// The recordings are counts at the control rate: also write the file of the front end that makes current, velocity
    /// and angle of them, with the constants of sensors and motor that are found in them. By default front_end.toml
    /// beside the drive file
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "front_end.toml")]
    front_end: Option<PathBuf>,
    /// Replace the files if they exist
    #[arg(long)]
    force: bool,
    /// Print JSON: columns with unit and course, classes, questions with their answers, and why training refuses the
    /// file, if it does; the exit code is then 1
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode, Error> {
    let asked = Asked {
        data: &args.taken.settings.data,
        labels: args.labels.as_deref(),
        labels_from_names: args.labels_from_names.as_deref(),
        out: args.out.as_deref(),
        front_end: args.front_end.as_deref(),
        force: args.force,
    };
    if args.json {
        let described = output::logged(|log| describe(&asked, log))?;
        output::json("init", described.to_json())?;
        return Ok(if described.refused.is_some() { ExitCode::FAILURE } else { ExitCode::SUCCESS });
    }
    output::say(output::logged(|log| describe(&asked, log)?.accepted())?.told)?;
    Ok(ExitCode::SUCCESS)
}
