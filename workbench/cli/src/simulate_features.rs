//! `bearing-watch simulate-features`

use std::path::PathBuf;
use std::time::Instant;

use rayon::prelude::*;

use super::output;
use crate::simulated_fleet::Fleet;
use model::Error;
use model::outputs::Staged;

/// Simulate a fleet as features, to measure training from them
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  bearing-watch simulate-features --drives 10000 --segments 100 --seed 1 --out fleet
  bearing-watch train-features fleet/*.parquet --features a,b,c --unit drive --model fleet.bwm --json

Eight of ten drives are healthy, one has a spall, one lost its lubrication. Drives and runs have offsets. The detector \
and the classes are those of the DC rig, so that the model runs on its traces.")]
pub(super) struct Args {
    /// Number of drives
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    drives: u64,
    /// Segments of each drive
    #[arg(long, value_name = "N", default_value_t = 100)]
    segments: u32,
    /// Runs of each drive
    #[arg(long, value_name = "N", default_value_t = 10)]
    runs: u32,
    /// Number of parts
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u64).range(1..))]
    parts: u64,
    /// Seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder of the parts; created if absent
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let start = Instant::now();
    let fleet = Fleet::new(args.segments, args.runs, args.seed)?;
    std::fs::create_dir_all(&args.out).map_err(Error::io(&args.out))?;
    let bar = output::progress("simulating", args.drives as usize);
    let write = |part: u64| {
        let path = args.out.join(format!("part{part:03}.parquet"));
        let mut staged = Staged::new(&path)?;
        let drives = part * args.drives / args.parts..(part + 1) * args.drives / args.parts;
        let rows = fleet.write(staged.file(), &path, drives, || bar.inc(1))?;
        staged.finish()?;
        Ok(rows)
    };
    let rows = (0..args.parts).into_par_iter().map(write).collect::<Result<Vec<u64>, Error>>()?;
    bar.finish_and_clear();
    let (rows, seconds) = (rows.iter().sum::<u64>(), start.elapsed().as_secs_f64());
    output::say(format!("{rows} segments of {} drives in {}, {seconds:.1} s", args.drives, args.out.display()))
}
