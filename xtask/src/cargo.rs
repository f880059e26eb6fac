//! The cargo that runs this program, and what it builds for the host.

use std::env;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::child;
use crate::workspace::{root, target_dir};

/// A call of the cargo that started this program, at the workspace's root.
pub fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root());
    if !["python3", "python"].into_iter().any(child::on_path) {
        // The package's interface is the stable one, which needs no interpreter to be built.
        command.env("PYO3_NO_PYTHON", "1");
    }
    command
}

/// What cargo knows of the packages of the workspace.
pub fn metadata() -> Result<Vec<Value>> {
    let text = child::output(&mut cargo(&["metadata", "--format-version", "1", "--no-deps", "--locked"]));
    let mut metadata: Value = serde_json::from_str(&text.context("cargo metadata failed")?)?;
    let packages = metadata.pointer_mut("/packages").and_then(Value::as_array_mut).map(std::mem::take);
    packages.context("no packages")
}

/// All files that git has or would add, by their names from the root.
pub fn files() -> Result<Vec<String>> {
    let arguments = ["ls-files", "--cached", "--others", "--exclude-standard"];
    let list = child::output(Command::new("git").args(arguments).current_dir(root())).context("git ls-files failed")?;
    // A file that is removed but not committed is still listed.
    Ok(list.lines().filter(|name| root().join(name).exists()).map(ToOwned::to_owned).collect())
}

/// The folder of the compiler's libraries.
pub fn sysroot() -> Option<String> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    child::output(Command::new(rustc).args(["--print", "sysroot"]))
}

/// What `cargo test` builds and runs: unit tests and those in `tests`, with the programs that they call.
pub const TESTS: &str = "--tests";

/// Whether this run, or one beside it, builds the host tests.
static WITH_TESTS: AtomicBool = AtomicBool::new(false);

/// Says that this run, or one beside it, builds the host tests.
pub fn tests_are_built() {
    WITH_TESTS.store(true, Ordering::Relaxed);
}

/// Returns a call of the command line `bearing-watch` at the workspace's root. Where the host tests are built it is
/// built with them: a build of the program alone has other features of dependencies, and would compile the workbench
/// again.
pub fn workbench() -> Result<Command> {
    let with_tests = WITH_TESTS.load(Ordering::Relaxed);
    let way: &[&str] = if with_tests { &["test", "--no-run", TESTS] } else { &["build", "--bin", "bearing-watch"] };
    child::succeed(cargo(way).args(["--quiet", "--workspace"]))?;
    Ok(built("bearing-watch"))
}

/// Returns a call of another program (`--bin`) or of an example (`--example`) at the workspace's root. It is built from
/// what the host tests are built from: by package its dependencies would have other features.
pub fn program(kind: &str, name: &str) -> Result<Command> {
    child::succeed(&mut cargo(&["build", "--quiet", "--workspace", kind, name]))?;
    Ok(built(&if kind == "--example" { format!("examples/{name}") } else { name.to_owned() }))
}

/// The lines that an example prints on the host.
pub fn lines_of_example(name: &str) -> Result<Vec<String>> {
    child::printed(&mut program("--example", name)?).context("on the host")
}

fn built(program: &str) -> Command {
    let mut command = Command::new(target_dir().join(format!("debug/{program}{}", env::consts::EXE_SUFFIX)));
    command.current_dir(root());
    command
}

/// Runs the host tests that take minutes, in release, and passes on what they print. Returns the table's rows, which
/// are the lines that start with `|`.
pub fn measure_long() -> Result<Vec<String>> {
    let mut cargo = cargo(&["test", "--release", "--package", "host-tests", "--no-fail-fast"]);
    let mut table = Vec::new();
    let status = child::lines(cargo.args(["--", "--ignored", "--show-output", "--test-threads", "1"]), |line| {
        println!("{line}");
        table.extend(line.starts_with('|').then(|| line.to_owned()));
    })?;
    ensure!(status.success() && !table.is_empty(), "a test of minutes failed ({status})");
    Ok(table)
}
