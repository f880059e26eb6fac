//! `bearing-watch piecewise`

use std::path::PathBuf;

use super::jobs::Piecewise;
use super::options::Taken;
use super::{output, recordings};
use model::Error;
use model::piecewise::{Cutting, estimate};
use model::trace::FrontEndFile;

/// First-order models of the straight runs of each trace, their medians as a table
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch piecewise traces --y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm \
--threshold 0.5 --min-run 150 --out pieces.csv"
)]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) taken: Taken<Piecewise>,
    /// Least slope of a straight run, as a fraction of the steepest slope of the stroke
    #[arg(long, value_name = "PART", default_value_t = Cutting::default().threshold)]
    threshold: f64,
    /// Least number of samples of a run
    #[arg(long, value_name = "N", default_value_t = Cutting::default().min_samples)]
    min_run: usize,
    /// Cut-off of the low-passed copy, in multiples of the fundamental
    #[arg(long, value_name = "RATIO", default_value_t = Cutting::default().cutoff_ratio)]
    cutoff_ratio: f64,
    /// One row per run instead of the medians
    #[arg(long)]
    runs: bool,
    /// Write the table here instead of to standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let settings = &args.taken.settings;
    let preparation = settings.model.preparation()?;
    settings.channels.require(model::identify::Structure::new(1, 1, 1, 0, 0))?;
    output::plan(&args.out.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &settings.data.traces)?;
    let front_end = settings.data.front_end.as_deref().map(FrontEndFile::read).transpose()?;
    let traces = recordings::read(&settings.data.traces, &settings.channels(front_end)?)?;
    let Args { threshold, min_run: min_samples, cutoff_ratio, .. } = *args;
    let cutting = Cutting { threshold, min_samples, cutoff_ratio };
    let header: &[&str] = if args.runs { &["trace", "first", "samples"] } else { &["trace", "runs"] };
    let mut rows = vec![header.iter().chain(&["a1", "b1", "c1"]).map(ToString::to_string).collect::<Vec<_>>()];
    for trace in &traces {
        let pieces = estimate(&preparation.apply(trace)?, &cutting)?;
        let numbers = |theta: &[f64; 3]| theta.map(|parameter| parameter.to_string());
        let mut row =
            |cells: &[String], theta| rows.push([std::slice::from_ref(&trace.id), cells, &numbers(theta)].concat());
        if args.runs {
            for (run, theta) in pieces.runs.iter().zip(&pieces.theta) {
                row(&[run.start.to_string(), run.len().to_string()], theta);
            }
        } else {
            row(&[pieces.runs.len().to_string()], &pieces.median);
        }
    }
    let table = output::csv(&rows)?;
    match &args.out {
        Some(path) => {
            output::write(path, table)?;
            output::say(format!("{} traces in {}", traces.len(), path.display()))
        }
        None => output::say(table.trim_end()),
    }
}
