//! `bearing-watch init`: writes a `drive.toml` by looking at recordings.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::expand::literal;
use super::guess::Guess;
use super::schema::{SECTIONS, section_of};
use crate::Error;
use crate::audit::times::Times;
use crate::cli::args::traces::TimeArgs;
use crate::cli::output;
use crate::trace::labels::Labels;
use crate::trace::{self, reader, stem};
use crate::train::novelty::runs::fewest;

/// Write drive.toml: columns, rate, labels and likely channels, by looking at the files
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch init recordings\n  bearing-watch train recordings/drive.toml --model m.bwm"
)]
pub(in crate::cli) struct Args {
    /// Trace files or folders
    #[arg(value_name = "TRACES", required = true)]
    traces: Vec<PathBuf>,
    /// Labels, if they are not the labels.csv beside the traces
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
    /// Write labels here first, with the words of each file's name as its class: unbalanced_800_3.csv is unbalanced
    #[arg(long, value_name = "FILE", conflicts_with = "labels")]
    labels_from_names: Option<PathBuf>,
    #[command(flatten)]
    times: TimeArgs,
    /// The file; by default drive.toml in the folder of the first trace, or here if that cannot be written
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace the file if it exists
    #[arg(long)]
    force: bool,
}

/// Words of names that say what a file is for, not what it shows.
const SETS: [&str; 5] = ["test", "train", "training", "validation", "log"];
/// The usual false-alarm rate of a gate.
const RATE: f64 = 0.01;
/// Class names of machines without a defect.
const HEALTHY: [&str; 6] = ["healthy", "normal", "good", "ok", "nominal", "baseline"];
/// Columns of labels whose rows of one value are of one run.
const GROUPS: [&str; 6] = ["run", "session", "unit", "drive", "day", "batch"];

pub(in crate::cli) fn run(args: &Args) -> Result<(), Error> {
    let folder = folder_of(&args.traces[0]);
    let out = args.out.clone().unwrap_or_else(|| {
        let writable = tempfile::tempfile_in(&folder).is_ok();
        if writable { folder.join("drive.toml") } else { "drive.toml".into() }
    });
    let files = trace::files(&args.traces)?;
    output::plan(&[&out], &files)?;
    if out.exists() && !args.force {
        return Err(Error::Usage(format!("{} exists; give another name with --out, or --force", out.display())));
    }
    if let Some(labels) = &args.labels_from_names {
        output::plan(&[labels, &out], &files)?;
        output::write(labels, labels_of(&files)?)?;
    }
    let found = Found::look(args, &files, &folder)?;
    output::write(&out, found.text(&out, args))?;
    output::say(found.told(&out))
}

/// Labels of files by the words of their names, in lower case; numbers are no words.
fn labels_of(files: &[PathBuf]) -> Result<String, Error> {
    let mut rows = vec![vec!["trace".to_string(), "class_name".to_string()]];
    for file in files {
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let lower = stem(&name).to_lowercase();
        let words = lower.split(|c: char| !c.is_alphabetic()).filter(|word| word.len() > 1 && !SETS.contains(word));
        let class = words.collect::<Vec<_>>().join("_");
        rows.push(vec![stem(&name).to_string(), if class.is_empty() { "unnamed".into() } else { class }]);
    }
    output::csv(&rows)
}

fn folder_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.to_path_buf() } else { output::folder_of(path).to_path_buf() }
}

/// Files with the same columns of numbers.
struct Kind {
    names: Vec<String>,
    files: Vec<PathBuf>,
}

impl Kind {
    /// The kinds of files, and the first problem with one.
    fn of(files: &[PathBuf], time: Option<&str>) -> (Vec<Self>, Option<Error>) {
        let (mut kinds, mut problem): (Vec<Self>, _) = (Vec::new(), None);
        let bar = output::progress("files", files.len());
        for file in files {
            match reader::numeric(file, time) {
                Ok((names, _)) if names.is_empty() => {}
                Ok((names, _)) => match kinds.iter_mut().find(|kind| kind.names == names) {
                    Some(kind) => kind.files.push(file.clone()),
                    None => kinds.push(Self { names, files: vec![file.clone()] }),
                },
                Err(error) => problem = problem.or(Some(error)),
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        (kinds, problem)
    }
}

/// What the files have.
struct Found {
    /// Number of files of the kind that is described, and of others.
    files: usize,
    others: usize,
    /// What the drive file names.
    traces: Vec<PathBuf>,
    /// Why the time is not used.
    disorder: Option<String>,
    names: Vec<String>,
    guess: Guess,
    /// Rows of the first trace, and rows a second.
    rows: usize,
    rate_hz: Option<f64>,
    /// File and content of the labels, and the classes.
    labels: Option<(PathBuf, Labels, Vec<String>)>,
}

impl Found {
    fn look(args: &Args, files: &[PathBuf], folder: &Path) -> Result<Self, Error> {
        let time = args.times.time.as_deref();
        let (kinds, problem) = Kind::of(files, time);
        // The kind of most files; of equals one with a current, then the first.
        let current = |kind: &Kind| usize::from(Guess::of(&kind.names).current.is_some());
        let Some(own) = kinds.iter().rev().max_by_key(|kind| (kind.files.len(), current(kind))) else {
            return Err(problem.unwrap_or_else(|| {
                let paths: Vec<String> = args.traces.iter().map(|path| path.display().to_string()).collect();
                Error::Usage(format!("no file with columns of numbers in {}", paths.join(", ")))
            }));
        };
        let names = own.names.clone();
        // A single file among others of other kinds is named; several are found by their columns.
        let traces = if own.files.len() == 1 && files.len() > 1 { own.files.clone() } else { args.traces.clone() };
        let read = |time: Option<&str>| reader::series(&own.files[0], (time, args.times.rate_hz), &names);
        let (series, disorder) = match read(time) {
            Err(problem) if time.is_none() => (read(Some(reader::NO_TIME))?, Some(problem.to_string())),
            other => (other?, None),
        };
        let rows = series.first().map_or(0, |one| one.columns[0].len());
        let rate_hz = series.first().and_then(|one| Times::of(one.times_s.as_deref()?)).map(|times| times.rate_hz);
        let beside = Some(folder.join("labels.csv")).filter(|file| file.is_file());
        let labels = args.labels.clone().or_else(|| args.labels_from_names.clone()).or(beside).map(|file| {
            let labels = Labels::read(&file)?;
            let classes = labels.classes(&labels.select(&[])?, &[])?;
            Ok::<_, Error>((file, labels, classes))
        });
        let guess = Guess::of(&names);
        let others = files.len() - own.files.len();
        let files = own.files.len();
        Ok(Self { files, others, traces, names, guess, rows, rate_hz, disorder, labels: labels.transpose()? })
    }

    /// The value of each key that is known; and the healthy class with why it cannot be used, if it cannot.
    fn values(&self, out: &Path, args: &Args) -> (BTreeMap<&'static str, String>, Option<String>) {
        let (mut values, mut refused) = (BTreeMap::new(), None);
        let text = literal;
        let from_here = |path: &Path| super::expand::from_here(out, "traces", &path.to_string_lossy());
        let paths: Vec<String> = self.traces.iter().map(|path| text(&from_here(path))).collect();
        values.insert("traces", format!("[{}]", paths.join(", ")));
        let none = self.disorder.as_ref().map(|_| reader::NO_TIME.to_string());
        if let Some(time) = args.times.time.as_ref().or(none.as_ref()) {
            values.insert("time", text(time));
        }
        if let Some(rate) = args.times.rate_hz {
            values.insert("rate_hz", rate.to_string());
        }
        let Guess { current, velocity, velocity_ref, current_ref, angle, load } = &self.guess;
        let mut channel = |key: &'static str, found: &Option<String>| {
            if let Some(found) = found {
                values.insert(key, text(found));
            }
        };
        channel("angle", angle);
        if angle.is_some() {
            channel("velocity", velocity);
            channel("load", load);
            channel("velocity_ref", velocity_ref);
        }
        // Without a reference of the velocity, the current drives the velocity.
        let by_reference = velocity_ref.is_some() && velocity.is_some() || current.is_none() || velocity.is_none();
        let input = match (velocity_ref, velocity) {
            (Some(reference), Some(velocity)) => Some(format!("{reference}-{velocity}")),
            (reference, velocity) => reference.clone().or_else(|| velocity.clone()),
        };
        let of_current = current_ref.clone().or_else(|| current.clone());
        let (y, u1) = if by_reference { (current.clone(), input) } else { (velocity.clone(), of_current) };
        if y.is_some() && u1.is_some() {
            channel("y", &y);
            channel("u1", &u1);
        }
        channel("u2", load);
        if angle.is_some() && !by_reference {
            channel("current", current);
        }
        values.insert("order", (if load.is_some() { "[2, 2, 2, 1, 1]" } else { "[2, 2, 0, 1, 1]" }).into());
        values.insert("offset", "true".into());
        if let Some((file, labels, classes)) = &self.labels {
            values.insert("labels", text(&from_here(file)));
            let is_named = |name: &&String| HEALTHY.contains(&name.to_lowercase().as_str());
            let has_word = |name: &&String| HEALTHY.iter().any(|word| name.to_lowercase().contains(word));
            let healthy = classes.iter().find(is_named).or_else(|| classes.iter().find(has_word));
            let group = GROUPS.iter().find(|group| labels.columns().iter().any(|column| column == *group));
            if let Some(healthy) = healthy {
                values.insert("healthy", text(healthy));
                values.insert("nominal", text(healthy));
            }
            if let Some(group) = group {
                values.insert("group", text(group));
            }
            let coordinates = if load.is_some() { 7 } else { 5 };
            let (runs, least) = (group.map(|group| labels.different(group)), fewest(coordinates, RATE));
            if let (Some(healthy), Some(runs)) = (healthy, runs.filter(|runs| *runs < least)) {
                values.remove("healthy");
                let why = format!("{runs} runs support no false-alarm rate of {RATE} with {coordinates} features");
                refused = Some(format!("{}  # {why}; at least {least} do", text(healthy)));
            }
        }
        (values, refused)
    }

    fn text(&self, out: &Path, args: &Args) -> String {
        let (values, refused) = self.values(out, args);
        let mut text =
            String::from("# What this drive is. Every command takes this file: bearing-watch train drive.toml …\n");
        let rate = match self.rate_hz {
            Some(rate_hz) => format!("{rate_hz:.6} rows a second"),
            None => "no time column: set rate_hz".to_string(),
        };
        let _never_fails = writeln!(text, "# Found: {} files, {} rows in the first, {rate}", self.files, self.rows);
        if self.others > 0 {
            let _never_fails = writeln!(text, "# {} files have other columns", self.others);
        }
        if let Some(problem) = &self.disorder {
            let _never_fails = writeln!(text, "# The time is not used: {problem}");
        }
        let _never_fails = writeln!(text, "# Columns: {}", self.names.join(", "));
        if let Some((_, labels, classes)) = &self.labels {
            let columns = labels.columns().join(", ");
            let _never_fails = writeln!(text, "# Labels: {columns}; classes {}", classes.join(", "));
        }
        for section in &SECTIONS {
            let _never_fails = writeln!(text, "\n# {}\n[{}]", section.about, section.name);
            for (key, hint) in section.keys.iter().map(|key| (key, hint(key))) {
                let hint = refused.as_deref().filter(|_| *key == "healthy").or(hint);
                match (values.get(key), hint) {
                    (Some(value), _) => drop(writeln!(text, "{key} = {value}")),
                    (None, Some(hint)) => drop(writeln!(text, "# {key} = {hint}")),
                    (None, None) => {}
                }
            }
        }
        text
    }

    fn told(&self, out: &Path) -> String {
        let Guess { current, velocity, velocity_ref, angle, load, .. } = &self.guess;
        let all = [
            ("current", current),
            ("velocity", velocity),
            ("reference", velocity_ref),
            ("angle", angle),
            ("load", load),
        ];
        let said = all.iter().map(|(what, found)| match found {
            Some(name) => format!("{what} {name}"),
            None => format!("no {what}"),
        });
        format!(
            "{}: {} files; {}. Check the channels and their signs.",
            out.display(),
            self.files,
            said.collect::<Vec<_>>().join(", ")
        )
    }
}

/// An example of a value, for a comment where none was found.
fn hint(key: &str) -> Option<&'static str> {
    debug_assert!(section_of(key).is_some(), "{key}");
    Some(match key {
        "labels" => "\"labels.csv\"  # trace,class_name and further columns",
        "where" => "[\"load_kgf=20\"]",
        "rate_hz" => "1000  # if the files have no time",
        "y" => "\"current_a\"  # output: a column, or a formula of columns",
        "u1" => "\"velocity_ref_rad_s-velocity_rad_s\"  # input",
        "u2" => "\"load_torque_nm\"  # a second input",
        "angle" => "\"angle_rad\"  # of the shaft: watches friction and bearing orders",
        "orders" => "{ outer = 3.58, inner = 5.41 }",
        "bearing" => "[9, 3, 17, 0.1745]  # balls, ball and pitch diameter, contact angle in rad",
        "block_mean" => "4  # average blocks of samples first",
        "features" => "[\"a\", \"b\", \"c\"]",
        "covariates" => "[\"mean_temperature_c\"]",
        "projection" => "\"pca\"",
        "discriminant" => "\"shrunk\"",
        "train_where" => "[\"run<=4\"]",
        "test_where" => "[\"run>4\"]",
        "group" => "\"run\"  # records with the same value are of one run",
        "healthy" => "\"healthy\"",
        "false_alarm" => "0.01  # of healthy segments",
        _ => return None,
    })
}
