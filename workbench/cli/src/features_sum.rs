//! `bearing-watch features-sum`

use super::jobs::FeaturesSum;
use super::options::{Own, Taken};
use super::output;
use fleet::steps::{SumOptions, features_sum};
use model::Error;

/// Sum the features of parts, for training on several machines
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  bearing-watch features-sum north/*.parquet --features a,b --out north.sums
  bearing-watch features-sum north.sums south.sums --out all.sums
  bearing-watch train-features all.sums --model out.bwm

Sums are exact: any order and any tree of merges gives the same model. A drive is complete when its parts are summed, \
so that ten bytes of it are kept; sums that share a drive are refused, unless they are made with --keep-units, which \
keeps the sums of each run, some hundred bytes. Sums do not tell the tails of the gate's law: see train-features.")]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) taken: Taken<FeaturesSum>,
    #[command(flatten)]
    options: Own<SumOptions>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let options = &args.options.0;
    let summed = output::logged(|log| features_sum(&args.taken.settings, options, log))?;
    if args.json {
        return output::json("features-sum", summed.to_json());
    }
    let (sums, [open, closed]) = (&summed.sums, summed.sums.units());
    output::say(format!(
        "sums of {} segments of {} drives ({open} open), features {}; {} bytes in {}",
        sums.rows,
        open + closed,
        sums.features.join(", "),
        summed.bytes,
        options.out.display()
    ))
}
