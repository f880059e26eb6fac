//! How much is said on standard error: nothing but errors, warnings and notes, or also what is read and chosen.
//!
//! The libraries report through the crate `log`; only the reports of this project's crates are printed.

use std::sync::atomic::{AtomicBool, Ordering};

use log::{LevelFilter, Log, Metadata, Record};

/// Whether only errors are printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// How the names of the crates begin whose reports are printed.
const CRATES: [&str; 2] = ["bearing_watch", "workbench"];

/// Sets it for the process.
pub(super) fn set(quiet: bool, verbose: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
    if verbose && log::set_logger(&Lines).is_ok() {
        log::set_max_level(LevelFilter::Info);
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
        if self.enabled(record.metadata()) {
            eprintln!("{}", model::visible::lines(&record.args().to_string()));
        }
    }

    fn flush(&self) {}
}
