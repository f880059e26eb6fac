//! `bearing-watch audit`

use std::collections::HashSet;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Value, json};

use super::args::alarms::healthy_class;
use super::args::traces::TimeArgs;
use super::drive::{Guess, is_reference};
use super::output;
use crate::Error;
use crate::audit::column::Column;
use crate::audit::friction::{Excited, Motion, Terms, excited};
use crate::audit::orders::{self, angle, floor, rate, smallest_line, turns};
use crate::audit::pairs::{self, COLLINEAR, correlation, lag};
use crate::audit::sessions::apart;
use crate::audit::times::Times;
use crate::study::statistics::mean_sd;
use crate::trace::reader::{self, Series};
use crate::trace::resample::unwrapped;
use crate::trace::{self, Condition, Labels, median, stem};

/// What recordings are worth: rate, gaps, held and saturated samples, lags, equal traces, the smallest line of an order
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Ends with exit code 1 if it finds something.\n\nExample:\n  bearing-watch audit drive.toml --json"
)]
pub(super) struct Args {
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

/// Runs the audit; returns whether something was found.
pub(super) fn run(args: &Args) -> Result<bool, Error> {
    if !(1e-9..=0.5).contains(&args.false_alarm) {
        return Err(Error::Usage("--false-alarm: give a rate from 1e-9 to 0.5".into()));
    }
    let folder = args.labels.iter().map(|labels| output::folder_of(labels).to_path_buf());
    let paths: Vec<PathBuf> = if args.traces.is_empty() { folder.collect() } else { args.traces.clone() };
    let files = trace::files(&paths)?;
    let bar = output::progress("auditing", files.len());
    let each = |file: &PathBuf| {
        let found = args.look(file);
        bar.inc(1);
        found
    };
    let all: Vec<Result<Vec<Audited>, Error>> = files.par_iter().map(each).collect();
    bar.finish_and_clear();
    let (mut traces, mut findings) = (Vec::new(), Vec::new());
    // A file that has no label and none of the channels is a table of something else.
    let labelled = args.labels.as_deref().map(Labels::read).transpose()?;
    let is_other = |file: &Path| {
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        labelled.as_ref().is_some_and(|labels| !labels.has(&name))
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
    if let Some(labels) = args.labels.as_ref().filter(|_| !args.conditions.is_empty()) {
        let chosen = Labels::read(labels)?.select(&args.conditions)?;
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
    let rotor = args.rotor_rate(&traces, &mut findings);
    let classes = args.classes(&traces)?;
    session_sets(&traces, &classes, &mut findings);
    let lines = args.lines(&traces, rotor);
    let terms = args.terms(&traces, &classes, rotor)?;
    if args.json {
        let mut value = to_json(&traces, &findings, rotor, &lines);
        value["friction"] = terms.iter().map(Excited::to_json).collect();
        output::json(&value)?;
    } else {
        print(&traces, &findings, rotor, (&lines, &terms, args.false_alarm))?;
    }
    Ok(!findings.is_empty())
}

fn add(findings: &mut Vec<Finding>, what: String, trace: &str) {
    match findings.iter_mut().find(|finding| finding.what == what) {
        Some(finding) => finding.traces.push(trace.to_string()),
        None => findings.push(Finding { what, traces: vec![trace.to_string()] }),
    }
}

impl Args {
    fn look(&self, file: &Path) -> Result<Vec<Audited>, Error> {
        let time = self.times.time.as_deref();
        let (names, _) = reader::numeric(file, time)?;
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
        let read = reader::series(file, (time, self.times.rate_hz), &channels)?;
        let recorded = reader::has_time(file, time);
        let each = |series: Series| {
            let mut values = series.columns;
            let mut further = values.split_off(names.len()).into_iter();
            let [current, velocity, angle, velocity_ref, load] =
                chosen.clone().map(|channel| channel.and_then(|_| further.next()));
            Audited {
                id: stem(&series.id).to_string(),
                names: names.clone(),
                times: series.times_s.as_deref().filter(|_| recorded).and_then(Times::of),
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

    /// The class of each trace; empty without labels, and for a trace that has none.
    fn classes(&self, traces: &[Audited]) -> Result<Vec<String>, Error> {
        let Some(path) = &self.labels else { return Ok(vec![]) };
        Labels::read(path)?.cells("class_name", traces.iter().map(|trace| trace.id.as_str()))
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
                rate_hz: trace.times.map(|times| times.rate_hz).or(rotor).or(self.times.rate_hz)?,
            };
            Some((Terms::of(&motion)?, is_healthy(k)))
        };
        let all: Vec<(Terms, bool)> = traces.par_iter().enumerate().filter_map(each).collect();
        Ok(excited(&all, self.false_alarm))
    }

    /// Floor, smallest line and turns of each trace with a signal and an angle.
    fn lines(&self, traces: &[Audited], rotor: Option<f64>) -> Vec<Line> {
        let each = |trace: &Audited| {
            let y = trace.current.as_deref()?;
            let rate_hz = trace.times.map(|times| times.rate_hz).or(rotor).or(self.times.rate_hz);
            let integrated = || Some(angle(trace.velocity.as_deref()?, rate_hz?));
            let angle = trace.angle.as_ref().map(|angle| unwrapped(angle, TAU)).or_else(integrated)?;
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

impl Audited {
    fn findings(&self, findings: &mut Vec<Finding>) {
        let id = &self.id;
        if let Some(Times { jitter, gaps, longest_gap_s, standing, rate_hz }) = self.times {
            if jitter > 0.05 {
                add(findings, "irregular times (jitter above 5 % of a step); resample".into(), id);
            }
            if gaps > 0 {
                add(findings, format!("gaps in time, up to {:.0} steps", longest_gap_s * rate_hz), id);
            }
            if standing > 0 {
                add(findings, "times that stand; several rows have one time".into(), id);
            }
        }
        // What is wanted rather than measured may stand, and have few values.
        let measured = self.names.iter().zip(&self.columns).filter(|(name, _)| !is_reference(name));
        for (name, column) in measured {
            for finding in column.findings() {
                add(findings, format!("column {name}: {finding}"), id);
            }
        }
        for (k, one) in self.values.iter().enumerate() {
            for (j, other) in self.values.iter().enumerate().take(k) {
                let found = correlation(one, other);
                if found.abs() > COLLINEAR {
                    add(findings, format!("columns {} and {} say the same", self.names[j], self.names[k]), id);
                }
            }
        }
        if let (Some(velocity), Some(angle)) = (&self.velocity, &self.angle) {
            // A difference is half a row later than the first of its two angles.
            let differences: Vec<f64> = unwrapped(angle, TAU).windows(2).map(|pair| pair[1] - pair[0]).collect();
            if let Some((rows, _)) = lag(&differences, velocity).filter(|(rows, _)| (rows - 0.5).abs() > 0.75) {
                add(findings, format!("the velocity comes {rows:.1} rows after the angle's differences"), id);
            }
        }
        if let (Some(y), Some(u)) = (&self.current, self.velocity_ref.as_ref().or(self.velocity.as_ref()))
            && let (mean, deviation) = mean_sd(u)
            && deviation < 1e-3 * mean.abs()
            && mean_sd(y).1 > 0.0
        {
            add(findings, "constant speed: inertia and friction cannot be told apart".into(), id);
        }
    }
}

/// Finds classes that differ in what no bearing changes.
fn session_sets(traces: &[Audited], classes: &[String], findings: &mut Vec<Finding>) {
    if classes.is_empty() {
        return;
    }
    let mean = |signal: &Option<Vec<f64>>| signal.as_ref().map_or(f64::NAN, |signal| mean_sd(signal).0);
    let step = |trace: &Audited, name: &str| {
        let place = trace.names.iter().position(|own| own == name);
        place.map_or(f64::NAN, |place| trace.columns[place].step)
    };
    let time = |of: fn(&Times) -> f64| move |trace: &Audited| trace.times.as_ref().map_or(f64::NAN, of);
    let mut compare = |property: &str, of: &dyn Fn(&Audited) -> f64, size: Option<f64>| {
        let values: Vec<f64> = traces.iter().map(of).collect();
        let known: Vec<f64> =
            values.iter().zip(classes).map(|(x, class)| if class.is_empty() { f64::NAN } else { *x }).collect();
        for found in apart(property, (&known, size), classes) {
            add(findings, found.to_string(), "all of both");
        }
    };
    compare("the rate", &time(|times| times.rate_hz), None);
    compare("the jitter of the times", &time(|times| times.jitter), None);
    compare("the number of rows", &|trace| trace.values.first().map_or(f64::NAN, |column| column.len() as f64), None);
    // Of a controlled velocity the reference says what was asked for; the friction changes the velocity itself.
    let asked: fn(&Audited) -> &Option<Vec<f64>> =
        if traces.iter().any(|trace| trace.velocity_ref.is_some()) { |t| &t.velocity_ref } else { |t| &t.velocity };
    let sizes: Vec<f64> = traces.iter().filter_map(|trace| asked(trace).as_deref()).map(largest).collect();
    compare("the mean speed", &|trace| mean(asked(trace)), Some(median(&sizes)));
    for name in &traces[0].names {
        compare(&format!("the step of {name}"), &|trace| step(trace, name), None);
    }
}

/// The largest magnitude.
fn largest(signal: &[f64]) -> f64 {
    signal.iter().fold(0.0, |most, x| x.abs().max(most))
}

fn equal_traces(traces: &[Audited], findings: &mut Vec<Finding>) {
    let columns: Vec<&[Vec<f64>]> = traces.iter().map(|trace| trace.values.as_slice()).collect();
    for [one, other] in pairs::equal(&columns) {
        let what = format!("the same recording as {}", traces[one].id);
        add(findings, what, &traces[other].id);
    }
}

fn print(
    traces: &[Audited],
    findings: &[Finding],
    rotor: Option<f64>,
    (lines, terms, false_alarm): (&[Line], &[Excited], f64),
) -> Result<(), Error> {
    let rows: usize = traces.iter().map(|trace| trace.values.first().map_or(0, Vec::len)).sum();
    output::say(format!("{} traces, {rows} rows", traces.len()))?;
    let rates: Vec<f64> = traces.iter().filter_map(|trace| trace.times).map(|times| times.rate_hz).collect();
    match (rates.is_empty(), rotor) {
        (false, _) => {
            let jitters: Vec<f64> = traces.iter().filter_map(|trace| trace.times).map(|times| times.jitter).collect();
            let (rate, jitter) = (median(&rates), 100.0 * median(&jitters));
            output::say(format!("rate: {rate:.4} rows a second, steps scatter by {jitter:.2} %"))?;
        }
        (true, Some(rate)) => output::say(format!("rate: no time; {rate:.1} rows a second by the lines of the rotor"))?,
        (true, None) => output::say("rate: no time column; give --rate-hz")?,
    }
    let first = &traces[0];
    let width = first.names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max("column".len());
    let head = format!(
        "{:width$}  {:>12}  {:>12}  {:>12}  {:>12}  {:>12}",
        "column", "mean", "deviation", "least", "largest", "step"
    );
    output::say(format!("\n{head}   ({})", first.id))?;
    for (name, column) in first.names.iter().zip(&first.columns) {
        let Column { mean, deviation, range: [least, largest], step, .. } = column;
        output::say(format!(
            "{name:width$}  {mean:>12.5}  {deviation:>12.5}  {least:>12.5}  {largest:>12.5}  {step:>12.3e}"
        ))?;
    }
    if !lines.is_empty() {
        let all = |pick: fn(&Line) -> f64| median(&lines.iter().map(pick).collect::<Vec<_>>());
        let (turns, floor, smallest) = (all(|line| line.turns), all(|line| line.floor), all(|line| line.smallest));
        output::say(format!(
            "\nlines of orders, median of {} traces of {turns:.0} turns: floor {floor:.4}; a line of {smallest:.4} stands \
             out at a false-alarm rate of {false_alarm} (units of the current)",
            lines.len()
        ))?;
        let firsts: Vec<f64> = lines.iter().map(|line| line.first / line.floor).collect();
        let most = firsts.iter().copied().fold(0.0, f64::max);
        output::say(format!("order 1 over the floor: median {:.1}, largest {most:.1}", median(&firsts)))?;
    }
    if !terms.is_empty() {
        output::say(format!("\nfriction and inertia, at a false-alarm rate of {false_alarm} (units of the current)"))?;
        output::say(Excited::heading())?;
        terms.iter().try_for_each(|term| output::say(term.to_string()))?;
    }
    output::say(if findings.is_empty() { "\nnothing found" } else { "\nfound:" })?;
    for Finding { what, traces: own } in findings {
        let which = match &own[..] {
            [one] => one.clone(),
            [first, ..] => format!("{} traces, first {first}", own.len()),
            [] => String::new(),
        };
        output::say(format!("  {what}: {which}"))?;
    }
    Ok(())
}

fn to_json(traces: &[Audited], findings: &[Finding], rotor: Option<f64>, lines: &[Line]) -> Value {
    let column = |(name, column): (&String, &Column)| {
        let Column { mean, deviation, range: [least, largest], step, every, changing, held, saturated } = column;
        json!({
            "column": name, "mean": mean, "deviation": deviation, "least": least, "largest": largest, "step": step,
            "changes_every_rows": every, "changing": changing, "held": held, "saturated": saturated
        })
    };
    let trace = |trace: &Audited| {
        let times = trace.times.map(|times| {
            json!({
                "rate_hz": times.rate_hz, "jitter": times.jitter, "gaps": times.gaps,
                "longest_gap_s": times.longest_gap_s, "standing": times.standing
            })
        });
        json!({
            "trace": trace.id, "rows": trace.values.first().map_or(0, Vec::len), "times": times,
            "columns": trace.names.iter().zip(&trace.columns).map(column).collect::<Vec<_>>()
        })
    };
    let line = |line: &Line| {
        json!({
            "trace": line.trace, "turns": line.turns, "floor": line.floor, "smallest_line": line.smallest,
            "order_1": line.first
        })
    };
    let finding = |finding: &Finding| json!({ "finding": finding.what, "traces": finding.traces });
    json!({
        "rotor_rate_hz": rotor,
        "traces": traces.iter().map(trace).collect::<Vec<_>>(),
        "lines": lines.iter().map(line).collect::<Vec<_>>(),
        "findings": findings.iter().map(finding).collect::<Vec<_>>(),
    })
}
