//! This program in the place of the compiler: calls it, and writes down what the call took. Cargo starts it by the
//! variable `RUSTC_WRAPPER`, with the compiler as its first argument.

use std::env;
use std::ffi::OsString;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use crate::child;

/// Names the file of the calls, and says that this is such a call.
pub const VARIABLE: &str = "BEARING_WATCH_TIMES";

/// What a call of the compiler took.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    pub name: String,
    pub time: Duration,
    /// Unknown without Linux.
    pub processor: Duration,
}

/// Calls the compiler as cargo asks, and adds a line to the file.
pub fn run(file: &Path) -> ExitCode {
    let outcome = call(file, env::args_os().skip(1).collect());
    outcome.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}

fn call(file: &Path, arguments: Vec<OsString>) -> Result<ExitCode> {
    let (compiler, rest) = arguments.split_first().context("no compiler")?;
    let start = Instant::now();
    // In cargo's process group, which ends as a whole.
    let status = Command::new(compiler).args(rest).status().with_context(|| compiler.display().to_string())?;
    if let Some(name) = name(rest, env::var("CARGO_PKG_NAME").ok()) {
        let call = Call { name, time: start.elapsed(), processor: child::processor_time().unwrap_or_default() };
        // One write: calls run side by side.
        File::options().create(true).append(true).open(file)?.write_all(line(&call).as_bytes())?;
    }
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

/// The crate that is compiled; nothing if cargo only asks for the compiler's version.
fn name(arguments: &[OsString], package: Option<String>) -> Option<String> {
    let after = |option: &str| arguments.iter().skip_while(|own| *own != option).nth(1);
    let name = after("--crate-name").filter(|name| *name != "___")?.to_string_lossy().into_owned();
    let kind = after("--crate-type").map(|kind| kind.to_string_lossy().into_owned()).unwrap_or_default();
    Some(match kind.as_str() {
        "bin" if name.starts_with("build_script") => format!("{} (build script)", package.unwrap_or(name)),
        "bin" => format!("{name} (program)"),
        _ => name,
    })
}

fn line(call: &Call) -> String {
    format!("{}\t{}\t{}\n", call.name, call.time.as_millis(), call.processor.as_millis())
}

/// Reads the lines of the file.
pub fn read(text: &str) -> Vec<Call> {
    let call = |line: &str| {
        let mut cells = line.split('\t');
        let name = cells.next()?.to_owned();
        let mut next = || Some(Duration::from_millis(cells.next()?.parse().ok()?));
        Some(Call { name, time: next()?, processor: next()? })
    };
    text.lines().filter_map(call).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(arguments: &str) -> Option<String> {
        let arguments: Vec<OsString> = arguments.split(' ').map(OsString::from).collect();
        name(&arguments, Some("serde".to_owned()))
    }

    #[test]
    fn calls_are_named_by_crate_and_kind() {
        assert_eq!(named("--crate-name serde --edition=2021 --crate-type lib").as_deref(), Some("serde"));
        let script = "--crate-name build_script_build x --crate-type bin";
        assert_eq!(named(script).as_deref(), Some("serde (build script)"));
        assert_eq!(named("--crate-name demo --crate-type bin").as_deref(), Some("demo (program)"));
        assert_eq!(named("- --crate-name ___ --print=file-names"), None);
        assert_eq!(named("-vV"), None);
    }

    #[test]
    fn lines_are_read_as_written() {
        let call = Call { name: "a".into(), time: Duration::from_millis(1500), processor: Duration::from_millis(20) };
        assert_eq!(read(&format!("{}broken\n", line(&call))), [call]);
    }
}
