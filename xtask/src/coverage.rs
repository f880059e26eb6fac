//! `cargo xtask coverage`: lines and regions of the core that tests reach, by folder, as a table.
//!
//! The compiler counts (`-C instrument-coverage`), in a target directory of its own; LLVM's tools of the compiler's
//! version read the counts. Regions are parts of the code without a branch. It is not part of `cargo xtask test`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde_json::Value;

use crate::setup::{self, LLVM};
use crate::{child, workspace};

/// Every feature of the core.
const FEATURES: &str = "alloc,bounded,defmt,embedded-hal,embedded-storage,signature,telemetry";

/// Options of the command.
#[derive(Args, Debug)]
pub struct Options {
    /// Also the tests of `host-tests` on the core, with the crates that they need: minutes.
    #[arg(long)]
    host_tests: bool,
    /// A row for each file instead of each folder.
    #[arg(long)]
    files: bool,
}

/// What tests reach of some code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Reached {
    lines: [u64; 2],
    regions: [u64; 2],
}

/// Runs the tests and prints the table.
pub fn run(options: &Options) -> Result<bool> {
    let (text, passed) = measure(options)?;
    print!("{text}");
    Ok(passed)
}

/// The table, and whether all tests passed.
fn measure(options: &Options) -> Result<(String, bool)> {
    setup::ensure(&[&LLVM])?;
    let target = workspace::target_dir().join("coverage");
    let profiles = target.join("profiles");
    if profiles.exists() {
        fs::remove_dir_all(&profiles)?;
    }
    fs::create_dir_all(&profiles)?;
    let mut programs = tests(&target, &["--package", "bearing-watch", "--lib", "--features", FEATURES])?;
    if options.host_tests {
        programs.extend(tests(&target, &["--package", "host-tests", "--test", "core"])?);
    }
    let mut passed = true;
    for program in &programs {
        let mut test = std::process::Command::new(program);
        // Tests of a package run in its folder.
        let is_core = program.file_name().is_some_and(|name| name.to_string_lossy().starts_with("bearing_watch-"));
        let folder = if is_core { workspace::root() } else { workspace::root().join("host-tests") };
        test.current_dir(folder).env("LLVM_PROFILE_FILE", profiles.join("%m-%p.profraw"));
        passed &= child::status(&mut test)?.success();
    }
    let merged = profiles.join("all.profdata");
    let mut merge = tool("llvm-profdata");
    merge.args(["merge", "-sparse", "-o"]).arg(&merged).args(raw(&profiles)?);
    child::succeed(&mut merge)?;
    let mut export = tool("llvm-cov");
    export.args(["export", "-summary-only", "-instr-profile"]).arg(&merged);
    for (place, program) in programs.iter().enumerate() {
        export.args((place > 0).then_some("-object")).arg(program);
    }
    let summary = child::output(&mut export).context("llvm-cov exports nothing")?;
    Ok((table(&reached(&summary, options.files)?), passed))
}

fn tool(name: &str) -> std::process::Command {
    let mut command = std::process::Command::new(format!("{name}-{}", setup::LLVM_VERSION));
    command.env("PATH", child::search_path());
    command
}

/// Builds tests with counts; returns the programs.
fn tests(target: &Path, arguments: &[&str]) -> Result<Vec<PathBuf>> {
    let mut cargo = workspace::cargo(&["test", "--no-run", "--message-format", "json-render-diagnostics"]);
    // With a target, neither build scripts nor macros are counted.
    cargo.args(["--target", &workspace::host()?]).args(arguments).env("CARGO_TARGET_DIR", target);
    cargo.env("CARGO_ENCODED_RUSTFLAGS", "-Cinstrument-coverage");
    let lines = child::printed(&mut cargo)?;
    let programs = lines.iter().filter_map(|line| {
        let message: Value = serde_json::from_str(line).ok()?;
        Some(PathBuf::from(message.get("executable")?.as_str()?))
    });
    let programs: Vec<PathBuf> = programs.collect();
    ensure!(!programs.is_empty(), "cargo built no test");
    Ok(programs)
}

fn raw(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in folder.read_dir()? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "profraw") {
            files.push(path);
        }
    }
    ensure!(!files.is_empty(), "no test wrote counts");
    Ok(files)
}

/// What of the core is reached, by folder or file; files of tests alone are left out.
fn reached(summary: &str, by_file: bool) -> Result<BTreeMap<String, Reached>> {
    let summary: Value = serde_json::from_str(summary).context("llvm-cov's summary is no JSON")?;
    let files = summary.pointer("/data/0/files").and_then(Value::as_array).context("a summary without files")?;
    let source = workspace::root().join("src");
    let mut rows: BTreeMap<String, Reached> = BTreeMap::new();
    for file in files {
        let path = file.pointer("/filename").and_then(Value::as_str).unwrap_or_default();
        let Ok(name) = Path::new(path).strip_prefix(&source) else { continue };
        if name.file_name().is_some_and(|name| name == "tests.rs" || name == "testing.rs") {
            continue;
        }
        let folder = name.parent().filter(|folder| !folder.as_os_str().is_empty());
        let row = if by_file { name } else { folder.unwrap_or_else(|| Path::new("(files of src)")) };
        let own = rows.entry(row.display().to_string()).or_default();
        for (sums, kind) in [(&mut own.lines, "lines"), (&mut own.regions, "regions")] {
            for (sum, key) in sums.iter_mut().zip(["covered", "count"]) {
                *sum += file.pointer(&format!("/summary/{kind}/{key}")).and_then(Value::as_u64).unwrap_or(0);
            }
        }
    }
    ensure!(!rows.is_empty(), "no file of the core in the summary");
    Ok(rows)
}

fn table(rows: &BTreeMap<String, Reached>) -> String {
    let mut text = String::from("| Part of `src` | Lines | Reached | Regions | Reached |\n|---|---:|---:|---:|---:|\n");
    let mut all = Reached::default();
    for own in rows.values() {
        for (sums, more) in [(&mut all.lines, own.lines), (&mut all.regions, own.regions)] {
            sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
    }
    let total = "all".to_owned();
    for (name, Reached { lines, regions }) in rows.iter().chain([(&total, &all)]) {
        let share = |[reached, count]: [u64; 2]| 100.0 * reached as f64 / count.max(1) as f64;
        let ([_, count], [_, parts]) = (lines, regions);
        text += &format!("| {name} | {count} | {:.1} % | {parts} | {:.1} % |\n", share(*lines), share(*regions));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_summed_by_folder_and_tests_left_out() {
        let source = workspace::root().join("src");
        let file = |name: &str, covered: u64, count: u64| {
            let counts = serde_json::json!({ "covered": covered, "count": count });
            serde_json::json!({ "filename": source.join(name), "summary": { "lines": counts, "regions": counts } })
        };
        let files = [file("a/x.rs", 1, 2), file("a/y.rs", 3, 4), file("lib.rs", 1, 1), file("a/tests.rs", 0, 9)];
        let summary = serde_json::json!({ "data": [{ "files": files }] }).to_string();
        let rows = reached(&summary, false).expect("a summary");
        assert_eq!(rows["a"], Reached { lines: [4, 6], regions: [4, 6] });
        let text = table(&rows);
        assert!(text.ends_with("| a | 6 | 66.7 % | 6 | 66.7 % |\n| all | 7 | 71.4 % | 7 | 71.4 % |\n"), "{text}");
        assert!(reached("{}", false).is_err());
    }
}
