//! `bearing-watch-studies tables`

use std::path::PathBuf;

use super::output::{self, Output};
use bearing_watch_studies::pages::tables::{conclusion, page};
use bearing_watch_studies::tables::{Id, Settings, notes, render, run as make};
use model::Error;
use model::outputs::{plan, write_all};
use model::session::Progress as _;

/// The source's tables reproduced on the simulated rigs, beside the published figures, with a note to each
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch-studies tables --only 4.1,4.3 --report tables.html --out tables.csv
  bearing-watch-studies tables --only 5.2,5.12,5.35 --repetitions 4 --report actuator.html

Tables 5.2 to 5.13 and the figure are those of the actuator; they have a quarter of the draws. 5.12 and 5.13 contain 5.14 \
and 5.15.")]
pub(crate) struct Args {
    /// Number of draws of training and validation sets
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repetitions: u32,
    /// Seed
    #[arg(long, default_value_t = 1)]
    seed: u16,
    /// Only these tables: 2.2, 3.1, 3.2, 4.1 to 4.4, piecewise, 5.2 to 5.13, and 5.35, the figure
    #[arg(long, value_name = "TABLES", value_delimiter = ',', value_parser = Id::parse)]
    only: Vec<Id>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Write every figure as a row of CSV
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write a page with tables and plots
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, output: Output) -> Result<(), Error> {
    let files = [&args.out, &args.report];
    plan(&files.iter().filter_map(|file| file.as_deref()).collect::<Vec<_>>(), &[])?;
    let asked = |id: &Id| args.only.is_empty() || args.only.contains(id);
    let tables: Vec<Id> = Id::ALL.into_iter().filter(asked).collect();
    let settings = Settings { repetitions: args.repetitions, seed: u32::from(args.seed), tables };
    let done = output.start("tables", settings.steps());
    let tables = make(&settings, || done(1))?;

    let intro = notes::intro(&settings);
    let csv = output::csv(&render::tidy(&tables));
    let html = page(&settings, &intro, &tables);
    let written: Vec<_> = files
        .into_iter()
        .zip([&csv, &html])
        .filter_map(|(file, content)| file.as_deref().map(|path| (path, content.as_bytes())))
        .collect();
    write_all(&written)?;
    if args.json {
        return output::json(&render::to_json(&settings, &tables));
    }
    output.conclude(&conclusion(&tables));
    for words in intro {
        output::say(render::wrap(&words))?;
    }
    for table in &tables {
        output::say(format!("\n{}", render::text(table).trim_end()))?;
    }
    for (path, _) in written {
        output::say(format!("\nWritten: {}", path.display()))?;
    }
    Ok(())
}
