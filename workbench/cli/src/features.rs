//! `bearing-watch features`

use super::jobs::Features;
use super::options::{Own, Taken};
use super::output;
use fleet::steps::{FeaturesOptions, features};
use model::Error;
use pages::page::counted;
use traces::given::{Memory, given};

/// Compute the features of labelled traces, one row a segment, for training from tables of any size
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch features drive.toml --unit drive --out a.parquet
  bearing-watch features drive.toml --unit drive --plan a.parquet --out b.parquet
  bearing-watch train-features a.parquet b.parquet --features a,b --model out.bwm

The first part takes the constants of the detector (scales, lags, filters, nominal model) from its traces and has them \
as the plan in its metadata; further parts, on any machine, take the plan of the first one by --plan. All features of \
the detector are computed, by the core as in firmware. Traces are read and written in turn: memory does not grow with \
their number. Rows are written by unit if each file is one trace; a table of several traces should have its rows by \
unit, so that parts are read back in constant memory.")]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) taken: Taken<Features>,
    #[command(flatten)]
    options: Own<FeaturesOptions>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let (settings, options) = (&args.taken.settings, &args.options.0);
    let given = given(settings, Memory::default())?;
    let found = output::logged(|log| features(settings, given, options, log))?;
    if args.json {
        return output::json("features", found.to_json());
    }
    let [segments, traces, features] = [
        counted(found.rows as usize, "segment"),
        counted(found.traces, "trace"),
        counted(found.features.len(), "feature"),
    ];
    output::say(format!("{segments} of {traces} with {features} in {}", options.out.display()))?;
    match found.empty {
        (0, _) => Ok(()),
        (count, reason) => output::say(format!("{count} segments have none: {}", reason.unwrap_or_default())),
    }
}
