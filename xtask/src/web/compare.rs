//! The program of the page beside the native one: the same commands on the same files give the same bytes, printed and
//! written.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use super::sources;
use crate::report::Tally;
use crate::{cargo, child, workspace};

/// Recordings, from nothing or from a folder of data, and the commands on them.
struct Case {
    title: &'static str,
    /// A folder of recorded data, and how the names start of the files that are taken.
    data: Option<(&'static str, &'static str)>,
    commands: &'static str,
}

/// Simulated recordings have all kinds of pages; of the recorded ones each is of another kind: without a time, with
/// labels and a tidy table, with few long recordings.
const CASES: [Case; 5] = [
    Case {
        title: "the standard rig",
        data: None,
        commands: "simulate --class healthy,spall,roughness --count 12 --condition mix --severity 0.5 --out bench
            init bench --out drive.toml --json
            audit drive.toml --report audit.html
            train drive.toml --bearing 9,3,17,10 --model out.bwm --rust model.rs --c model.h --report train.html --json
            evaluate drive.toml --model out.bwm --report evaluate.html --json
            replay --model out.bwm bench --report replay.html --json",
    },
    Case {
        title: "the actuator",
        data: None,
        commands: "simulate --rig ema --class healthy,spall --count 6 --seed 1 --out bench
            init bench --out drive.toml --json
            audit drive.toml --report audit.html
            train drive.toml --model out.bwm --rust model.rs --report train.html --json
            replay --model out.bwm bench --report replay.html --json",
    },
    Case {
        title: "microchip_pmsm",
        data: Some(("microchip_pmsm", "")),
        commands: "init runs --rate-hz 1919 --out drive.toml --json
            audit drive.toml --report audit.html
            train drive.toml --model out.bwm --rust model.rs --report train.html --json
            evaluate drive.toml --model out.bwm --report evaluate.html --json
            replay --model out.bwm runs --report replay.html --json",
    },
    Case {
        title: "cranfield_ema",
        data: Some(("cranfield_ema", "")),
        commands: "init runs --out drive.toml --json
            train drive.toml --model out.bwm --rust model.rs --report train.html --json
            evaluate drive.toml --model out.bwm --report evaluate.html --json",
    },
    Case {
        title: "dc_motor_reference",
        data: Some(("dc_motor_reference", "trace labels")),
        commands: "init runs --out drive.toml --json
            train drive.toml --model out.bwm --rust model.rs --report train.html --json
            replay --model out.bwm runs --report replay.html --json",
    },
];

/// All cases, where Node.js is there to run the program.
pub fn checks(tally: &mut Tally, program: &Path) {
    let native = cargo::workbench();
    for case in &CASES {
        let title = format!("same bytes as the native program: {}", case.title);
        let outcome = native.as_ref().map_err(|error| anyhow::anyhow!("{error:#}"));
        match (hindrance(case), outcome) {
            (Some(hindrance), _) => tally.missing(&title, &hindrance),
            (None, native) => tally.check(&title, native.and_then(|native| compare(case, native, program))),
        }
    }
}

/// Why a case cannot be run; nothing if it can.
fn hindrance(case: &Case) -> Option<String> {
    if !child::on_path("node") {
        return Some("no Node.js on the search path".to_owned());
    }
    let folder = case.data.map(|(name, _)| data().join(name));
    folder.filter(|folder| !folder.is_dir()).map(|folder| format!("no recorded data in {}", folder.display()))
}

/// The recorded data, see CONTRIBUTING.md.
fn data() -> PathBuf {
    std::env::var_os("BEARING_WATCH_DATA").map_or_else(|| workspace::root().join("../shared/data"), PathBuf::from)
}

/// An empty folder below that of the page, with the files of a case.
fn folder(case: &Case, name: &str) -> Result<PathBuf> {
    let folder = workspace::target_dir().join("web/compare").join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(folder.join("runs"))?;
    let Some((from, starts)) = case.data else { return Ok(folder) };
    for entry in fs::read_dir(data().join(from))? {
        let name = entry?.file_name();
        let starts: Vec<&str> = starts.split_whitespace().collect();
        if starts.is_empty() || starts.iter().any(|start| name.to_string_lossy().starts_with(start)) {
            fs::copy(data().join(from).join(&name), folder.join("runs").join(&name))?;
        }
    }
    Ok(folder)
}

/// The program of the page in Node.js, on a folder.
fn in_node(program: &Path, folder: &Path) -> Command {
    let mut node = Command::new("node");
    node.arg("--no-warnings").arg(sources().join("tests/program.mjs")).arg(program).arg(folder);
    node
}

fn compare(case: &Case, native: &Command, program: &Path) -> Result<String> {
    let folders = [folder(case, "native")?, folder(case, "page")?];
    let mut files = 0;
    for line in case.commands.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let mut command = Command::new(native.get_program());
        let native = child::captured(command.args(&words).current_dir(&folders[0]))?;
        let page = child::captured(in_node(program, &folders[1]).args(&words))?;
        let errors = || String::from_utf8_lossy(&page.stderr).into_owned();
        // An audit that finds something ends with 1.
        ensure!(native.status.code() < Some(2), "{line}: {}", String::from_utf8_lossy(&native.stderr));
        ensure!(native.status.code() == page.status.code(), "{line}: {:?}: {}", page.status.code(), errors());
        ensure!(native.stdout == page.stdout, "{line}: {}", difference(&native.stdout, &page.stdout));
        let [one, other] = [contents(&folders[0])?, contents(&folders[1])?];
        ensure!(one.keys().eq(other.keys()), "{line}: {:?} and {:?}", one.keys(), other.keys());
        for (name, bytes) in &one {
            ensure!(bytes == &other[name], "{line}: {name}: {}", difference(bytes, &other[name]));
        }
        files = one.len();
    }
    Ok(format!("{files} files"))
}

/// All files of a folder, by their names.
fn contents(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            all.extend(contents(&path)?.into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            all.insert(name, fs::read(&path)?);
        }
    }
    Ok(all)
}

/// Where two files part.
fn difference(one: &[u8], other: &[u8]) -> String {
    let at = one.iter().zip(other).take_while(|(a, b)| a == b).count();
    let around = |bytes: &[u8]| {
        let (from, to) = (at.saturating_sub(60), (at + 40).min(bytes.len()));
        String::from_utf8_lossy(&bytes[from.min(to)..to]).into_owned()
    };
    format!("byte {at} of {} and {}: native `{}`, page `{}`", one.len(), other.len(), around(one), around(other))
}

/// Prints how long the training of the standard rig takes in the release build on one thread, and in Node.js.
pub fn measure(program: &Path) -> Result<()> {
    let case = &CASES[0];
    let mut build = cargo::cargo(&["build", "--quiet", "--release", "--workspace", "--bin", "bearing-watch"]);
    child::succeed(&mut build)?;
    let native = workspace::target_dir().join("release/bearing-watch");
    let place = folder(case, "measure")?;
    let train = case.commands.lines().find(|line| line.contains("train ")).context("no training")?;
    let run = |command: &mut Command| -> Result<Duration> {
        let start = Instant::now();
        let output = child::captured(command.stdin(Stdio::null()))?;
        ensure!(output.status.code() < Some(2), "{}", String::from_utf8_lossy(&output.stderr));
        Ok(start.elapsed())
    };
    let on_one_thread = |words: &[&str]| {
        let mut command = Command::new(&native);
        command.args(words).current_dir(&place).env("RAYON_NUM_THREADS", "1");
        command
    };
    for line in case.commands.lines().take(2) {
        run(&mut on_one_thread(&line.split_whitespace().collect::<Vec<_>>()))?;
    }
    let words: Vec<&str> = train.split_whitespace().collect();
    let mut times = [Duration::MAX; 2];
    for _ in 0..3 {
        times[0] = times[0].min(run(&mut on_one_thread(&words))?);
        times[1] = times[1].min(run(in_node(program, &place).args(&words))?);
    }
    let [native, page] = times.map(|time| time.as_secs_f64());
    println!("train on the standard rig, 36 traces: native on one thread {native:.2} s, in Node.js {page:.2} s");
    println!("speed of the page: {:.2} of the native program", native / page);
    Ok(())
}
