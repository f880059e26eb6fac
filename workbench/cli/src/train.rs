//! `bearing-watch train`

use std::path::{Path, PathBuf};

use serde_json::json;

use super::args::exports::ExportArgs;
use super::args::traces::Given;
use super::output;
use super::training::{Found, Settings, Training, words};
use model::Error;
use pages::training::{self, Worth};

/// Train a model from labelled traces, for the detector in firmware
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch train --labels traces/labels.csv --y current_a --u1 velocity_ref_rad_s \
--u2 load_torque_nm --order 2,1,2,1,1 --model model.bwm --rust model.rs"
)]
pub(super) struct Args {
    #[command(flatten)]
    settings: Settings,
    /// Rank the features (those of --features, or all): Fisher ratios, cross-validated gains, and what to drop
    #[arg(long)]
    rank: bool,
    #[command(flatten)]
    exports: ExportArgs,
    /// A page with the features, the decision regions and the held-out result
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let session = args.settings.session(Given::default())?;
    let files: Vec<&Path> = args.exports.files().chain(args.report.as_deref()).collect();
    output::plan(&files, &session.selection.inputs())?;
    let own = session.train()?;
    let exported = args.exports.exported(own.bytes.clone(), |segments| own.rust_source(segments), || own.c_header())?;
    let found = session.found(&own, args.rank)?;
    let report = args.report.as_ref().map(|_| {
        let first = |k| own.prepared.iter().find(|t| t.class == k).map(|t| (&t.trace, k));
        let examples: Vec<_> = (0..own.trained.classes.len()).filter_map(first).collect();
        let seen = own.seen()?;
        training::training(&own.trained, &own.channels, &examples, Worth { training: &seen, ..found.worth() })
    });
    let report = report.transpose()?.map(super::drive::on_page);
    let page = args.report.as_deref().zip(report.as_ref()).map(|(path, text)| (path, text.as_bytes()));
    output::write_all(&args.exports.contents(&exported).into_iter().chain(page).collect::<Vec<_>>())?;
    own.warn();
    print(args, &own, &found)
}

/// Prints the report of the training.
fn print(args: &Args, own: &Training, found: &Found) -> Result<(), Error> {
    if args.json {
        let mut value = json!({ "model": args.exports.model });
        value.as_object_mut().into_iter().for_each(|object| object.extend(words::to_json(own, found)));
        return output::json(&value);
    }
    let place = format!(" in {}", args.exports.model.display());
    words::lines(own, found, &place).iter().try_for_each(output::say)
}
