//! `bearing-watch train`

use std::path::{Path, PathBuf};

use serde_json::json;

use crate::command_line::jobs::Train;
use crate::command_line::options::{Own, Taken};
use crate::command_line::output;
use model::Error;
use model::outputs::Exports;
use model::session::{Found, Session, Training, lines, to_json};
use pages::training::{self, Worth};
use traces::given::{Memory, given};

/// Train a model from labelled traces, for the detector in firmware
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "bearing-watch train drive.toml --model FILE [OPTIONS]
       bearing-watch train --labels FILE --y CHANNEL --u1 CHANNEL --model FILE [OPTIONS]",
    after_help = "Examples:
  bearing-watch train drive.toml --model model.bwm --rust model.rs
  bearing-watch train --labels traces/labels.csv --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm \
--order 2,1,2,1,1 --model model.bwm

drive.toml is what `bearing-watch init` writes."
)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) taken: Taken<Train>,
    /// Rank the features (those of --features, or all): Fisher ratios, cross-validated gains, and what to drop
    #[arg(long)]
    rank: bool,
    #[command(flatten)]
    exports: Own<Exports>,
    /// A page with the features, the decision regions and the held-out result
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Where the settings are saved, with what training chooses.
    #[arg(skip)]
    pub(crate) save: Option<PathBuf>,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let (settings, exports) = (args.taken.settings.clone(), &args.exports.0);
    let given = given(&settings, Memory::default())?;
    let session = Session::new(settings.clone(), given, args.taken.drive.clone())?;
    let files: Vec<&Path> = exports.files().chain(args.report.as_deref()).chain(args.save.as_deref()).collect();
    output::plan(&files, &session.inputs())?;
    exports.check()?;
    output::logged(|log| {
        let mut training = session.train(log)?;
        let mut taken = args.taken.clone();
        if let Some(path) = &args.save {
            taken.settings = training.settings(&settings);
            let text = taken.text(path)?;
            taken.drive = Some(text.clone());
            training = training.with_drive(text)?;
        }
        let exported =
            exports.exported(training.bytes.clone(), || training.rust_source(), |name| training.c_header(name))?;
        let findings = session.found(&training, args.rank, log)?;
        let report = args.report.as_ref().map(|_| page(&training, &findings)).transpose()?;
        let report = report.map(|page| taken.on_page(page));
        let page = args.report.as_deref().zip(report.as_ref()).map(|(path, text)| (path, text.as_bytes()));
        let saved = args.save.as_deref().zip(taken.drive.as_ref()).map(|(path, text)| (path, text.as_bytes()));
        output::write_all(&exports.contents(&exported).into_iter().chain(page).chain(saved).collect::<Vec<_>>())?;
        log.warn(training.doubts());
        print(args, &training, &findings)
    })
}

/// The page of a training.
fn page(own: &Training, found: &Found) -> Result<String, Error> {
    let first = |k| own.prepared.iter().find(|t| t.class == k).map(|t| (&t.trace, k));
    let examples: Vec<_> = (0..own.trained.classes.len()).filter_map(first).collect();
    let seen = own.seen()?;
    let worth = Worth {
        training: &seen,
        held_out: found.held_out.as_ref().map(|h| (&h.confusion, h.verdicts.as_slice(), &h.scores)),
        cross_validated: found.cross_validated.as_ref().map(Result::as_ref),
        ranking: found.ranking.as_ref(),
        missing: own.missing().line(),
    };
    training::training(&own.trained, &own.channels, &examples, worth)
}

/// Prints the report of the training.
fn print(args: &Args, own: &Training, found: &Found) -> Result<(), Error> {
    let model = &args.exports.0.model;
    if args.json {
        let mut value = json!({ "model": model });
        value.as_object_mut().into_iter().for_each(|object| object.extend(to_json(own, found)));
        return output::json("train", value);
    }
    lines(own, found, &format!(" in {}", model.display())).iter().try_for_each(output::say)
}
