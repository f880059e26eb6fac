//! `bearing-watch campaign`

use std::path::PathBuf;

use super::output;
use crate::Error;
use crate::report::pages::campaign::page;
use crate::study::campaign::{Settings, campaign, render};

/// Train and evaluate the detector on the standard rig under every condition, size of defect and set rate, beside the
/// goals and the source's own method
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch campaign --repetitions 20 --report campaign.html --out campaign.csv")]
pub(super) struct Args {
    /// Number of draws of training and validation sets
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=900))]
    repetitions: u32,
    /// Number of the first draw; a different number gives different traces
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=90))]
    first: u32,
    /// Traces per class in each set
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(12..=1000))]
    traces: u32,
    /// Leave out the false alarms of many gates, which take longest
    #[arg(long)]
    quick: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Write the counts of every repetition as CSV
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write a page with tables and plots
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let files = [&args.out, &args.report];
    output::plan(&files.iter().filter_map(|file| file.as_deref()).collect::<Vec<_>>(), &[])?;
    let Args { repetitions, first, traces, .. } = *args;
    let settings = Settings { repetitions, first, traces, false_alarms: !args.quick };
    let bar = output::progress("campaign", settings.steps());
    let findings = campaign(settings, || bar.inc(1))?;
    bar.finish_and_clear();
    let contents = [output::csv(&render::tidy(&findings))?, page(&findings)];
    let files = files.into_iter().zip(&contents);
    let files = files.filter_map(|(file, content)| file.as_deref().map(|path| (path, content.as_bytes())));
    output::write_all(&files.collect::<Vec<_>>())?;
    if args.json {
        return output::json(&render::to_json(&findings));
    }
    output::say(render::text(&findings).trim_end())
}
