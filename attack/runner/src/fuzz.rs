//! Attacks every door of the package `attack` with libFuzzer, guided by coverage, on stable Rust.
//!
//! The compiler's pass that counts branches is an option of LLVM, which stable Rust passes on; libFuzzer is a crate.
//! Overflow checks and debug assertions are on. Each door starts from its kept corpus, and what a run finds stays in
//! the target directory for the next one, or replaces the kept corpus (`--keep`).

use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::thread;

use anyhow::{Context, Result, ensure};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use crate::{cargo, printed, root, target_dir};

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
const PROGRAMS: [(&str, &str); 2] = [("attack-core", "signature"), ("attack-readers", "readers")];
/// The longest time of one input in seconds, and the largest memory in MB; the program limits allocations to 1 GB.
const LIMITS: [&str; 3] = ["-timeout=20", "-rss_limit_mb=3000", "-print_final_stats=1"];
/// Most bytes of the inputs of a kept corpus, before they are packed; the shortest go first.
const MOST_BYTES: usize = 120_000;

/// Options of the command.
#[derive(clap::Args, Debug)]
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
struct Door {
    name: String,
    program: PathBuf,
}

/// Attacks; returns whether no door failed.
pub fn run(options: &Options) -> Result<bool> {
    let mut doors: Vec<Door> = Vec::new();
    for (program, features) in PROGRAMS {
        if options.doors.is_empty() || options.doors.iter().any(|name| doors.iter().all(|door| door.name != *name)) {
            let program = build(program, features)?;
            let names = printed(&mut Command::new(&program))?;
            doors.extend(names.lines().map(|name| Door { name: name.to_owned(), program: program.clone() }));
        }
    }
    for asked in &options.doors {
        let names = || doors.iter().map(|door| door.name.as_str()).collect::<Vec<_>>().join(", ");
        ensure!(doors.iter().any(|door| door.name == *asked), "no door {asked}; there are {}", names());
    }
    doors.retain(|door| options.doors.is_empty() || options.doors.contains(&door.name));
    let workers = thread::available_parallelism().map_or(1, usize::from).min(doors.len());
    let seconds = (options.minutes * 60.0 * workers as f64 / doors.len() as f64).max(1.0);
    println!("| Door | Executions | Executions/s | Failed |\n|---|---:|---:|---|");
    let (queue, passed) = (Mutex::new(doors.iter()), Mutex::new(Ok(true)));
    thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(door) = queue.lock().ok().and_then(|mut queue| queue.next()) {
                    let outcome = attack(door, seconds, options.keep);
                    if let (Ok(mut passed), false) = (passed.lock(), matches!(outcome, Ok(true))) {
                        *passed = outcome;
                    }
                }
            });
        }
    });
    passed.into_inner().unwrap_or(Ok(false))
}

/// Builds a program of the package with counters of branches.
fn build(program: &str, features: &str) -> Result<PathBuf> {
    let about = printed(Command::new("rustc").arg("-vV"))?;
    let host = about.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc names no host")?;
    let mut cargo = cargo(&["build", "--profile", "fuzz", "--package", "attack", "--bin", program], &root());
    // With a target, neither build scripts nor macros have counters.
    cargo.args(["--no-default-features", "--features", features, "--target", host]);
    let status = cargo.env("CARGO_ENCODED_RUSTFLAGS", COVERAGE.join("\u{1f}")).status()?;
    ensure!(status.success(), "{program} cannot be built; libFuzzer needs a C++ compiler");
    Ok(target_dir()?.join(host).join("fuzz").join(program))
}

/// A folder of the attacks in the target directory.
fn folder(name: &str) -> Result<PathBuf> {
    let folder = target_dir()?.join("attack").join(name);
    fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// The kept corpus of a door.
fn archive(door: &str) -> PathBuf {
    root().join("attack/corpus").join(format!("{door}.zip"))
}

/// Attacks a door for some seconds, up to its first failure, and prints its row; whether it had none.
fn attack(door: &Door, seconds: f64, keep: bool) -> Result<bool> {
    let Door { name, program } = door;
    let (own, failed) = (folder(name)?, folder("failed")?);
    if let Ok(file) = File::open(archive(name)) {
        ZipArchive::new(file)?.extract(&own)?;
    }
    let log = own.with_extension("log");
    let mut fuzzer = Command::new(program);
    fuzzer.env("ATTACK_DOOR", name).arg(&own).args(LIMITS).arg(format!("-max_total_time={seconds:.0}"));
    fuzzer.arg(format!("-artifact_prefix={}/{name}-", failed.display()));
    let status = fuzzer.stdout(Stdio::null()).stderr(File::create(&log)?).status()?;
    let mut text = Vec::new();
    File::open(&log)?.read_to_end(&mut text)?;
    let text = String::from_utf8_lossy(&text);
    let after = |start: &str| text.lines().find_map(|line| Some(line.split_once(start)?.1.trim()));
    let count = after("stat::number_of_executed_units:").and_then(|count| count.parse::<f64>().ok()).unwrap_or(0.0);
    let failure = if status.success() { "" } else { after("Test unit written to ").unwrap_or("see its log") };
    println!("| {name} | {count} | {:.0} | {failure} |", count / seconds);
    if keep && status.success() {
        keep_least(door, &own)?;
    }
    Ok(status.success())
}

/// Keeps the smallest corpus with the coverage of everything that was found.
fn keep_least(door: &Door, all: &Path) -> Result<()> {
    let least = folder(&format!("{}.least", door.name))?;
    fs::remove_dir_all(&least)?;
    fs::create_dir_all(&least)?;
    let mut merge = Command::new(&door.program);
    merge.env("ATTACK_DOOR", &door.name).arg("-merge=1").arg(&least).arg(all);
    ensure!(merge.stderr(Stdio::null()).status()?.success(), "the corpora of {} cannot be merged", door.name);
    let mut inputs = Vec::new();
    for entry in fs::read_dir(&least)? {
        let entry = entry?;
        inputs.push((fs::read(entry.path())?, entry.file_name().to_string_lossy().into_owned()));
    }
    inputs.sort_by_key(|(bytes, name)| (bytes.len(), name.clone()));
    let (mut archive, mut left) = (ZipWriter::new(File::create(archive(&door.name))?), MOST_BYTES);
    for (bytes, name) in &inputs {
        let Some(rest) = left.checked_sub(bytes.len()) else { break };
        left = rest;
        archive.start_file(name.as_str(), SimpleFileOptions::default())?;
        archive.write_all(bytes)?;
    }
    archive.finish()?;
    Ok(())
}
