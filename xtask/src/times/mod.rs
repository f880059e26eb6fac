//! `cargo xtask times`: what the first `cargo demo` takes, crate by crate; and its bound.

mod alias;
mod cost;
pub mod wrapper;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use crate::tally::Tally;
use crate::target::brief;
use crate::{child, workspace};
use alias::Alias;
use wrapper::Call;

/// Crates in the table.
const SLOWEST: usize = 25;

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Then adds a line to this file, builds again, and takes the line away.
    #[arg(long, value_name = "FILE")]
    changed: Option<PathBuf>,
}

/// What a command took.
#[derive(Clone, Copy, Debug)]
struct Took {
    time: Duration,
    /// Unknown without Linux.
    processor: Option<Duration>,
}

/// Builds the demo in an empty target directory, runs it, and prints the times.
pub fn run(options: &Options) -> Result<()> {
    let (alias, folder) = (Alias::demo()?, workspace::target_dir().join("times"));
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    let (built, calls) = timed_build(&alias, &folder, &folder)?;
    let ran = timed(demo(&alias, &folder)?.env("CARGO_TARGET_DIR", &folder))?;
    print!("\n{}", table(calls.clone()));
    println!("\nbuild: {}\nrun: {}", text(built), text(ran));
    if let Some(run) = ran.processor {
        println!("{}", cost::judge(&calls, run)?);
    }
    if let Some(file) = &options.changed {
        let before = fs::read_to_string(file).with_context(|| file.display().to_string())?;
        fs::write(file, format!("{before}// One line more.\n"))?;
        let built = timed_build(&alias, &folder, &folder);
        fs::write(file, before)?;
        let (built, calls) = built?;
        println!("\n{}\nbuild after a changed line: {}", table(calls), text(built));
    }
    Ok(())
}

/// Builds into a target directory, and returns the calls of the compiler, which are written into a folder.
fn timed_build(alias: &Alias, target: &Path, folder: &Path) -> Result<(Took, Vec<Call>)> {
    let file = folder.join("calls");
    fs::write(&file, "")?;
    let mut cargo = workspace::cargo(&["build"]);
    cargo.args(&alias.options).env("CARGO_TARGET_DIR", target);
    cargo.env("RUSTC_WRAPPER", std::env::current_exe()?).env(wrapper::VARIABLE, &file);
    let took = timed(&mut cargo)?;
    Ok((took, wrapper::read(&fs::read_to_string(&file)?)))
}

/// A call of the alias, in a folder where its files do no harm.
fn demo(alias: &Alias, folder: &Path) -> Result<Command> {
    let place = folder.join("demo");
    fs::create_dir_all(&place)?;
    let mut cargo = workspace::cargo(&["run"]);
    cargo.args(&alias.options).arg("--").args(&alias.arguments).current_dir(place);
    Ok(cargo)
}

fn timed(command: &mut Command) -> Result<Took> {
    let (start, before) = (Instant::now(), child::processor_time());
    child::succeed(command)?;
    let processor = child::processor_time().zip(before).map(|(after, before)| after.saturating_sub(before));
    Ok(Took { time: start.elapsed(), processor })
}

fn text(took: Took) -> String {
    let processor = took.processor.map_or_else(|| "unknown".into(), |time| format!("{:.1} s", time.as_secs_f32()));
    format!("{:.1} s, processor time {processor}", took.time.as_secs_f32())
}

/// The slowest calls of the compiler, and the sum of all.
fn table(mut calls: Vec<Call>) -> String {
    calls.sort_by_key(|call| std::cmp::Reverse((call.processor, call.time)));
    let mut text = format!("{:44} {:>8} {:>11}\n", "crate", "time", "processor");
    let row = |text: &mut String, name: &str, time: Duration, processor: Duration| {
        let (time, processor) = (time.as_secs_f32(), processor.as_secs_f32());
        let _string_grows = writeln!(text, "{name:44} {time:>6.1} s {processor:>9.1} s");
    };
    for Call { name, time, processor } in calls.iter().take(SLOWEST) {
        row(&mut text, name, *time, *processor);
    }
    let sum = |of: fn(&Call) -> Duration| calls.iter().map(of).sum();
    row(&mut text, &format!("all {}", calls.len()), sum(|call| call.time), sum(|call| call.processor));
    text
}

/// The bound of the first `cargo demo`, where the demo has not been built yet.
pub fn checks(tally: &mut Tally) {
    const TITLE: &str = "cargo demo from nothing";
    match brief(Alias::demo()) {
        Ok(alias) if is_built(&alias) => {
            tally.skip(TITLE, "it was built before; `cargo xtask times` measures it");
        }
        Ok(alias) => tally.check(TITLE, brief(within_bound(&alias))),
        Err(reason) => tally.check::<&str, _>(TITLE, Err(reason)),
    }
}

/// Whether the demo, or a library that it shares with the tests, was built before. This program shares a few small
/// dependencies with it, which do not count.
fn is_built(alias: &Alias) -> bool {
    let artefacts = workspace::target_dir().join(alias.profile()).join(".fingerprint");
    artefacts.read_dir().is_ok_and(|mut entries| {
        entries.any(|entry| entry.is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with("bearing-watch-")))
    })
}

fn within_bound(alias: &Alias) -> Result<String> {
    let target = workspace::target_dir();
    let folder = target.join("tests");
    fs::create_dir_all(&folder)?;
    let (built, calls) = timed_build(alias, &target, &folder)?;
    let ran = timed(&mut demo(alias, &folder)?)?;
    let words = ran.processor.map(|run| cost::judge(&calls, run)).transpose()?;
    Ok(format!("{}; build {}, run {}", words.unwrap_or_default(), text(built), text(ran)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_slowest_crates_and_the_sum() {
        let call = |place: u64| Call {
            name: format!("crate-{place}"),
            time: Duration::from_millis(1000 * place),
            processor: Duration::from_millis(500 * place),
        };
        let table = table((1..=30).map(call).collect());
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), SLOWEST + 2);
        assert!(lines[1].starts_with("crate-30") && lines[1].ends_with("30.0 s      15.0 s"), "{}", lines[1]);
        assert!(lines[26].starts_with("all 30") && lines[26].ends_with("465.0 s     232.5 s"), "{}", lines[26]);
    }
}
