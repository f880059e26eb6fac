//! `cargo xtask release`: everything that is published, made and tested without publishing it, by the scripts of
//! `xtask/release`.

mod projects;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::builder::PossibleValuesParser;

use crate::cargo::{self, metadata};
use crate::firmware::board::{Board, DRIVE, NO_FPU, RISCV};
use crate::firmware::build::{self, c_library};
use crate::firmware::way::Way;
use crate::python::{tool, venv};
use crate::report::{Stages, Tally};
use crate::test::newcomer;
use crate::workspace::{root, target_dir};
use crate::{child, setup, test};

/// What the scripts get.
struct Call<'a> {
    way: Way,
    baseline: Option<&'a str>,
    script: Command,
}

/// A check: the part that it belongs to, its script, a program of another project that the script calls, and what else
/// the script gets.
type Check = (&'static str, &'static str, Option<&'static str>, fn(&mut Call<'_>) -> Result<()>);

const CHECKS: [Check; 10] = [
    ("packages", "packages", None, |_| Ok(())),
    ("c", "archive", None, archive),
    ("wheel", "wheel", Some("maturin"), wheel),
    ("sbom", "sbom", Some("cargo-cyclonedx"), |_| Ok(())),
    ("interface", "interface", None, interface),
    ("features", "features", Some("cargo-hack"), |_| Ok(())),
    ("features", "features", Some("cargo-hack"), |call| chip(call, DRIVE)),
    ("features", "features", Some("cargo-hack"), |call| chip(call, NO_FPU)),
    ("oldest", "oldest", None, |_| Ok(())),
    ("oldest", "oldest-compiler", None, |_| Ok(())),
];

/// What is released or checked; CONTRIBUTING.md describes the parts.
const PARTS: [&str; 8] = ["packages", "c", "wheel", "sbom", "interface", "features", "oldest", "dependencies"];

/// Options of the command.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// Parts, instead of all.
    #[arg(value_parser = PossibleValuesParser::new(PARTS))]
    parts: Vec<String>,
    /// The revision with which the public interface is compared, instead of the last release.
    #[arg(long)]
    baseline: Option<String>,
}

/// The folder of artefacts.
fn dist() -> PathBuf {
    target_dir().join("dist")
}

/// Makes and checks the parts, prints the table of artefacts; whether nothing failed.
pub fn run(options: &Options, way: Way) -> Result<bool> {
    fs::create_dir_all(dist())?;
    let mut stages = Stages::default();
    for part in PARTS.iter().filter(|part| options.parts.is_empty() || options.parts.iter().any(|own| own == *part)) {
        stages.stage(part, |tally| {
            for check in CHECKS.iter().filter(|check| check.0 == *part) {
                by_script(tally, check, way, options.baseline.as_deref());
            }
            match *part {
                "c" if tally.failed == 0 => projects::checks(tally, &dist()),
                "dependencies" => test::dependencies(tally),
                _ => {}
            }
        });
    }
    // Sums that `sha256sum --check` reads.
    let sums = "rm -f SHA256SUMS; ls | grep -q . && sha256sum * | tee SHA256SUMS | while read -r sum file; do
        printf '%-64s %10s  %s\n' \"$file\" \"$(wc -c < \"$file\")\" \"$sum\"; done";
    println!("\n{}", child::output(Command::new("sh").args(["-c", sums]).current_dir(dist())).unwrap_or_default());
    let changes = child::output(Command::new("git").args(["status", "--porcelain"]).current_dir(root()));
    if !changes.is_some_and(|changes| changes.is_empty()) {
        println!("not a release: the tree has changes that are not committed");
    }
    Ok(stages.end())
}

/// Runs a script of `xtask/release`, which knows the published packages with their folders. With status 77 it says what
/// is missing, with 78 why it has no place.
fn by_script(tally: &mut Tally, (_, name, program, prepare): &Check, way: Way, baseline: Option<&str>) {
    let mut last = String::new();
    let mut run = || {
        let mut published = Vec::new();
        for package in metadata()?.iter().filter(|package| package["publish"].is_null()) {
            let folder = Path::new(package["manifest_path"].as_str().unwrap_or_default()).parent();
            let folder = folder.and_then(|folder| folder.strip_prefix(root()).ok()).context("outside")?;
            published.push(format!("{}:./{}", package["name"].as_str().unwrap_or_default(), folder.display()));
        }
        let mut script = Command::new("sh");
        script.arg(format!("xtask/release/{name}.sh")).current_dir(root()).env("PUBLISHED", published.join(" "));
        script.env("VERSION", env!("CARGO_PKG_VERSION")).env("RUST_VERSION", env!("CARGO_PKG_RUST_VERSION"));
        script.env("DIST", dist()).env("TARGET", target_dir());
        if let Some(program) = program {
            script.env("TOOL", tool(program, &[])?.get_program());
        }
        let mut call = Call { way, baseline, script };
        prepare(&mut call)?;
        let mut script = call.script;
        let status = child::lines(&mut script, |line| {
            println!("{line}");
            line.clone_into(&mut last);
        })?;
        let words: Vec<_> = script.get_args().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
        anyhow::Ok((status, words.join(" ")))
    };
    match run() {
        Ok((status, words)) if status.code() == Some(77) => tally.missing(format!("{name} {words}").trim(), &last),
        Ok((status, _)) if status.code() == Some(78) => tally.skip(name, &last),
        Ok((status, words)) => {
            let outcome = status.success().then_some("").with_context(|| status.to_string());
            tally.check(format!("{name} {words}").trim(), outcome);
        }
        Err(error) => tally.check(name, Err::<&str, _>(error)),
    }
}

/// What the archive of the C library is made of.
fn archive(Call { way, script, .. }: &mut Call<'_>) -> Result<()> {
    setup::ensure(&["c-compiler", "make", "cmake", "riscv"])?;
    let folder = target_dir().join("archive");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let project = folder.join("project");
    fs::create_dir_all(&project)?;
    newcomer::write_project(&project, &root())?;
    // These take the place of those that use a checkout.
    let own = ["bearing_watch.mk", "cubemx.cmake"];
    newcomer::blocks::Blocks::of_document(projects::DOCUMENT)?.write(Some(&own), &project, &root())?;
    for name in newcomer::FILES.iter().chain(&["main.c", "Makefile", "CMakeLists.txt"]).chain(&own) {
        let to = folder.join("firmware").join(name);
        fs::create_dir_all(to.parent().context("no folder")?)?;
        fs::copy(project.join(name), to).with_context(|| format!("no {name}"))?;
    }
    for (name, board) in [("CHIP", DRIVE), ("RISCV", RISCV)] {
        if let Some(hindrance) = way.hindrance(board.target) {
            bail!("{hindrance}");
        }
        let library = c_library((*way, board), "", "", &[])?;
        script.env(name, board.target).env(format!("{name}_LIBRARY"), library);
    }
    script.env("FOLDER", folder);
    Ok(())
}

/// The revision with which the public interface is compared, if there is one: that of the newest tag of a release.
fn interface(Call { baseline, script, .. }: &mut Call<'_>) -> Result<()> {
    let mut describe = Command::new("git");
    describe.args(["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*"]).current_dir(root());
    if let Some(revision) = baseline.map(ToOwned::to_owned).or_else(|| child::output(&mut describe)) {
        script.env("BASELINE", revision).env("TOOL", tool("cargo-semver-checks", &[])?.get_program());
    }
    Ok(())
}

/// What the wheel is made and tried with.
fn wheel(Call { script, .. }: &mut Call<'_>) -> Result<()> {
    // Outside the checkout, whose configuration cargo would read.
    let folder = env::temp_dir().join(format!("bearing-watch-wheel-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    script.env("PYTHON", venv(&folder.join("venv"), true)?).env("FOLDER", folder);
    script.env("WORKBENCH", cargo::workbench()?.get_program());
    Ok(())
}

/// Lets cargo-hack check for a chip.
fn chip(Call { way, script, .. }: &mut Call<'_>, board: Board) -> Result<()> {
    if let Some(hindrance) = way.hindrance(board.target) {
        bail!("{}: {hindrance}", board.target);
    }
    build::prepare(script, *way);
    script.args(["--target", board.target]);
    script.args(if *way == Way::Debian { ["-Z", "build-std=core,alloc"].as_slice() } else { &[] });
    Ok(())
}
