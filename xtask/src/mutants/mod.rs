//! `cargo xtask mutants`: changes the source as no tool would, one change after the other in a copy of the tree, and
//! runs the room's own tests on each. A change that they do not notice survives.
//!
//! A mutant is killed by a failing test or by one that does not end. The lists are hand-made: constants, limits,
//! removed lines, signs, swapped bounds; each names what a user would get.

mod list;
mod tree;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use crate::{child, workspace};
use list::{Mutant, Room};

/// Least percentage of a room's mutants that its tests kill.
const LEAST_PERCENT: usize = 90;

/// Tests take no longer than this many times what they take without a change, and a minute.
const PATIENCE: u32 = 3;

/// For the packages of the tree: each of many changes is compiled, and its tests run once.
const PROFILE: [&str; 2] = ["profile.dev.opt-level=1", "profile.dev.incremental=true"];

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Rooms, instead of all: names of files in `attack/mutants`.
    rooms: Vec<String>,
    /// Mutants of files with this text in their path, instead of all.
    #[arg(long, value_name = "TEXT")]
    file: Option<String>,
}

/// What became of a mutant.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Fate {
    /// The first test that failed.
    Killed(String),
    Survived,
}

/// The folder of the lists.
pub fn lists() -> PathBuf {
    workspace::root().join("attack/mutants")
}

/// Runs the rooms and prints the table; whether each reaches its score.
pub fn run(options: &Options) -> Result<bool> {
    let mut rooms = list::rooms(&lists())?;
    if let Some(name) = options.rooms.iter().find(|name| !rooms.iter().any(|room| room.name == **name)) {
        let names: Vec<&str> = rooms.iter().map(|room| room.name.as_str()).collect();
        bail!("no room {name:?}; there are {}", names.join(", "));
    }
    rooms.retain(|room| options.rooms.is_empty() || options.rooms.contains(&room.name));
    if let Some(text) = &options.file {
        rooms.iter_mut().for_each(|room| room.mutants.retain(|mutant| mutant.file.contains(text)));
        rooms.retain(|room| !room.mutants.is_empty());
    }
    ensure!(!rooms.is_empty(), "no mutant is left to run");
    let source = workspace::target_dir().join("mutants/source");
    tree::refresh(&source)?;
    let mut scores = Vec::new();
    for room in &rooms {
        scores.push((room.name.as_str(), fates(&source, room)?));
    }
    let (table, passed) = table(&scores);
    print!("\n{table}");
    Ok(passed)
}

/// Makes the mutants of a room one after the other.
fn fates(source: &Path, room: &Room) -> Result<Vec<Fate>> {
    println!("\n== {}", room.name);
    let start = Instant::now();
    let programs = build(source, room)?.with_context(|| format!("the tests of {} do not compile", room.name))?;
    let built = Instant::now();
    match tests(&programs, source, room, (&room.tests, Duration::MAX))? {
        Some(Fate::Killed(test)) => bail!("the tests of {} fail without a mutant: {test}", room.name),
        Some(Fate::Survived) => {}
        None => bail!("{} has no tests {:?}", room.name, room.tests),
    }
    println!("unchanged: built in {:.0?}, tests in {:.0?}", built - start, built.elapsed());
    let limit = built.elapsed() * PATIENCE + Duration::from_secs(60);
    room.mutants.iter().map(|mutant| fate(source, room, mutant, limit)).collect()
}

fn fate(source: &Path, room: &Room, mutant: &Mutant, limit: Duration) -> Result<Fate> {
    let path = source.join(&mutant.file);
    let text = fs::read_to_string(&path).with_context(|| mutant.file.clone())?;
    let (place, changed) = (mutant.place(&text), mutant.applied(&text)?);
    let _restored_at_the_end = tree::Changed::new(path, text, &changed)?;
    let built = build(source, room)?;
    let programs = built.with_context(|| format!("the mutant at {place} does not compile: {:?}", mutant.new))?;
    // Those beside the change tell most, and sooner.
    let fate = match tests(&programs, source, room, (&mutant.module(), limit))? {
        Some(killed @ Fate::Killed(_)) => killed,
        _ => tests(&programs, source, room, (&room.tests, limit))?.context("no test is left")?,
    };
    match &fate {
        Fate::Killed(test) => println!("killed    {place} by {test}"),
        Fate::Survived => println!("SURVIVED  {place}: {}\n          {:?}", mutant.why, mutant.new),
    }
    Ok(fate)
}

/// Compiles the tests of a room with the builds of all dependencies that the tests of the tree use; what is compiled of
/// the copy has other names. Their programs; `None` if they do not compile.
fn build(source: &Path, room: &Room) -> Result<Option<Vec<PathBuf>>> {
    let log = source.with_file_name("build.log");
    let mut cargo = workspace::cargo(&["test", "--no-run", "--locked"]);
    for setting in PROFILE {
        cargo.args(["--config", setting]);
    }
    cargo.args(&room.package).current_dir(source).env("CARGO_TARGET_DIR", workspace::target_dir());
    if !child::status(into(&log, &mut cargo)?)?.success() {
        return Ok(None);
    }
    let printed = fs::read_to_string(&log)?;
    let programs: Vec<PathBuf> = executables(&printed).map(|program| source.join(program)).collect();
    ensure!(!programs.is_empty(), "cargo names no program of {}", room.name);
    Ok(Some(programs))
}

/// The programs in cargo's lines `Executable unittests src/lib.rs (target/debug/deps/…)`.
fn executables(printed: &str) -> impl Iterator<Item = &str> {
    let lines = printed.lines().filter(|line| line.trim_start().starts_with("Executable "));
    lines.filter_map(|line| line.rsplit_once('(')?.1.strip_suffix(')'))
}

/// Lets both streams of a command go into a file.
fn into<'c>(log: &Path, command: &'c mut Command) -> Result<&'c mut Command> {
    let printed = File::create(log).with_context(|| log.display().to_string())?;
    Ok(command.stderr(printed.try_clone()?).stdout(printed))
}

/// Runs the tests of a room with one of these words in their names, up to the first program with one that fails; `None`
/// if there are none. Not by cargo, which may wait for another build.
fn tests(programs: &[PathBuf], source: &Path, room: &Room, names: (&str, Duration)) -> Result<Option<Fate>> {
    let mut fate = None;
    for program in programs {
        match tests_of(program, source, room, names)? {
            killed @ Some(Fate::Killed(_)) => return Ok(killed),
            own => fate = fate.or(own),
        }
    }
    Ok(fate)
}

fn tests_of(program: &Path, source: &Path, room: &Room, (names, limit): (&str, Duration)) -> Result<Option<Fate>> {
    let (log, folder) = (source.with_file_name("tests.log"), source.join(room.folder()));
    let start = Instant::now();
    let mut command = Command::new(program);
    command.args(names.split_whitespace()).current_dir(&folder).env("CARGO_MANIFEST_DIR", &folder).stdin(Stdio::null());
    let mut started = child::start(into(&log, &mut command)?)?;
    let status = loop {
        match started.0.try_wait()? {
            Some(status) => break status,
            // What is dropped is ended.
            None if start.elapsed() > limit => return Ok(Some(Fate::Killed("the limit of time".to_owned()))),
            None => thread::sleep(Duration::from_millis(20)),
        }
    };
    let printed = String::from_utf8_lossy(&fs::read(&log)?).into_owned();
    let failed = printed.lines().find_map(|line| line.strip_prefix("test ")?.strip_suffix(" ... FAILED"));
    let ran = || printed.lines().any(|line| line.starts_with("test ") && line.ends_with(" ok"));
    Ok(match (status.success(), failed) {
        (true, _) => ran().then_some(Fate::Survived),
        (false, Some(test)) => Some(Fate::Killed(test.to_owned())),
        (false, None) => Some(Fate::Killed(format!("the program ended without a test result ({status})"))),
    })
}

/// A line for each room, and whether each has its score.
fn table(scores: &[(&str, Vec<Fate>)]) -> (String, bool) {
    let (mut text, mut passed) = (format!("{:20} {:>7} {:>7}   score\n", "room", "mutants", "killed"), true);
    for (name, fates) in scores {
        let (all, survived) = (fates.len(), fates.iter().filter(|fate| **fate == Fate::Survived).count());
        let percent = 100 * (all - survived) / all.max(1);
        passed &= percent >= LEAST_PERCENT;
        let verdict = if percent < LEAST_PERCENT { "  FAIL" } else { "" };
        text += &format!("{name:20} {all:>7} {:>7} {percent:>5} %{verdict}\n", all - survived);
    }
    (text, passed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_room_needs_its_score() {
        let fates = |killed: usize, survived: usize| {
            [vec![Fate::Killed("a".to_owned()); killed], vec![Fate::Survived; survived]].concat()
        };
        let (text, passed) = table(&[("one", fates(9, 1)), ("two", fates(8, 1))]);
        assert!(!passed && text.contains("one                       10       9    90 %\n"), "{text}");
        assert!(text.ends_with("two                        9       8    88 %  FAIL\n"), "{text}");
        assert!(table(&[("one", fates(9, 1))]).1);
    }

    #[test]
    fn the_programs_are_those_that_cargo_names() {
        let printed =
            "   Compiling a v0.1.0 (/x)\n    Finished `test` profile\n  Executable unittests src/lib.rs (/y/a-1)\n";
        assert_eq!(executables(printed).collect::<Vec<_>>(), ["/y/a-1"]);
    }
}
