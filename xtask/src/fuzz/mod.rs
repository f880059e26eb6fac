//! `cargo xtask fuzz`: attacks every door of the package `attack` with libFuzzer, guided by coverage, on stable Rust.
//!
//! The compiler's pass that counts branches is an option of LLVM, which stable Rust passes on; libFuzzer is a crate.
//! Overflow checks and debug assertions are on. Each door starts from its kept corpus, and what a run finds stays in
//! the target directory for the next one, or replaces the kept corpus (`--keep`).

mod corpus;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;

use crate::{child, workspace};

/// Counters of branches, and comparisons, whose operands libFuzzer then tries.
const COVERAGE: [&str; 6] = [
    "--cfg=attack_coverage",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
];
/// Programs of the package, and the features that they are built with.
const PROGRAMS: [(&str, &[&str]); 2] = [
    ("attack-core", &["--no-default-features", "--features", "signature"]),
    ("attack-readers", &["--no-default-features", "--features", "readers"]),
];
/// Longest time of one input, s.
const SLOWEST: &str = "20";
/// Largest memory, MB; the program itself limits allocations to 1 GB.
const MEMORY: &str = "3000";
/// Failures of a door after which it is attacked no further.
const FAILURES: usize = 5;

/// Options of the command.
#[derive(Args, Debug)]
pub struct Options {
    /// Minutes for all doors together.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Doors to attack; all of them if none is named.
    doors: Vec<String>,
    /// Replaces the kept corpora by the smallest ones of the same coverage.
    #[arg(long)]
    keep: bool,
}

/// A door and the program that attacks it.
#[derive(Clone, Debug)]
struct Door {
    name: String,
    program: PathBuf,
}

/// What an attack did.
#[derive(Clone, Debug)]
struct Outcome {
    name: String,
    executions: u64,
    seconds: f64,
    failures: usize,
}

/// Attacks; returns whether no door failed.
pub fn run(options: &Options) -> Result<bool> {
    ensure!(child::on_path("c++"), "libFuzzer needs a C++ compiler; on Debian: sudo apt-get install --yes g++");
    let mut doors: Vec<Door> = Vec::new();
    let is_there = |asked: &String, doors: &[Door]| doors.iter().any(|door| door.name == *asked);
    for (program, features) in PROGRAMS {
        if !options.doors.is_empty() && options.doors.iter().all(|asked| is_there(asked, &doors)) {
            break;
        }
        let program = build(program, features)?;
        let mut list = Command::new(&program);
        let names = child::output(list.stderr(Stdio::null())).context("the program does not name its doors")?;
        doors.extend(names.lines().map(|name| Door { name: name.to_owned(), program: program.clone() }));
    }
    if let Some(asked) = options.doors.iter().find(|asked| !is_there(asked, &doors)) {
        let names: Vec<&str> = doors.iter().map(|door| door.name.as_str()).collect();
        bail!("no door {asked}; there are {}", names.join(", "));
    }
    doors.retain(|door| options.doors.is_empty() || options.doors.contains(&door.name));
    let workers = thread::available_parallelism().map_or(1, usize::from).min(doors.len());
    let each = Duration::from_secs_f64(options.minutes.max(0.0) * 60.0 * workers as f64 / doors.len() as f64);
    let mut outcomes = in_parallel(workers, &doors, |door| attack(door, each))?;
    if options.keep {
        in_parallel(workers, &doors, |door| corpus::keep(&door.name, &door.program))?;
    }
    outcomes.sort_by_key(|outcome| doors.iter().position(|door| door.name == outcome.name));
    print!("\n{}", table(&outcomes));
    Ok(outcomes.iter().all(|outcome| outcome.failures == 0))
}

/// Builds a program of the package with counters of branches.
fn build(program: &str, features: &[&str]) -> Result<PathBuf> {
    let host = workspace::host()?;
    let mut cargo = workspace::cargo(&["build", "--profile", "fuzz", "--package", "attack", "--bin", program]);
    // With a target, neither build scripts nor macros have counters.
    cargo.args(features).args(["--target", &host]).env("CARGO_ENCODED_RUSTFLAGS", COVERAGE.join("\u{1f}"));
    child::succeed(&mut cargo)?;
    Ok(workspace::target_dir().join(host).join("fuzz").join(program))
}

/// Does the same with each door, several at a time.
fn in_parallel<T: Send>(workers: usize, doors: &[Door], work: impl Fn(&Door) -> Result<T> + Sync) -> Result<Vec<T>> {
    let (queue, results) = (Mutex::new(doors.iter()), Mutex::new(Vec::new()));
    let next = || queue.lock().ok().and_then(|mut queue| queue.next());
    thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(door) = next() {
                    let result = work(door);
                    if let Ok(mut results) = results.lock() {
                        results.push(result);
                    }
                }
            });
        }
    });
    results.into_inner().unwrap_or_default().into_iter().collect()
}

/// Attacks a door for some time, again after each failure.
fn attack(door: &Door, time: Duration) -> Result<Outcome> {
    let folder = corpus::unpack(&door.name)?;
    let failed = corpus::folder("failed")?;
    let start = Instant::now();
    let mut outcome = Outcome { name: door.name.clone(), executions: 0, seconds: 0.0, failures: 0 };
    while outcome.failures < FAILURES {
        let left = time.saturating_sub(start.elapsed()).as_secs();
        if left == 0 && outcome.seconds > 0.0 {
            break;
        }
        let (executions, succeeded) = round(door, (&folder, &failed), left.max(1), outcome.failures)?;
        outcome.executions += executions;
        outcome.seconds = start.elapsed().as_secs_f64();
        if !succeeded {
            outcome.failures += 1;
        }
    }
    let Outcome { name, executions, seconds, failures } = &outcome;
    println!("{name}: {executions} executions in {seconds:.0} s, {failures} failures");
    Ok(outcome)
}

/// Runs libFuzzer once; returns the number of executions, and whether none failed.
fn round(door: &Door, (own, failed): (&Path, &Path), seconds: u64, round: usize) -> Result<(u64, bool)> {
    let log = own.with_extension(format!("{round}.log"));
    let mut program = Command::new(&door.program);
    program.env("ATTACK_DOOR", &door.name).arg(own).args([
        format!("-max_total_time={seconds}"),
        format!("-timeout={SLOWEST}"),
        format!("-rss_limit_mb={MEMORY}"),
        "-print_final_stats=1".to_owned(),
        format!("-artifact_prefix={}/{}-", failed.display(), door.name),
    ]);
    let (out, error) = (fs::File::create(&log)?, fs::File::options().append(true).open(&log)?);
    let status = child::status(program.stdout(out).stderr(error))?;
    let text = String::from_utf8_lossy(&fs::read(&log)?).into_owned();
    let count = text.lines().find_map(|line| line.strip_prefix("stat::number_of_executed_units:"));
    let executions = count.and_then(|count| count.trim().parse().ok()).unwrap_or(0);
    if !status.success() {
        let written = text.lines().find_map(|line| line.split_once("Test unit written to ").map(|(_, file)| file));
        println!("FAIL  {}: {}, input {}", door.name, log.display(), written.unwrap_or("not written"));
    }
    Ok((executions, status.success()))
}

/// The table of a run.
fn table(outcomes: &[Outcome]) -> String {
    let mut text = String::from("| Door | Executions | Executions/s | New failures |\n|---|---:|---:|---:|\n");
    let total = Outcome {
        name: "all".to_owned(),
        executions: outcomes.iter().map(|own| own.executions).sum(),
        seconds: outcomes.iter().map(|own| own.seconds).sum(),
        failures: outcomes.iter().map(|own| own.failures).sum(),
    };
    for Outcome { name, executions, seconds, failures } in outcomes.iter().chain([&total]) {
        let rate = *executions as f64 / seconds.max(1e-3);
        text += &format!("| {name} | {executions} | {rate:.0} | {failures} |\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_ends_with_the_sums() {
        let own =
            |name: &str, executions, failures| Outcome { name: name.to_owned(), executions, seconds: 2.0, failures };
        let text = table(&[own("a", 100, 0), own("b", 300, 2)]);
        assert!(text.ends_with("| b | 300 | 150 | 2 |\n| all | 400 | 100 | 2 |\n"), "{text}");
    }
}
