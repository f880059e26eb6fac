//! Output: results on standard output; notes and progress on standard error.

use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicU64, Ordering};

use serde_json::Value;

use model::Error;
use model::outputs::cell;
use model::session::{Progress, Steps};

/// How much is said on standard error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Output {
    /// Whether only errors are printed.
    pub(crate) quiet: bool,
}

/// Shows the part of a work that is done, on a terminal only.
impl Progress for Output {
    fn start(&self, what: &'static str, count: usize) -> Steps {
        let (all, shown) = (AtomicU64::new(0), !self.quiet && std::io::stderr().is_terminal());
        Box::new(move |steps| {
            let done = all.fetch_add(steps, Ordering::Relaxed) + steps;
            if shown {
                let end = if done >= count as u64 { "\r\u{1b}[K" } else { "" };
                eprint!("\r{what} {:3} %{end}", 100 * done / count.max(1) as u64);
            }
        })
    }
}

impl Output {
    /// Prints what a table shows before the table, with an empty line: on standard error, so that standard output is
    /// the table alone.
    pub(crate) fn conclude(self, text: &str) {
        if !self.quiet {
            eprintln!("{text}\n");
        }
    }
}

/// Prints lines; a closed pipe (`| head`) is not an error.
pub(crate) fn say(text: impl AsRef<str>) -> Result<(), Error> {
    match writeln!(std::io::stdout(), "{}", text.as_ref()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output")(error)),
        _ => Ok(()),
    }
}

/// Prints a JSON value.
pub(crate) fn json(value: &Value) -> Result<(), Error> {
    say(format!("{value:#}"))
}

/// Returns the rows as CSV, quoted if needed; no cell is a formula.
pub(crate) fn csv(rows: &[Vec<String>]) -> String {
    let quoted = |text: &String| {
        let text = cell(text);
        let plain = !text.contains([',', '"', '\n', '\r']);
        if plain { text.into_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
    };
    rows.iter().map(|row| row.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n").collect()
}
