//! How much is said on standard error: nothing but errors, warnings and notes, or also what is read and chosen.
//!
//! The libraries report through the crate `log`; only the reports of this project's crates are printed.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use log::{LevelFilter, Log, Metadata, Record};

/// Whether only errors are printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Notes that are printed without `--verbose`, and those so far.
const MOST: usize = 30;
static TOLD: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// How the names of the crates begin whose reports are printed.
const CRATES: [&str; 2] = ["bearing_watch", "workbench"];

/// Sets it for the process.
pub(super) fn set(quiet: bool, verbose: bool) {
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
pub(super) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints each report as a line.
struct Lines;

impl Log for Lines {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        CRATES.iter().any(|own| metadata.target().starts_with(own))
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = model::visible::lines(&record.args().to_string()).replace("/./", "/");
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
