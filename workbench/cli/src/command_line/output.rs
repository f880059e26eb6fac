//! Output: lines and JSON on standard output; warnings, notes and progress bars on standard error, as much as is
//! wanted.
//!
//! The libraries report through the crate `log`; only the reports of this project's crates are printed.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressStyle};

use log::{LevelFilter, Metadata, Record};
use serde_json::{Value, json};

use model::outputs::cell;
pub(crate) use model::outputs::{plan, temporary, write, write_all};
use model::session::{Log, Progress, Steps};
use model::{Error, visible};

/// Version of the forms of JSON: it rises when a key is removed or gets another meaning, not when one is added.
pub(crate) const VERSION: u32 = 1;

/// Prints lines, in which nothing acts on a terminal; a closed pipe (`| head`) is not an error.
pub(crate) fn say(text: impl AsRef<str>) -> Result<(), Error> {
    print(&visible::lines(text.as_ref()))
}

/// Prints one line, whatever is in it.
pub(crate) fn say_line(text: &str) -> Result<(), Error> {
    print(&visible::line(text))
}

fn print(text: &str) -> Result<(), Error> {
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output")(error)),
        _ => Ok(()),
    }
}

/// Prints a warning on standard error, unless that is to be quiet.
pub(crate) fn warn(text: impl AsRef<str>) {
    note(format!("warning: {}", text.as_ref()));
}

/// Prints a note on standard error, unless that is to be quiet.
pub(crate) fn note(text: impl AsRef<str>) {
    if !is_quiet() {
        eprintln!("{}", visible::lines(text.as_ref()));
    }
}

/// Shows progress bars.
struct Bars;

impl Progress for Bars {
    #[cfg(target_family = "wasm")]
    fn start(&self, what: &'static str, count: usize) -> Steps {
        let steps = std::sync::atomic::AtomicU64::new(0);
        Box::new(move |done| {
            let before = steps.fetch_add(done, Ordering::Relaxed);
            let percent = |steps: u64| 100 * steps / count.max(1) as u64;
            if percent(before) < percent(before + done) && !is_quiet() {
                // In one piece, and marked: a page shows it, and leaves it out of the notes.
                let line = format!("\r{what} {}/{count}\n", before + done);
                let _is_shown = std::io::stderr().write_all(line.as_bytes());
            }
        })
    }

    #[cfg(not(target_family = "wasm"))]
    fn start(&self, what: &'static str, count: usize) -> Steps {
        let bar = progress(what, count).with_finish(indicatif::ProgressFinish::AndClear);
        Box::new(move |done| bar.inc(done))
    }
}

/// Runs a work with progress bars, and prints its warnings; of a work that fails its error says all.
pub(crate) fn logged<T>(work: impl FnOnce(&Log<'_>) -> Result<T, Error>) -> Result<T, Error> {
    let log = Log::new(&Bars);
    let result = work(&log);
    let warnings = log.take();
    if result.is_ok() {
        warnings.iter().for_each(warn);
    }
    result
}

/// Returns the rows as CSV, quoted if needed; no cell is a formula.
pub(crate) fn csv(rows: &[Vec<String>]) -> Result<String, Error> {
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    for row in rows {
        writer.write_record(row.iter().map(|text| cell(text).into_owned())).map_err(|e| Error::Usage(e.to_string()))?;
    }
    let bytes = writer.into_inner().map_err(|e| Error::Usage(e.to_string()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Returns a progress bar; it is shown on a terminal only, unless that is to be quiet.
pub(crate) fn progress(what: &'static str, count: usize) -> ProgressBar {
    if is_quiet() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(count as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg:>12} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}

/// Prints a JSON value of this form on standard output.
pub(crate) fn json(form: &str, value: Value) -> Result<(), Error> {
    print(&visible::json(&format!("{:#}", named(form, value))))
}

/// The same on one line.
pub(crate) fn json_line(form: &str, value: Value) -> Result<(), Error> {
    print(&visible::json(&named(form, value).to_string()))
}

/// A JSON object that starts with the name and the version of its form; of a list, each of its objects does.
fn named(form: &str, value: Value) -> Value {
    match value {
        Value::Array(all) => all.into_iter().map(|one| named(form, one)).collect(),
        Value::Object(own) => {
            let name = [("format", json!(format!("bearing-watch/{form}"))), ("version", json!(VERSION))];
            let name = name.map(|(key, value)| (key.to_string(), value));
            Value::Object(name.into_iter().chain(own).collect())
        }
        other => other,
    }
}

/// Whether only errors are printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Notes that are printed without `--verbose`, and those so far.
const MOST: usize = 30;
static TOLD: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// How the names of the crates begin whose reports are printed.
const CRATES: [&str; 2] = ["bearing_watch", "workbench"];

/// Sets how much is said on standard error: nothing but errors, warnings and notes, or also what is read and chosen.
pub(crate) fn set_verbosity(quiet: bool, verbose: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
    let level = match (quiet, verbose) {
        (true, _) => LevelFilter::Off,
        (_, true) => LevelFilter::Info,
        _ => LevelFilter::Warn,
    };
    if log::set_logger(&Lines).is_ok() {
        log::set_max_level(level);
    }
}

/// Whether only errors are printed.
fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints each report as a line.
struct Lines;

impl log::Log for Lines {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        CRATES.iter().any(|own| metadata.target().starts_with(own))
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = visible::lines(&record.args().to_string()).replace("/./", "/");
        let mut told = TOLD.lock().unwrap_or_else(PoisonError::into_inner);
        // A file may be read more than once, and a folder of files of one kind has the same to say of each.
        if !told.insert(text.trim_start_matches("./").to_string()) {
            return;
        }
        if log::max_level() >= LevelFilter::Info || told.len() < MOST {
            eprintln!("{text}");
        } else if told.len() == MOST {
            eprintln!("further notes are not printed; --verbose prints all");
        }
    }

    fn flush(&self) {}
}
