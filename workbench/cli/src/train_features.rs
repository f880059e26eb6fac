//! `bearing-watch train-features`

use super::jobs::TrainFeatures;
use super::options::{Own, Taken};
use super::output;
use fleet::steps::{PartOptions, TrainedOnParts, train_features};
use model::Error;
use model::outputs::Exports;
use model::session::description;

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
pub(super) struct Args {
    #[command(flatten)]
    pub(super) taken: Taken<TrainFeatures>,
    #[command(flatten)]
    options: Own<PartOptions>,
    #[command(flatten)]
    exports: Own<Exports>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
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
