//! `bearing-watch features-sum`

use std::path::PathBuf;
use std::time::Instant;

use serde_json::json;

use super::call::Report;
use super::output;
use super::train_features::{Inputs, peak_memory_mb};
use fleet::{Choice, Units};
use model::Error;
use model::trace::Condition;
use model::train::Recipe;

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
    /// Parts, and sums of other parts
    #[arg(value_name = "PARTS", required = true)]
    parts: Vec<PathBuf>,
    /// Features to sum, as in train; of sums, those that they have
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    features: Vec<String>,
    /// Only segments with this, e.g. 'run<=4'; may be repeated, all must hold
    #[arg(long, value_name = "CONDITION")]
    train_where: Vec<Condition>,
    /// Drives are not complete: further parts have segments of them
    #[arg(long)]
    keep_units: bool,
    /// The sums
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    output::report(made(args)?, args.json)
}

/// Writes the sums, and returns what there is to say.
pub(super) fn made(args: &Args) -> Result<Report, Error> {
    let start = Instant::now();
    output::plan(&[&args.out], &args.parts)?;
    let inputs = Inputs::open(&args.parts)?;
    let features = match inputs.parts.first() {
        Some(part) => {
            let recipe = Recipe { features: args.features.clone(), ..part.plan.recipe() };
            Choice::new(&part.plan, &recipe)?.features
        }
        None if args.features.is_empty() => vec![],
        None => return Err(Error::Usage("--features chooses those of parts; sums have theirs".into())),
    };
    let units = if args.keep_units { Units::Open } else { Units::Remembered };
    let sums = inputs.sums((features, args.train_where.clone()), units)?;
    let bytes = sums.to_bytes()?;
    output::write(&args.out, &bytes)?;
    let [open, closed] = sums.units();
    let json = json!({
        "sums": args.out, "rows": sums.rows, "features": sums.features, "bytes": bytes.len(),
        "open_units": open, "complete_units": closed, "classes": sums.names().collect::<Vec<_>>(),
        "seconds": start.elapsed().as_secs_f64(), "peak_memory_mb": peak_memory_mb(),
    });
    let said = format!(
        "sums of {} segments of {} drives ({open} open), features {}; {} bytes in {}",
        sums.rows,
        open + closed,
        sums.features.join(", "),
        bytes.len(),
        args.out.display()
    );
    Ok(Report { lines: vec![said], json })
}
