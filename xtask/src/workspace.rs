//! Where things are: the workspace's root, its target directory, the cargo that runs us.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result};

use crate::child;

/// The workspace's root.
pub fn root() -> PathBuf {
    // Cargo sets the variable for `cargo run`; the compiled-in value serves a binary started by hand.
    let own =
        env::var_os("CARGO_MANIFEST_DIR").map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    own.parent().map_or_else(|| own.clone(), Path::to_path_buf)
}

/// Cargo's target directory for the host.
pub fn target_dir() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(
        || root().join("target"),
        // Relative to where the user stands, as cargo takes it.
        |named| std::path::absolute(&named).unwrap_or_else(|_| PathBuf::from(named)),
    )
}

/// The cargo that started this program, at the workspace's root.
pub fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root());
    if !["python3", "python"].into_iter().any(child::on_path) {
        // The package's interface is the stable one, which needs no interpreter to be built.
        command.env("PYO3_NO_PYTHON", "1");
    }
    command
}

/// All files that git has or would add, by their names from the root.
pub fn files() -> Result<Vec<String>> {
    let root = root();
    let arguments = ["ls-files", "--cached", "--others", "--exclude-standard"];
    let list = child::output(Command::new("git").args(arguments).current_dir(&root)).context("git ls-files failed")?;
    // A file that is removed but not committed is still listed.
    Ok(list.lines().filter(|name| root.join(name).exists()).map(ToOwned::to_owned).collect())
}

/// The compiler's name of this machine.
pub fn host() -> Result<String> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let about = child::output(Command::new(rustc).arg("-vV")).context("rustc -vV failed")?;
    let host = about.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc names no host")?;
    Ok(host.to_owned())
}

/// Whether this run has built the host tests, and the command line with them.
static HAS_TESTS: AtomicBool = AtomicBool::new(false);

/// Says that the host tests are built.
pub fn tests_are_built() {
    HAS_TESTS.store(true, Ordering::Relaxed);
}

/// Whether another process builds the host tests meanwhile.
static TESTS_ARE_BESIDE: AtomicBool = AtomicBool::new(false);

/// Says that another process builds the host tests meanwhile.
pub fn tests_are_beside() {
    TESTS_ARE_BESIDE.store(true, Ordering::Relaxed);
}

/// What `cargo test` builds and runs: unit tests and those in `tests`, with the programs that they call.
pub const TESTS: &str = "--tests";

/// Returns a call of the command line `bearing-watch` at the workspace's root. It is built unless the host tests were:
/// dependencies have other features in a build of the program alone, which would compile the workbench again. Where the
/// tests are built meanwhile, it is built with them, by the process that comes first.
pub fn workbench() -> Result<Command> {
    if !HAS_TESTS.load(Ordering::Relaxed) {
        let with_tests = TESTS_ARE_BESIDE.load(Ordering::Relaxed);
        let way: &[&str] = if with_tests { &["test", "--no-run", TESTS] } else { &["build", "--bin", "bearing-watch"] };
        child::succeed(cargo(way).args(["--quiet", "--workspace"]))?;
        tests_are_built();
    }
    Ok(built("bearing-watch"))
}

/// Returns a call of another program of this workspace at its root, built as [`example`] builds.
pub fn program(name: &str) -> Result<Command> {
    child::succeed(&mut cargo(&["build", "--quiet", "--workspace", "--bin", name]))?;
    Ok(built(name))
}

/// Returns a call of an example on the host at the workspace's root. It is built from what the host tests are built
/// from: by package its dependencies would have other features.
pub fn example(name: &str) -> Result<Command> {
    child::succeed(&mut cargo(&["build", "--quiet", "--workspace", "--example", name]))?;
    Ok(built(&format!("examples/{name}")))
}

fn built(program: &str) -> Command {
    let mut command = Command::new(target_dir().join(format!("debug/{program}{}", env::consts::EXE_SUFFIX)));
    command.current_dir(root());
    command
}
