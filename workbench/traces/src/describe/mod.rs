//! Describes recordings: columns, rate, labels and likely channels, as the text of a drive file.
//!
//! ```text
//! files ─► found: columns, rows, rate, labels ─► proposal: channels ─► values ─► drive.toml
//! ```

mod asked;
pub(crate) mod axes;
#[cfg(test)]
mod combinations;
pub(crate) mod found;
pub(crate) mod guess;
mod kinds;
mod names;
mod proposal;
mod raw;
mod remembered;
mod report;
mod trial;
mod values;
mod words;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

pub use asked::Asked;
use found::Found;
use guess::Guess;
use kinds::LeftOut;
use names::{REFERENCE, Told};
pub use report::Question;
use serde_json::Value;
use trial::Outcome;
use values::Values;

use crate::listing::Listing;
use model::Error;
use model::outputs;
use model::session::Log;
use model::settings::{TIMES, Use, sections};

/// The settings that it takes.
pub const USE: Use = Use { name: "init", keys: &[&["traces"], TIMES], required: &["traces"] };

/// A drive file that was written.
#[derive(Clone, Debug)]
pub struct Described {
    /// The file.
    pub file: PathBuf,
    /// What was found, in a line.
    pub told: String,
    /// What the user has to say, which `told` has too.
    pub question: Option<String>,
    /// The same, with what the answers are and where they are written.
    pub questions: Vec<Question>,
    /// Why training refuses the file, if it does.
    pub refused: Option<String>,
    /// The labels, and the columns of the first recording, as JSON.
    recordings: Value,
}

impl Described {
    /// The same if training takes the file.
    ///
    /// # Errors
    /// It refuses it; the file is written.
    pub fn accepted(self) -> Result<Self, Error> {
        let Some(reason) = &self.refused else { return Ok(self) };
        let what = "it is written, but training refuses it; edit it, or bring other recordings";
        Err(Error::Training(format!("{} {what}: {reason}", self.told)))
    }
}

/// Writes a drive file by looking at recordings, and their labels if there are none.
///
/// # Errors
/// No file with columns of numbers, labels that do not fit, or a drive file that exists. That training refuses the file
/// is none, see [`Described::accepted`].
pub fn describe(asked: &Asked<'_>, log: &Log<'_>) -> Result<Described, Error> {
    let traces = &asked.data.traces;
    let first = traces.first().ok_or_else(|| Error::Usage("no traces are given".into()))?;
    let folder = folder_of(first);
    let out = asked.out.map_or_else(
        || {
            let writable = outputs::temporary(&folder.join("drive.toml")).is_ok();
            if writable { folder.join("drive.toml") } else { "drive.toml".into() }
        },
        Path::to_path_buf,
    );
    let listing = Listing::without_labels(traces, None)?;
    if listing.candidates.is_empty() && !listing.left_out.is_empty() {
        let (folder, left) = (folder.display(), listing.left_out.join("; "));
        return Err(Error::Usage(format!("no recording can be read in {folder}: {left}")));
    }
    log.warn(listing.left_out.iter().cloned());
    let files = listing.files();
    // A relative file is beside the drive file, as the drive file names it.
    let front_end = asked.front_end.map(|file| outputs::folder_of(&out).join(file));
    let written: Vec<&Path> = [Some(out.as_path()), front_end.as_deref()].into_iter().flatten().collect();
    outputs::plan(&written, &files)?;
    if let Some(file) = written.iter().find(|file| file.exists() && !asked.force) {
        return Err(Error::Usage(format!("{} exists; give another name, or --force", file.display())));
    }
    let found = Found::look(asked, &files, (&folder, &out), log)?;
    if let (Some(file), Some(raw)) = (&front_end, &found.front_end) {
        outputs::write(file, raw.text.clone())?;
        log.warn(raw.said.iter().map(|said| format!("{}: {said}", file.display())));
    }
    let mut values = Values::of(&found, &out, (asked.data, front_end.as_deref()));
    let outcome = trial::tried(&found, &mut values, (&out, &|values| text(&found, values, None)));
    let note = match &outcome {
        Outcome::Accepted(note) => note.clone(),
        Outcome::Refused(reason) => Some(format!("training refuses this: {reason}")),
        Outcome::Untried => Some("training was not tried, since the files are large".into()),
    };
    values.asked(&found);
    outputs::write(&out, text(&found, &values, note.as_deref()))?;
    let left = found.left.iter().map(LeftOut::told).chain(found.columns_left.iter().cloned());
    log.warn(left.map(|left| format!("left out {left}")));
    let open = open(&found);
    log.warn(found.doubts.iter().filter(|doubt| !open.contains(doubt)).cloned());
    let questions: Vec<String> =
        found.made.filter(|told| *told == Told::Nothing).map(made).into_iter().chain(open).collect();
    let question = (!questions.is_empty()).then(|| questions.join(" "));
    let mut told = told(&found, &out);
    let refused = match outcome {
        Outcome::Refused(reason) => {
            told.extend(found.doubts.iter().map(|doubt| format!(" Note: {doubt}.")));
            Some(reason)
        }
        _ => {
            told += &note.map_or_else(String::new, |note| format!(" Note: {note}."));
            None
        }
    };
    let questions = report::questions(&found);
    Ok(Described { told, question, questions, refused, recordings: report::recordings(&found), file: out })
}

fn folder_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.to_path_buf() } else { outputs::folder_of(path).to_path_buf() }
}

fn text(found: &Found, Values { values, refused }: &Values, note: Option<&str>) -> String {
    let mut text =
        String::from("# What this drive is. Every command takes this file: bearing-watch train drive.toml …\n");
    let rate = match found.rate_hz {
        Some(rate_hz) => format!("{rate_hz:.6} rows a second"),
        None => "no time column: set rate_hz".to_string(),
    };
    let _never_fails = writeln!(text, "# Found: {} files, {} rows in the first, {rate}", found.files, found.rows);
    for left in found.left.iter().map(LeftOut::told).chain(found.columns_left.iter().cloned()) {
        let _never_fails = writeln!(text, "# Left out: {}", one_line(&left));
    }
    if let Some(problem) = &found.disorder {
        let _never_fails = writeln!(text, "# The time is not used: {problem}");
    }
    if let Some(note) = note {
        let _never_fails = writeln!(text, "# {}", one_line(note));
    }
    for doubt in &found.doubts {
        let _never_fails = writeln!(text, "# {}", one_line(doubt));
    }
    let _never_fails = writeln!(text, "# Columns: {}", found.names.join(", "));
    let (_, labels, classes) = &found.labels;
    let columns = labels.columns().join(", ");
    let _never_fails = writeln!(text, "# Labels: {columns}; classes {}", classes.join(", "));
    for section in sections() {
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

fn told(found: &Found, out: &Path) -> String {
    let Guess { current, velocity, velocity_ref, angle, load, .. } = &found.proposal.guess;
    let all =
        [("current", current), ("velocity", velocity), ("reference", velocity_ref), ("angle", angle), ("load", load)];
    let said = all.iter().map(|(what, found)| match found {
        Some(name) => format!("{what} {name}"),
        None => format!("no {what}"),
    });
    let (file, ..) = &found.labels;
    let made = found.made.map_or_else(String::new, |how| format!(" {}: {}.", file.display(), made(how)));
    let files = format!("{} file{}", found.files, if found.files == 1 { "" } else { "s" });
    let rate = if found.rate_hz.is_none() { " The files have no time: set rate_hz." } else { "" };
    let open = match &open(found)[..] {
        [] => String::new(),
        open => {
            format!(" Questions: {} Write the answer in the place of each ?; training waits for them.", open.join(" "))
        }
    };
    format!(
        "{}: {}; {}. Check the channels and their signs.{made}{rate}{open}",
        out.display(),
        files,
        said.collect::<Vec<_>>().join(", ")
    )
}

/// The questions about motors, units and numbers.
fn open(found: &Found) -> Vec<String> {
    let channels = [&found.turning.angle, &found.turning.velocity].into_iter().flatten();
    let units = channels.filter(|channel| channel.is_question()).filter_map(|channel| channel.said.clone());
    let axes = found.axes.iter().filter(|axes| axes.is_question()).map(|axes| axes.said.clone());
    let motors = (!found.motors.is_empty()).then(|| {
        let list = found.motors.join(", ");
        format!("the files are of several motors: which one has the bearing, {list}? All if they are alike.")
    });
    axes.chain(motors).chain(units).collect()
}

/// What labels that were made say.
fn made(told: Told) -> String {
    match told {
        Told::Folders => "classes by the folders".into(),
        Told::Names => "classes by the names of the files".into(),
        Told::Nothing => format!(
            "no name tells a class, so all are called {REFERENCE}. Which recordings are healthy? Fill in class_name; \
             until then a verdict says only whether a recording is like these"
        ),
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// An example of a value, for a comment where none was found.
fn hint(key: &str) -> Option<&'static str> {
    Some(match key {
        "labels" => "\"labels.csv\"  # trace,class_name and further columns",
        "where" => "[\"load_kgf=20\"]",
        "rate_hz" => "1000  # if the files have no time; audit checks it by the lines of the rotor",
        "y" => "\"current_a\"  # output: a column, or a formula of columns",
        "u1" => "\"velocity_ref_rad_s-velocity_rad_s\"  # input",
        "u2" => "\"load_torque_nm\"  # a second input",
        "angle" => "\"angle_rad\"  # of the shaft: watches friction and bearing orders",
        "orders" => "{ outer = 3.58, inner = 5.41 }",
        "bearing" => "[9, 3, 17, 10]  # balls, ball and pitch diameter, contact angle in degrees; or \"6205\"",
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
