//! `bearing-watch audit`

mod findings;
mod page;
mod words;

pub(crate) use page::page_of;

use std::collections::HashSet;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::args::alarms::healthy_class;
use crate::args::traces::TimeArgs;
use crate::drive::Guess;
use crate::output;
use findings::{add, equal_traces, session_sets};
use model::Error;
use model::audit::column::Column;
use model::audit::friction::{Excited, Motion, Terms, excited};
use model::audit::orders::{self, angle, floor, rate, smallest_line, turns};
use model::audit::times::Times;
use model::trace::{Condition, stem};
use traces::reader::{self, Series};
use traces::resample::unwrapped;
use traces::table::Table;
use words::{print, to_json};

/// What recordings are worth: rate, gaps, held and saturated samples, lags, equal traces, the smallest line of an order
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Ends with exit code 1 if it finds something.\n\nExample:\n  bearing-watch audit drive.toml --json"
)]
pub(crate) struct Args {
    /// Trace files or folders; without any, the folder of the labels
    #[arg(value_name = "TRACES")]
    traces: Vec<PathBuf>,
    /// Labels: the classes of the traces; without TRACES, their folder is read
    #[arg(long, value_name = "FILE", required_unless_present = "traces")]
    labels: Option<PathBuf>,
    /// Only traces whose labels meet this condition, e.g. load_kgf=20; may be repeated, all must hold
    #[arg(long = "where", value_name = "CONDITION", requires = "labels")]
    conditions: Vec<Condition>,
    /// The healthy class; by default the one named healthy or normal
    #[arg(long, value_name = "CLASS")]
    healthy: Option<String>,
    /// Load; by default the likely channel
    #[arg(long, value_name = "CHANNEL")]
    load: Option<String>,
    #[command(flatten)]
    times: TimeArgs,
    /// Current, in which orders are looked for; by default the likely one
    #[arg(long, value_name = "CHANNEL")]
    current: Option<String>,
    /// Velocity, rad/s; by default the likely one
    #[arg(long, value_name = "CHANNEL")]
    velocity: Option<String>,
    /// Angle of the shaft, rad; by default the likely one, or the integral of the velocity
    #[arg(long, value_name = "CHANNEL")]
    angle: Option<String>,
    /// Reference of the velocity; by default the likely one
    #[arg(long, value_name = "CHANNEL")]
    velocity_ref: Option<String>,
    /// False-alarm rate of the smallest line
    #[arg(long, value_name = "RATE", default_value_t = 0.01)]
    false_alarm: f64,
    /// Write a page with signals, spectra over orders and the smallest lines
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Rows of the shortest trace; shorter ones are tables of something else.
const FEWEST: usize = 8;

/// One trace: its columns by name, and the channels that were chosen.
struct Audited {
    id: String,
    names: Vec<String>,
    times: Option<Times>,
    times_s: Option<Vec<f64>>,
    columns: Vec<Column>,
    values: Vec<Vec<f64>>,
    current: Option<Vec<f64>>,
    velocity: Option<Vec<f64>>,
    angle: Option<Vec<f64>>,
    velocity_ref: Option<Vec<f64>>,
    load: Option<Vec<f64>>,
}

/// A finding, and the traces that have it.
struct Finding {
    what: String,
    traces: Vec<String>,
}

/// All that was found in some files.
struct Outcome {
    traces: Vec<Audited>,
    findings: Vec<Finding>,
    /// The rate by the lines of the rotor.
    rotor: Option<f64>,
    lines: Vec<Line>,
    /// The smallest change of each term of friction.
    terms: Vec<Excited>,
}

/// Runs the audit; returns whether something was found.
pub(crate) fn run(args: &Args) -> Result<bool, Error> {
    if !(1e-9..=0.5).contains(&args.false_alarm) {
        return Err(Error::Usage("--false-alarm: give a rate from 1e-9 to 0.5".into()));
    }
    let folder = args.labels.iter().map(|labels| output::folder_of(labels).to_path_buf());
    let paths: Vec<PathBuf> = if args.traces.is_empty() { folder.collect() } else { args.traces.clone() };
    output::plan(&args.report.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &paths)?;
    let found = args.audit(&traces::files(&paths)?)?;
    if let Some(path) = &args.report {
        output::write(path, crate::drive::on_page(args.page(&found).render()))?;
    }
    let Outcome { traces, findings, rotor, lines, terms } = &found;
    if args.json {
        let mut value = to_json(traces, findings, *rotor, lines);
        value["friction"] = terms.iter().map(Excited::to_json).collect();
        output::json(&value)?;
    } else {
        print(traces, findings, *rotor, (lines, terms, args.false_alarm))?;
    }
    Ok(!findings.is_empty())
}

impl Args {
    fn audit(&self, files: &[PathBuf]) -> Result<Outcome, Error> {
        let bar = output::progress("auditing", files.len());
        let each = |file: &PathBuf| {
            let found = self.look(file);
            bar.inc(1);
            found
        };
        let all: Vec<Result<Vec<Audited>, Error>> = files.par_iter().map(each).collect();
        bar.finish_and_clear();
        let (mut traces, mut findings) = (Vec::new(), Vec::new());
        // A file that has no label and none of the channels is a table of something else.
        let labels = self.labels.as_deref().map(traces::read_labels).transpose()?;
        let is_other = |file: &Path| {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            labels.as_ref().is_some_and(|labels| !labels.has(&name))
        };
        for (file, found) in files.iter().zip(all) {
            match found {
                Ok(found) => traces.extend(found),
                Err(_) if is_other(file) => {}
                Err(problem) => add(&mut findings, problem.to_string(), &file.display().to_string()),
            }
        }
        if traces.is_empty() {
            let problem = findings.first().map_or_else(|| "no trace".to_string(), |finding| finding.what.clone());
            return Err(Error::Usage(problem));
        }
        let short = traces.len();
        traces.retain(|trace: &Audited| trace.values.first().is_some_and(|column| column.len() >= FEWEST));
        if traces.is_empty() {
            return Err(Error::Usage(format!("{short} traces, none of {FEWEST} rows")));
        }
        if let Some(labels) = labels.as_ref().filter(|_| !self.conditions.is_empty()) {
            let chosen = labels.select(&self.conditions)?;
            let chosen: HashSet<&str> = chosen.iter().map(|(id, _)| id.as_str()).collect();
            traces.retain(|trace| chosen.contains(trace.id.as_str()));
            if traces.is_empty() {
                return Err(Error::Usage("--where: no trace that meets the conditions was found".into()));
            }
        }
        for trace in &traces {
            trace.findings(&mut findings);
        }
        equal_traces(&traces, &mut findings);
        let rotor = self.rotor_rate(&traces, &mut findings);
        // Empty without labels, and for a trace that has none.
        let ids = traces.iter().map(|trace| trace.id.as_str());
        let classes = labels.map_or(Ok(vec![]), |labels| labels.cells("class_name", ids))?;
        session_sets(&traces, &classes, &mut findings);
        let lines = self.lines(&traces, rotor);
        let terms = self.terms(&traces, &classes, rotor)?;
        Ok(Outcome { traces, findings, rotor, lines, terms })
    }

    fn rate_of(&self, trace: &Audited, rotor: Option<f64>) -> Option<f64> {
        trace.times.map(|times| times.rate_hz).or(rotor).or(self.times.rate_hz)
    }

    /// The current and the angle of the shaft, given or integrated.
    fn with_angle<'a>(&self, trace: &'a Audited, rotor: Option<f64>) -> Option<(&'a [f64], Vec<f64>)> {
        let y = trace.current.as_deref()?;
        let integrated = || Some(angle(trace.velocity.as_deref()?, self.rate_of(trace, rotor)?));
        let angle = trace.angle.as_ref().map(|angle| unwrapped(angle, TAU)).or_else(integrated)?;
        Some((y, angle))
    }

    fn look(&self, file: &Path) -> Result<Vec<Audited>, Error> {
        let time = self.times.time.as_deref();
        let table = Table::open(file)?;
        let (names, _) = reader::numeric(&table, time)?;
        let guess = Guess::of(&names);
        let chosen = [
            (&self.current, guess.current),
            (&self.velocity, guess.velocity),
            (&self.angle, guess.angle),
            (&self.velocity_ref, guess.velocity_ref),
            (&self.load, guess.load),
        ];
        let chosen = chosen.map(|(given, likely)| given.clone().or(likely));
        let channels: Vec<String> = names.iter().chain(chosen.iter().flatten()).cloned().collect();
        let read = reader::series(&table, (time, self.times.rate_hz), &channels)?;
        let recorded = reader::has_time(&table, time);
        let each = |series: Series| {
            let mut values = series.columns;
            let mut further = values.split_off(names.len()).into_iter();
            let [current, velocity, angle, velocity_ref, load] =
                chosen.clone().map(|channel| channel.and_then(|_| further.next()));
            Audited {
                id: stem(&series.id).to_string(),
                names: names.clone(),
                times: series.times_s.as_deref().filter(|_| recorded).and_then(Times::of),
                times_s: series.times_s.filter(|_| recorded),
                columns: values.iter().map(|column| Column::of(column)).collect(),
                values,
                current,
                velocity,
                angle,
                velocity_ref,
                load,
            }
        };
        Ok(read.into_iter().map(each).collect())
    }

    /// The rate by the lines of the rotor, for traces without a time.
    fn rotor_rate(&self, traces: &[Audited], findings: &mut Vec<Finding>) -> Option<f64> {
        let given = self.times.rate_hz?;
        let pairs: Vec<(&[f64], &[f64])> = traces
            .iter()
            .filter(|trace| trace.times.is_none())
            .filter_map(|trace| Some((trace.current.as_deref()?, trace.velocity.as_deref()?)))
            .collect();
        let (found, sharpness) = rate(&pairs, given)?;
        if (found / given - 1.0).abs() > 2e-3 {
            let what = format!(
                "the lines of the rotor are sharp at {found:.1} rows a second, not at the given {given} \
                 ({sharpness:.0} times the power); set rate_hz"
            );
            add(findings, what, "all without a time");
        }
        Some(found)
    }

    /// Excitation and smallest change of the terms of friction and inertia.
    fn terms(&self, traces: &[Audited], classes: &[String], rotor: Option<f64>) -> Result<Vec<Excited>, Error> {
        let mut names: Vec<String> = classes.to_vec();
        names.sort_unstable();
        names.dedup();
        let healthy = healthy_class(self.healthy.as_deref(), &names)?.map(|place| names[place].clone());
        let is_healthy = |k: usize| healthy.is_some() && classes.get(k) == healthy.as_ref();
        let each = |(k, trace): (usize, &Audited)| {
            let motion = Motion {
                current: trace.current.as_deref()?,
                velocity: trace.velocity.as_deref()?,
                load: trace.load.as_deref(),
                rate_hz: self.rate_of(trace, rotor)?,
            };
            Some((Terms::of(&motion)?, is_healthy(k)))
        };
        let all: Vec<(Terms, bool)> = traces.par_iter().enumerate().filter_map(each).collect();
        Ok(excited(&all, self.false_alarm))
    }

    /// Floor, smallest line and turns of each trace with a signal and an angle.
    fn lines(&self, traces: &[Audited], rotor: Option<f64>) -> Vec<Line> {
        let each = |trace: &Audited| {
            let (y, angle) = self.with_angle(trace, rotor)?;
            let turns = turns(&angle);
            let floor = floor(y, &angle);
            let first = orders::amplitude(y, &angle, 1.0);
            (turns > 3.0).then(|| Line {
                trace: trace.id.clone(),
                turns,
                floor,
                smallest: smallest_line(floor, self.false_alarm),
                first,
            })
        };
        traces.iter().filter_map(each).collect()
    }
}

/// Lines of orders in one trace, in the unit of the signal.
struct Line {
    trace: String,
    turns: f64,
    floor: f64,
    smallest: f64,
    /// The line of order 1.
    first: f64,
}
