//! `bearing-watch features` and `train-features`: training from tables of features

use crate::command_line::jobs::{Features, TrainFeatures};
use crate::command_line::options::{Own, Taken};
use crate::command_line::output;
use fleet::steps::{FeaturesOptions, PartOptions, TrainedOnParts, features, train_features};
use model::Error;
use model::outputs::Exports;
use model::session::description;
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
pub(crate) struct FeaturesArgs {
    #[command(flatten)]
    pub(crate) taken: Taken<Features>,
    #[command(flatten)]
    options: Own<FeaturesOptions>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn compute(args: &FeaturesArgs) -> Result<(), Error> {
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

/// Train a model from tables of features, in constant memory
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  bearing-watch train-features a.parquet b.parquet --features a,b --unit drive --model out.bwm --rust model.rs

Means, covariances, projection, discriminant, and the spread of runs or drives are functions of sums: they are those \
of `train` on the same segments. Different are:
  - the tails of the gate's law come from a second pass over the parts (skipped by --one-pass, which leaves their \
prior probabilities: the gate is a little further out);
  - errors of features enter as the mean excess over the usual ones of the plan, by class, not by segment;
  - segments that lack a feature do not count for the spread of runs and drives;
  - trends of runs are not found, and the draws for the likelihood ratios of the alarm are of means and covariances;
  - there is no cross-validation, no --rank, no --covariates and no --discriminant shrunk; the model does not list the \
traces or drives of its training, so that `evaluate` cannot warn of them.

One file of features has one plan; parts of other plans are refused.")]
pub(crate) struct TrainArgs {
    #[command(flatten)]
    pub(crate) taken: Taken<TrainFeatures>,
    #[command(flatten)]
    options: Own<PartOptions>,
    #[command(flatten)]
    exports: Own<Exports>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn train(args: &TrainArgs) -> Result<(), Error> {
    let (options, exports) = (&args.options.0, &args.exports.0);
    let drive = args.taken.drive.clone();
    let own = output::logged(|log| train_features(&args.taken.settings, options, exports, drive, log))?;
    if args.json {
        output::json("train-features", own.to_json())
    } else {
        lines(&own, exports).iter().try_for_each(output::say)
    }
}

fn lines(own: &TrainedOnParts, exports: &Exports) -> Vec<String> {
    let (trained, [_, all]) = (&own.trained, own.seconds);
    let counts = trained.classes.iter().zip(&trained.statistics.counts);
    let segments: Vec<String> = counts.map(|(name, n)| format!("{n} {name}")).collect();
    let features = trained.feature_names.join(", ");
    let mut lines = vec![format!("trained on segments: {}; features {features}", segments.join(", "))];
    lines.extend(description::built(trained, own.bytes, &format!(" in {}", exports.model.display())));
    lines.extend(description::gate(trained));
    let peak = own.peak_memory_mb.map_or_else(String::new, |peak| format!(", {peak:.0} MB at most"));
    lines.push(format!("fingerprint {}; {} rows in {all:.2} s{peak}", own.fingerprint, own.sums.rows));
    lines
}
