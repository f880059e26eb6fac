//! Changes the source as no tool would, one change after the other in a copy of the tree, and runs the room's own tests
//! on each. A mutant is killed by a failing test or by one that does not end; one that no test notices survives.
//!
//! ```text
//! package = ["--package", "bearing-watch-model", "--lib"]     arguments of `cargo test`
//! tests = "audit:: rates::"                                   parts of the names of the room's own tests; none for all
//!
//! [[mutant]]
//! file = "workbench/model/src/audit/times.rs"                 from the root of the repository
//! old = "count < 2"                                           in this file exactly once
//! new = "count < 3"
//! why = "two rows have no rate"                               what a user would get
//! ```

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use toml::{Table, Value};

use crate::{cargo, printed, root, target_dir};

/// Least percentage of a room's mutants that its tests kill.
const LEAST_PERCENT: usize = 90;
/// Tests take no longer than this many times what they take without a change, and a minute.
const PATIENCE: u32 = 3;
/// For the packages of the tree: each of many changes is compiled, and its tests run once.
const PROFILE: [&str; 4] = ["--config", "profile.dev.opt-level=1", "--config", "profile.dev.incremental=true"];

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Rooms, instead of all: names of files in `attack/mutants`.
    rooms: Vec<String>,
    /// Mutants of files with this text in their path, instead of all.
    #[arg(long, value_name = "TEXT")]
    file: Option<String>,
}

/// Runs the rooms and prints a line for each; whether each reaches its score.
pub fn run(options: &Options) -> Result<bool> {
    let mut rooms = rooms()?;
    rooms.retain(|(name, _)| options.rooms.is_empty() || options.rooms.contains(name));
    ensure!(!rooms.is_empty(), "attack/mutants has no list {}", options.rooms.join(", "));
    let source = target_dir()?.join("mutants/source");
    refresh(&source)?;
    let (mut table, mut passed) = (String::new(), true);
    for (name, room) in &rooms {
        println!("\n== {name}");
        let mutants = mutants(room)?.filter(|own| options.file.as_ref().is_none_or(|part| own.file.contains(part)));
        let (killed, all) = score(&source, room, &mutants.collect::<Vec<_>>())?;
        let percent = 100 * killed / all.max(1);
        passed &= all == 0 || percent >= LEAST_PERCENT;
        table += &format!("{name:20} {all:>7} mutants {killed:>7} killed {percent:>5} %\n");
    }
    print!("\n{table}");
    Ok(passed)
}

/// The lists, by name.
fn rooms() -> Result<Vec<(String, Table)>> {
    let mut rooms = Vec::new();
    for entry in fs::read_dir(root().join("attack/mutants"))? {
        let path = entry?.path();
        let table = fs::read_to_string(&path)?.parse().with_context(|| path.display().to_string())?;
        rooms.push((path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), table));
    }
    rooms.sort_by(|one, other| one.0.cmp(&other.0));
    Ok(rooms)
}

/// A change of the source that a test has to notice.
struct Mutant<'a> {
    file: &'a str,
    old: &'a str,
    new: &'a str,
    why: &'a str,
}

fn mutants(room: &Table) -> Result<impl Iterator<Item = Mutant<'_>>> {
    let list = room.get("mutant").and_then(Value::as_array).context("no [[mutant]]")?;
    let text = |own, key| Value::get(own, key).and_then(Value::as_str).unwrap_or_default();
    Ok(list.iter().map(move |own| Mutant {
        file: text(own, "file"),
        old: text(own, "old"),
        new: text(own, "new"),
        why: text(own, "why"),
    }))
}

impl Mutant<'_> {
    /// The text of the file with the change.
    fn applied(&self, text: &str) -> Result<String> {
        let count = text.matches(self.old).count();
        ensure!(count == 1 && self.old != self.new, "{} has {count} times instead of once: {:?}", self.file, self.old);
        Ok(text.replacen(self.old, self.new, 1))
    }

    /// Start of the names of the tests beside the change: the module of the file.
    fn module(&self) -> String {
        let inside = self.file.split_once("src/").map_or(self.file, |(_, inside)| inside);
        let module = inside.trim_end_matches(".rs").trim_end_matches("/mod").replace('/', "::");
        if module == "lib" { String::new() } else { format!("{module}::") }
    }
}

/// Makes the mutants of a room one after the other; how many its tests kill, and of how many.
fn score(source: &Path, room: &Table, mutants: &[Mutant<'_>]) -> Result<(usize, usize)> {
    let Some(first) = mutants.first() else { return Ok((0, 0)) };
    let folder = source.join(first.file.split_once("src/").map_or("", |(folder, _)| folder));
    let names = room.get("tests").and_then(Value::as_str).context("no text `tests`")?;
    let (start, programs) = (Instant::now(), build(source, room)?);
    let (built, test) = (Instant::now(), |names: &str, limit| tests(&programs, &folder, names, limit));
    match test(names, Duration::from_secs(3600))? {
        Some(None) => println!("unchanged: built in {:.0?}, tests in {:.0?}", built - start, built.elapsed()),
        Some(Some(test)) => bail!("the tests fail without a mutant: {test}"),
        None => bail!("there are no tests {names:?}"),
    }
    let (limit, mut killed) = (built.elapsed() * PATIENCE + Duration::from_secs(60), 0);
    for mutant in mutants {
        let path = source.join(mutant.file);
        let text = fs::read_to_string(&path).with_context(|| mutant.file.to_owned())?;
        let line = text.split(mutant.old).next().unwrap_or_default().matches('\n').count() + 1;
        let place = format!("{}:{line}", mutant.file);
        fs::write(&path, mutant.applied(&text)?)?;
        let outcome = build(source, room).and_then(|programs| {
            // Those beside the change tell most, and sooner.
            match tests(&programs, &folder, &mutant.module(), limit)? {
                Some(Some(test)) => Ok(Some(test)),
                _ => tests(&programs, &folder, names, limit)?.context("no test is left"),
            }
        });
        fs::write(&path, text)?;
        match outcome.with_context(|| format!("the mutant at {place}: {:?}", mutant.new))? {
            Some(test) => {
                killed += 1;
                println!("killed    {place} by {test}");
            }
            None => println!("SURVIVED  {place}: {}\n          {:?}", mutant.why, mutant.new),
        }
    }
    Ok((killed, mutants.len()))
}

/// Compiles the tests of a room with the builds of all dependencies that the tests of the tree use; their programs.
fn build(source: &Path, room: &Table) -> Result<Vec<PathBuf>> {
    let package = room.get("package").and_then(Value::as_array).context("no list `package`")?;
    let mut tests = cargo(&["test", "--no-run", "--locked", "--message-format", "short"], source);
    tests.args(PROFILE).args(package.iter().filter_map(Value::as_str)).env("CARGO_TARGET_DIR", target_dir()?);
    let output = tests.output()?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    ensure!(output.status.success(), "does not compile:\n{text}");
    // `Executable unittests src/lib.rs (target/debug/deps/…)`
    let lines = text.lines().filter(|line| line.trim_start().starts_with("Executable "));
    let programs = lines.filter_map(|line| Some(source.join(line.rsplit_once('(')?.1.strip_suffix(')')?)));
    Ok(programs.collect())
}

/// Runs the tests with one of these words in their names, up to the first one that fails, which is returned; `None` if
/// there are no such tests. Not by cargo, which may wait for another build.
fn tests(programs: &[PathBuf], folder: &Path, names: &str, limit: Duration) -> Result<Option<Option<String>>> {
    let mut any = None;
    for program in programs {
        let mut command = Command::new("timeout");
        command.arg(limit.as_secs().to_string()).arg(program).args(names.split_whitespace());
        let output = command.current_dir(folder).env("CARGO_MANIFEST_DIR", folder).output()?;
        let text = String::from_utf8_lossy(&output.stdout);
        if !output.status.success() {
            let failed = text.lines().find_map(|line| line.strip_prefix("test ")?.strip_suffix(" ... FAILED"));
            let other = || format!("the end of the program ({}; 124 is the limit of time)", output.status);
            return Ok(Some(Some(failed.map_or_else(other, ToOwned::to_owned))));
        }
        any = any.or(text.lines().any(|line| line.starts_with("test ") && line.ends_with(" ok")).then_some(None));
    }
    Ok(any)
}

/// Brings a copy of the tree up to date, with changes of its files that are not committed. Files that are the same are
/// left alone, so that they are not compiled again.
fn refresh(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    let git = |arguments: &[&str]| {
        let mut git = Command::new("git");
        git.current_dir(root()).arg("--work-tree").arg(folder).args(arguments);
        printed(git.env("GIT_INDEX_FILE", folder.with_extension("index")))
    };
    let changed = printed(Command::new("git").current_dir(root()).args(["stash", "create"]))?;
    let commit = if changed.is_empty() { "HEAD" } else { changed.trim() };
    git(&["read-tree", "--reset", "-u", commit]).map(drop)
}

#[test]
fn every_listed_mutant_can_be_made() -> Result<()> {
    for (name, room) in rooms()? {
        assert!(mutants(&room)?.count() >= 5, "{name}");
        for mutant in mutants(&room)? {
            let text = fs::read_to_string(root().join(mutant.file)).with_context(|| mutant.file.to_owned())?;
            mutant.applied(&text).with_context(|| format!("attack/mutants/{name}.toml"))?;
            assert!(!mutant.why.is_empty(), "{name}: {}", mutant.old);
        }
    }
    Ok(())
}
