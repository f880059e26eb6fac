//! `bearing-watch-studies campaign`

use std::path::PathBuf;

use super::output::{self, Output};
use bearing_watch_studies::campaign::{Settings, campaign, render};
use bearing_watch_studies::ema;
use bearing_watch_studies::field::{self, delay, growth, limits};
use bearing_watch_studies::pages::campaign::{conclusion, field_conclusion, field_page, page};
use model::Error;
use model::outputs::{plan, write, write_all};
use model::session::Progress as _;
use rig::Condition;

/// Train and evaluate the detector on the standard rig under every condition, size of defect and set rate, beside the
/// goals and the source's own method; or, with --field, under the effects of the field, or, with
/// --ema, on the actuator
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch-studies campaign --repetitions 20 --report campaign.html --out campaign.csv
  bearing-watch-studies campaign --quick --only mix,amplitude-2 --repetitions 4
  bearing-watch-studies campaign --field --draws 20
  bearing-watch-studies campaign --field --draws 2 --only mix,temperature,field-sine --json
  bearing-watch-studies campaign --field --default --only axes --draws 3 --healthy 100 --defects 30
  bearing-watch-studies campaign --field --limits --draws 1
  bearing-watch-studies campaign --ema --draws 5
  bearing-watch-studies campaign --ema --default --draws 5
  bearing-watch-studies campaign --field --delay --draws 1
  bearing-watch-studies campaign --field --growth --draws 1

With --ema the records are those of the simulated actuator: phase currents and resolver counts at 12 kHz, through the \
core's front end to 1 kHz, under random conditions, beside the source's method and its calibration. \
With --field there is one row a condition: a gate of 150 healthy records at 1 % false alarms, trained and judged under \
this condition with one recipe for all rows; rows that end in -unseen are trained without the missing samples. The \
rows axes are axes with a weight that no sensor measures; they are computed only if --only names them. Records \
without a verdict are not detected, and are an error of the three classes.")]
pub(crate) struct Args {
    /// Number of draws of training and validation sets
    #[arg(long, visible_alias = "draws", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=900))]
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
    /// One row for each effect of the field
    #[arg(long, conflicts_with_all = ["traces", "quick"])]
    field: bool,
    /// The actuator instead of the DC motor: phase currents and resolver counts to verdicts
    #[arg(long, conflicts_with_all = ["field", "quick", "report"])]
    ema: bool,
    /// Only these rows of the field, or of the standard rig the experiments of these conditions
    #[arg(long, value_name = "NAMES", value_delimiter = ',', conflicts_with = "ema")]
    only: Vec<String>,
    /// Defects as large as the limit that their own healthy verdict states, and how many of them are called; one draw
    #[arg(long, requires = "field", conflicts_with_all = ["out", "features", "report"])]
    limits: bool,
    /// Hours between false alarms and runs until the alarm, on drives that were not in training; a draw takes minutes
    #[arg(long, requires = "field", conflicts_with_all = ["out", "features"])]
    delay: bool,
    /// Time left of growing defects beside the truth, on drives that were not in training; a draw takes minutes
    #[arg(long, requires = "field", conflicts_with_all = ["out", "features", "delay"])]
    growth: bool,
    /// Draw a table of the field that was printed before, for example docs/field.md, and compute nothing
    #[arg(long, value_name = "FILE", requires_all = ["field", "report"])]
    printed: Option<PathBuf>,
    /// Features of the field's detector, instead of those of its recipe
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "field")]
    features: Vec<String>,
    /// The detector of a user who names no features, instead of the one of the recipe; with --field or --ema
    #[arg(long, conflicts_with_all = ["features", "quick", "limits"])]
    default: bool,
    /// Healthy records on which each detector of the field is judged
    #[arg(long, value_name = "N", requires = "field", conflicts_with_all = ["limits", "delay", "growth"])]
    #[arg(default_value_t = field::Settings::standard(0, 0).healthy)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=10_000))]
    healthy: u32,
    /// Records of each defect on which each detector of the field is judged
    #[arg(long, value_name = "N", requires = "field", conflicts_with_all = ["limits", "delay", "growth"])]
    #[arg(default_value_t = field::Settings::standard(0, 0).defects)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=10_000))]
    defects: u32,
    /// Records of the field that are judged together, as those of one run
    #[arg(long, value_name = "N", requires = "field", conflicts_with_all = ["limits", "delay", "growth"])]
    #[arg(default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    together: u32,
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

pub(crate) fn run(args: &Args, output: Output) -> Result<(), Error> {
    let files = [&args.out, &args.report];
    plan(&files.iter().filter_map(|file| file.as_deref()).collect::<Vec<_>>(), &[])?;
    if args.field {
        return run_field(args, output);
    }
    if args.ema {
        return run_ema(args, output);
    }
    if args.default {
        return Err(Error::Usage("--default is for --field or --ema; the standard rig has one configuration".into()));
    }
    let Args { repetitions, first, traces, .. } = *args;
    let settings = Settings { repetitions, first, traces, false_alarms: !args.quick, only: args.only.clone() };
    let done = output.start("campaign", settings.steps()?);
    let findings = campaign(settings, || done(1))?;
    let contents = [output::csv(&render::tidy(&findings)), page(&findings)];
    let files = files.into_iter().zip(&contents);
    let files = files.filter_map(|(file, content)| file.as_deref().map(|path| (path, content.as_bytes())));
    write_all(&files.collect::<Vec<_>>())?;
    if args.json {
        return output::json(&render::to_json(&findings));
    }
    output.conclude(&conclusion(&findings));
    output::say(render::text(&findings).trim_end())
}

fn run_ema(args: &Args, output: Output) -> Result<(), Error> {
    let settings =
        ema::Settings { draws: args.repetitions, first: args.first, records: args.traces, default: args.default };
    let done = output.start("actuator", settings.steps());
    let findings = ema::study(settings, || done(1))?;
    if let Some(path) = &args.out {
        write(path, output::csv(&ema::render::tidy(&findings)))?;
    }
    if args.json {
        return output::json(&ema::render::to_json(&findings));
    }
    output::say(ema::render::text(&findings).trim_end())
}

fn run_field(args: &Args, output: Output) -> Result<(), Error> {
    if let (Some(path), Some(printed)) = (&args.report, &args.printed) {
        let text = std::fs::read_to_string(printed).map_err(|source| Error::Io { path: printed.clone(), source })?;
        return write(path, field_page(&text)?);
    }
    if args.delay {
        return run_delay(args, output);
    }
    if args.growth {
        return run_growth(args, output);
    }
    let rows = field::rows::named(&args.only)?;
    field::recipe::recipe(&Condition::MIX, &args.features).catalogue().choose(&args.features)?;
    let settings = field::Settings {
        features: args.features.clone(),
        default: args.default,
        healthy: args.healthy,
        defects: args.defects,
        together: args.together,
        ..field::Settings::standard(args.repetitions, args.first)
    };
    if args.limits {
        let all = each(output, "limits", &rows, |row| limits::limits(row, args.first))?;
        if args.json {
            return output::json(&limits::to_json(&all));
        }
        return output::say(limits::text(&all).trim_end());
    }
    let done = output.start("field", rows.len() * settings.draws as usize);
    let findings = field::study(&rows, &settings, || done(1))?;
    if let Some(path) = &args.out {
        write(path, output::csv(&field::render::tidy(&findings, &settings)))?;
    }
    let text = field::render::text(&findings, &settings);
    if let Some(path) = &args.report {
        write(path, field_page(&text)?)?;
    }
    if args.json {
        return output::json(&field::render::to_json(&findings, &settings));
    }
    if let Ok(words) = field_conclusion(&text) {
        output.conclude(&words);
    }
    output::say(text.trim_end())
}

/// The draws of each row of the studies with drives and runs.
fn rows_of_runs(args: &Args) -> Result<Vec<(Condition, u32)>, Error> {
    let asked = |condition: &Condition| args.only.is_empty() || args.only.iter().any(|own| own == condition.name);
    let conditions: Vec<Condition> = delay::conditions().into_iter().filter(asked).collect();
    if conditions.is_empty() {
        return Err(Error::Usage("--delay and --growth have the rows field-sine and field-any".into()));
    }
    let draws = args.first..args.first + args.repetitions;
    Ok(conditions.iter().flat_map(|condition| draws.clone().map(|draw| (*condition, draw))).collect())
}

fn run_growth(args: &Args, output: Output) -> Result<(), Error> {
    let settings = growth::Settings::STANDARD;
    let all =
        each(output, "growth", &rows_of_runs(args)?, |(condition, draw)| growth::draw(*condition, *draw, &settings))?;
    if args.json {
        return output::json(&growth::to_json(&all));
    }
    output::say(growth::text(&all).trim_end())
}

fn run_delay(args: &Args, output: Output) -> Result<(), Error> {
    let settings = delay::Settings::STANDARD;
    let all =
        each(output, "delay", &rows_of_runs(args)?, |(condition, draw)| delay::draw(*condition, *draw, &settings))?;
    if args.json {
        return output::json(&delay::to_json(&all, &settings));
    }
    output::say(delay::text(&all, &settings).trim_end())
}

/// Results of `of` for all items, with progress.
fn each<T, U>(
    output: Output,
    what: &'static str,
    items: &[T],
    of: impl Fn(&T) -> Result<U, Error>,
) -> Result<Vec<U>, Error> {
    let done = output.start(what, items.len());
    items.iter().map(|item| of(item).inspect(|_| done(1))).collect()
}
