//! Output: lines on standard output, warnings, and progress bars.

use std::io::Write as _;

use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};

use model::Error;
pub(super) use model::outputs::{folder_of, plan, temporary, write, write_all};
use model::session::{Log, Progress, Steps};

/// Prints a line; a closed pipe (`| head`) is not an error.
pub(super) fn say(text: impl AsRef<str>) -> Result<(), Error> {
    match writeln!(std::io::stdout(), "{}", text.as_ref()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output")(error)),
        _ => Ok(()),
    }
}

/// Prints a warning on standard error.
pub(super) fn warn(text: impl AsRef<str>) {
    eprintln!("warning: {}", text.as_ref());
}

/// Shows progress bars.
struct Bars;

impl Progress for Bars {
    fn start(&self, what: &'static str, count: usize) -> Steps {
        let bar = progress(what, count).with_finish(ProgressFinish::AndClear);
        Box::new(move |done| bar.inc(done))
    }
}

/// Runs a work with progress bars, and prints its warnings.
pub(super) fn logged<T>(work: impl FnOnce(&Log<'_>) -> Result<T, Error>) -> Result<T, Error> {
    let log = Log::new(&Bars);
    let result = work(&log);
    log.take().iter().for_each(warn);
    result
}

/// Returns the rows as CSV, quoted if needed.
pub(super) fn csv(rows: &[Vec<String>]) -> Result<String, Error> {
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    for row in rows {
        writer.write_record(row).map_err(|e| Error::Usage(e.to_string()))?;
    }
    let bytes = writer.into_inner().map_err(|e| Error::Usage(e.to_string()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Returns a progress bar; it is shown on a terminal only.
pub(super) fn progress(what: &'static str, count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg:>12} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}

/// Prints a JSON value on standard output.
pub(super) fn json(value: &serde_json::Value) -> Result<(), Error> {
    say(format!("{value:#}"))
}
