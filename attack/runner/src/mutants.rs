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

use anyhow::{Context, Result, bail, ensure};
use toml::{Table, Value};

use crate::{cargo, printed, root, target_dir};

/// Least percentage of a room's mutants that its tests kill.
const LEAST_PERCENT: usize = 90;
/// Longest time of a program of tests.
const PATIENCE: &str = "10m";
/// For the packages of the tree: each of many changes is compiled, and its tests run once.
const PROFILE: [&str; 2] = ["--config=profile.dev.opt-level=1", "--config=profile.dev.incremental=true"];

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Rooms, instead of all: names of files in `attack/mutants`.
    rooms: Vec<String>,
    /// Mutants of files with this text in their path, instead of all.
    #[arg(long, value_name = "TEXT", default_value = "")]
    file: String,
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
        let (mut killed, mut all) = (0, 0);
        ensure!(tests(&source, room)?.is_none(), "the tests of {name} fail without a mutant");
        for mutant in mutants(room)?.filter(|mutant| mutant.file.contains(&options.file)) {
            all += 1;
            killed += usize::from(is_killed(&source, room, &mutant)?);
        }
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
    let mutant = move |own| Mutant {
        file: text(own, "file"),
        old: text(own, "old"),
        new: text(own, "new"),
        why: text(own, "why"),
    };
    Ok(list.iter().map(mutant))
}

impl Mutant<'_> {
    /// The text of the file with the change.
    fn applied(&self, text: &str) -> Result<String> {
        let count = text.matches(self.old).count();
        ensure!(count == 1 && self.old != self.new, "{} has {count} times instead of once: {:?}", self.file, self.old);
        Ok(text.replacen(self.old, self.new, 1))
    }
}

/// Makes a mutant; whether a test notices it.
fn is_killed(source: &Path, room: &Table, mutant: &Mutant<'_>) -> Result<bool> {
    let Mutant { file, old, new, why } = mutant;
    let path = source.join(file);
    let text = fs::read_to_string(&path).with_context(|| (*file).to_owned())?;
    let line = text.split(old).next().unwrap_or_default().matches('\n').count() + 1;
    fs::write(&path, mutant.applied(&text)?)?;
    let outcome = tests(source, room);
    fs::write(&path, text)?;
    let failed = outcome.with_context(|| format!("the mutant at {file}:{line}: {new:?}"))?;
    match &failed {
        Some(test) => println!("killed    {file}:{line} by {test}"),
        None => println!("SURVIVED  {file}:{line}: {why}\n          {new:?}"),
    }
    Ok(failed.is_some())
}

/// Compiles the tests of a room with the builds of all dependencies that the tests of the tree use, and runs them up to
/// the first one that fails, which is returned.
fn tests(source: &Path, room: &Table) -> Result<Option<String>> {
    let package = room.get("package").and_then(Value::as_array).context("no list `package`")?;
    let names = room.get("tests").and_then(Value::as_str).context("no text `tests`")?;
    let mut build = cargo(&["test", "--no-run", "--locked"], source);
    build.args(PROFILE).args(package.iter().filter_map(Value::as_str)).env("CARGO_TARGET_DIR", target_dir()?);
    let output = build.output()?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    ensure!(output.status.success(), "does not compile:\n{text}");
    // `Executable unittests src/lib.rs (target/debug/deps/…)`
    let lines = text.lines().filter(|line| line.trim_start().starts_with("Executable "));
    let programs = lines.filter_map(|line| Some(source.join(line.rsplit_once('(')?.1.strip_suffix(')')?)));
    // Tests of a package run in its folder.
    let file = mutants(room)?.next().map_or("", |mutant| mutant.file);
    let folder = source.join(file.split_once("src/").map_or("", |(folder, _)| folder));
    let mut any = false;
    for program in programs.collect::<Vec<PathBuf>>() {
        // Not by cargo, which may wait for another build.
        let mut command = Command::new("timeout");
        command.arg(PATIENCE).arg(program).args(names.split_whitespace()).current_dir(&folder);
        let output = command.env("CARGO_MANIFEST_DIR", &folder).output()?;
        let text = String::from_utf8_lossy(&output.stdout);
        if !output.status.success() {
            let failed = text.lines().find_map(|line| line.strip_prefix("test ")?.strip_suffix(" ... FAILED"));
            let other = || format!("the end of the program ({}; 124 is the limit of time)", output.status);
            return Ok(Some(failed.map_or_else(other, ToOwned::to_owned)));
        }
        any |= text.lines().any(|line| line.starts_with("test ") && line.ends_with(" ok"));
    }
    if any { Ok(None) } else { bail!("there are no tests {names:?}") }
}

/// Brings a copy of the tree up to date, with changes of its files that are not committed. Files that are the same are
/// left alone, so that they are not compiled again.
fn refresh(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    let changed = printed(Command::new("git").current_dir(root()).args(["stash", "create"]))?;
    let mut git = Command::new("git");
    git.current_dir(root()).arg("--work-tree").arg(folder).args(["read-tree", "--reset", "-u"]);
    git.arg(if changed.is_empty() { "HEAD" } else { changed.trim() });
    printed(git.env("GIT_INDEX_FILE", folder.with_extension("index"))).map(drop)
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
