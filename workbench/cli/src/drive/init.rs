//! `bearing-watch init`: writes a `drive.toml` by looking at recordings.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::guess::Guess;
use super::names;
use super::proposal::{Proposal, Values};
use super::schema::{SECTIONS, section_of};
use crate::args::traces::TimeArgs;
use crate::output;
use model::Error;
use model::audit::times::Times;
use model::trace::labels::Labels;
use pages::page::counted;
use traces::reader;
use traces::table::Table;

/// Write drive.toml: columns, rate, labels and likely channels, by looking at the files
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch init recordings\n  bearing-watch train recordings/drive.toml --model m.bwm"
)]
pub(crate) struct Args {
    /// Trace files or folders
    #[arg(value_name = "TRACES", required = true)]
    traces: Vec<PathBuf>,
    /// Labels, if they are not the labels.csv beside the traces
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
    /// Where labels are written if there are none; by default labels.csv beside the drive file. The words of a file's
    /// name are its class: unbalanced_800_3.csv is unbalanced. If no two classes follow, all files are healthy
    #[arg(long, value_name = "FILE", conflicts_with = "labels")]
    labels_from_names: Option<PathBuf>,
    #[command(flatten)]
    pub(super) times: TimeArgs,
    /// The file; by default drive.toml in the folder of the first trace, or here if that cannot be written
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace the file if it exists
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let folder = folder_of(&args.traces[0]);
    let out = args.out.clone().unwrap_or_else(|| {
        let writable = tempfile::tempfile_in(&folder).is_ok();
        if writable { folder.join("drive.toml") } else { "drive.toml".into() }
    });
    let files = traces::files(&args.traces)?;
    output::plan(&[&out], &files)?;
    if out.exists() && !args.force {
        return Err(Error::Usage(format!("{} exists; give another name with --out, or --force", out.display())));
    }
    let found = Found::look(args, &files, (&folder, &out))?;
    output::write(&out, found.text(&out, args))?;
    output::say(found.told(&out))
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
            match Table::open(file).and_then(|table| reader::numeric(&table, time)) {
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

    /// The kind of most files, with the files of others that have its channels; of equals one with a current, then the
    /// first.
    fn most(kinds: Vec<Self>) -> Option<Self> {
        let current = |kind: &Self| usize::from(Guess::of(&kind.names).current.is_some());
        let most = (0..kinds.len()).rev().max_by_key(|&k| (kinds[k].files.len(), current(&kinds[k])))?;
        let mut kinds = kinds;
        let mut own = kinds.swap_remove(most);
        for other in kinds {
            let shared: Vec<String> = own.names.iter().filter(|name| other.names.contains(name)).cloned().collect();
            if !shared.is_empty() && Proposal::of(&shared).stands_for(&Proposal::of(&own.names)) {
                own.names = shared;
                own.files.extend(other.files);
            }
        }
        own.files.sort_unstable();
        Some(own)
    }
}

/// What the files have.
pub(super) struct Found {
    /// Number of files of the kind that is described, and of others.
    pub(super) files: usize,
    others: usize,
    /// What the drive file names.
    pub(super) traces: Vec<PathBuf>,
    /// Why the time is not used.
    pub(super) disorder: Option<String>,
    names: Vec<String>,
    /// Rows of the first trace, and rows a second.
    pub(super) rows: usize,
    pub(super) rate_hz: Option<f64>,
    /// Whether the velocity of the first trace is constant.
    pub(super) is_constant: bool,
    /// File and content of the labels, and the classes.
    pub(super) labels: (PathBuf, Labels, Vec<String>),
    /// How the labels were made, if they were.
    made: Option<&'static str>,
    pub(super) proposal: Proposal,
}

impl Found {
    fn look(args: &Args, files: &[PathBuf], (folder, out): (&Path, &Path)) -> Result<Self, Error> {
        let time = args.times.time.as_deref();
        let (kinds, problem) = Kind::of(files, time);
        let Some(own) = Kind::most(kinds) else {
            return Err(problem.unwrap_or_else(|| {
                let paths: Vec<String> = args.traces.iter().map(|path| path.display().to_string()).collect();
                Error::Usage(format!("no file with columns of numbers in {}", paths.join(", ")))
            }));
        };
        let (names, proposal) = (own.names.clone(), Proposal::of(&own.names));
        // A single file among others of other kinds is named; several are found by their columns.
        let traces = if own.files.len() == 1 && files.len() > 1 { own.files.clone() } else { args.traces.clone() };
        let table = Table::open(&own.files[0])?;
        let read = |time: Option<&str>| reader::series(&table, (time, args.times.rate_hz), &names);
        let (series, disorder) = match read(time) {
            Err(problem) if time.is_none() => (read(Some(reader::NO_TIME))?, Some(problem.to_string())),
            other => (other?, None),
        };
        let first = series.first();
        let rows = first.map_or(0, |one| one.columns[0].len());
        let rate_hz = first.and_then(|one| Times::of(one.times_s.as_deref()?)).map(|times| times.rate_hz);
        let is_constant = first.is_some_and(|one| proposal.is_constant(&names, &one.columns));
        let beside = Some(folder.join("labels.csv")).filter(|file| file.is_file());
        let given = args.labels.clone().or(beside.filter(|_| args.labels_from_names.is_none()));
        let (file, made) = match given {
            Some(file) => (file, None),
            None => {
                let (text, told) = names::labels(&own.files)?;
                let own_file = || output::folder_of(out).join("labels.csv");
                let file = args.labels_from_names.clone().unwrap_or_else(own_file);
                output::plan(&[&file, out], files)?;
                output::write(&file, text)?;
                (
                    file,
                    Some(if told { "by the names of the files" } else { "all healthy, since no name tells a class" }),
                )
            }
        };
        let labels = traces::read_labels(&file)?;
        let classes = labels.classes(&labels.select(&[])?, &[])?;
        let (labels, others) = ((file, labels, classes), files.len() - own.files.len());
        let files = own.files.len();
        Ok(Self { files, others, traces, disorder, names, rows, rate_hz, is_constant, labels, made, proposal })
    }

    fn text(&self, out: &Path, args: &Args) -> String {
        let Values { values, refused } = Values::of(self, out, args);
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
        let (_, labels, classes) = &self.labels;
        let columns = labels.columns().join(", ");
        let _never_fails = writeln!(text, "# Labels: {columns}; classes {}", classes.join(", "));
        for section in &SECTIONS {
            let _never_fails = writeln!(text, "\n# {}\n[{}]", section.about, section.name);
            for (key, hint) in section.keys.iter().map(|key| (key, hint(key))) {
                let hint = refused.get(key).map(String::as_str).or(hint);
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
        let Guess { current, velocity, velocity_ref, angle, load, .. } = &self.proposal.guess;
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
        let (file, ..) = &self.labels;
        let made = self.made.map_or_else(String::new, |how| format!(" {}: {how}.", file.display()));
        let rate = if self.rate_hz.is_none() { " The files have no time: set rate_hz." } else { "" };
        format!(
            "{}: {}; {}. Check the channels and their signs.{made}{rate}",
            out.display(),
            counted(self.files, "file"),
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
        "rate_hz" => "1000  # if the files have no time; audit checks it by the lines of the rotor",
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
