//! `bearing-watch train`

use std::path::PathBuf;

use serde_json::json;

use super::args::traces::Given;
use super::output;
use super::training::{Found, Settings, Training, words};
use crate::Error;
use crate::report::pages::model::{self, Worth};

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
    /// The binary model
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// The model as Rust constants
    #[arg(long, value_name = "FILE")]
    rust: Option<PathBuf>,
    /// With --rust, also the constants for `Model::commissioning` with so many healthy segments of a drive
    #[arg(long, value_name = "SEGMENTS", requires = "rust", value_parser = clap::value_parser!(u32).range(2..=10_000))]
    commissioning: Option<u32>,
    /// The model as a C header, for the library of `c-api`
    #[arg(long, value_name = "FILE")]
    c: Option<PathBuf>,
    /// A page with the features, the decision regions and the held-out result
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let session = args.settings.session(Given::default())?;
    let files = [Some(args.model.as_path()), args.rust.as_deref(), args.c.as_deref(), args.report.as_deref()];
    output::plan(&files.into_iter().flatten().collect::<Vec<_>>(), &session.selection.inputs())?;
    let own = session.train()?;
    let rust = args.rust.as_ref().map(|_| own.rust_source(args.commissioning)).transpose()?;
    let c = args.c.as_ref().map(|_| own.c_header()).transpose()?;
    let found = session.found(&own, args.rank)?;
    let report = args.report.as_ref().map(|_| {
        let first = |k| own.prepared.iter().find(|t| t.class == k).map(|t| (&t.trace, k));
        let examples: Vec<_> = (0..own.trained.classes.len()).filter_map(first).collect();
        let seen = own.seen()?;
        model::training(&own.trained, &own.channels, &examples, Worth { training: &seen, ..found.worth() })
    });
    let report = report.transpose()?.map(super::drive::on_page);
    let texts = [(&args.rust, &rust), (&args.c, &c), (&args.report, &report)];
    let texts = texts.into_iter().filter_map(|(path, text)| Some((path.as_deref()?, text.as_ref()?.as_bytes())));
    output::write_all(&texts.chain([(args.model.as_path(), own.bytes.as_slice())]).collect::<Vec<_>>())?;
    own.warn();
    print(args, &own, &found)
}

/// Prints the report of the training.
fn print(args: &Args, own: &Training, found: &Found) -> Result<(), Error> {
    if args.json {
        let mut value = json!({ "model": args.model });
        value.as_object_mut().into_iter().for_each(|object| object.extend(words::to_json(own, found)));
        return output::json(&value);
    }
    let place = format!(" in {}", args.model.display());
    words::lines(own, found, &place).iter().try_for_each(output::say)
}
