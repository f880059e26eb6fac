//! Builds an example for a board, either way.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::board::{Board, DRIVE, Memory, RISCV};
use super::way::Way;
use crate::cargo::{cargo as host_cargo, metadata};
use crate::{child, setup, workspace};

/// The packages with examples: the core, whose examples are there to be copied, and that of the programs that measure
/// and check.
const PACKAGES: [&str; 2] = ["bearing-watch", "target-tests"];

/// Names the model of the example `drive`, see `build.rs`.
pub const MODEL: &str = "BEARING_WATCH_MODEL";

/// Settings of the profile. Overflow checks in the core and in the example: other packages are built without, since the
/// compiler's library is shipped so, and `libm` has sums whose checks the compiler cannot remove although they never
/// overflow.
pub const CHECKED: &[&str] =
    &["package.bearing-watch.overflow-checks=true", "package.target-tests.overflow-checks=true"];
/// The core and the example for size.
pub const SMALL: &[&str] = &[r#"package.bearing-watch.opt-level="s""#, r#"package.target-tests.opt-level="s""#];
/// For firmware that has to be small: the whole program is optimised at once.
pub const SMALLEST: &[&str] = &[r#"opt-level="s""#, r#"lto="fat""#, "codegen-units=1"];

/// Builds one example in release and returns its ELF file. Boards of one target, and builds with other settings, share
/// the place of that file: use it before you build another.
pub fn build(way: Way, board: Board, example: &str) -> Result<PathBuf> {
    build_with(way, board, example, &[], None)
}

/// The same with settings of the profile, and the model of a source file for the example `drive`.
pub fn build_with(way: Way, board: Board, example: &str, settings: &[&str], model: Option<&Path>) -> Result<PathBuf> {
    let (mut cargo, folder) = cargo("rustc", way, board);
    cargo.envs(model.map(|source| (MODEL, source)));
    for setting in settings {
        cargo.args(["--config", &format!("profile.release.{setting}")]);
    }
    let (package, features) = examples()?.into_iter().find(|(name, _)| name == example).context("no such example")?.1;
    // By package, so that features which only host packages want do not leak in.
    cargo.args(["--package", &package, "--example", example, "--no-default-features", "--features", &features]);
    if matches!(board.memory, Memory::Linker(_)) {
        // As build.rs does. A flag for this crate alone: the core is the same for all boards of a target.
        cargo.args(["--", "-C", &format!("link-arg=--remap-inputs=memory.x={}", board.memory.file().display())]);
    }
    child::succeed(&mut cargo)?;
    existing(folder.join("examples").join(example))
}

/// Checks every example with every feature of its package but `alloc`, which is for hosts. Checks, since each example
/// is also built with its own features, and building takes minutes.
pub fn check_all_features(way: Way, board: Board) -> Result<&'static str> {
    for package in metadata()?.iter().filter(|package| PACKAGES.iter().any(|name| package["name"] == *name)) {
        let features = package["features"].as_object().context("cargo names no features")?.keys();
        let features: Vec<&str> =
            features.map(String::as_str).filter(|name| !["alloc", "default"].contains(name)).collect();
        let (mut cargo, _) = cargo("check", way, board);
        cargo.args(["--package", package["name"].as_str().unwrap_or_default(), "--examples"]);
        child::succeed(cargo.args(["--no-default-features", "--features", &features.join(",")]))?;
    }
    Ok("")
}

/// Builds the C interface as a static library that exports nothing else, for an exported plan or, if that is empty, for
/// any model; returns its file, which is the same for all plans and features.
pub fn c_library((way, board): (Way, Board), plan: &str, features: &str, settings: &[&str]) -> Result<PathBuf> {
    let (mut cargo, folder) = cargo("build", way, board);
    cargo.env("BEARING_WATCH_PLAN", plan).args(["--package", "bearing-watch-c", "--lib", "--features", features]);
    cargo.args(settings.iter().map(|setting| format!("--config=profile.release.{setting}")));
    child::succeed(&mut cargo)?;
    // By the script that users call, which exports the functions `bw_…` alone.
    let (prefix, options) =
        if board == RISCV { ("riscv64-unknown-elf-", "-m elf32lriscv") } else { ("arm-none-eabi-", "") };
    let library = existing(folder.join("libbearing_watch_c.a"))?;
    let (made, mut shell) = (library.with_file_name("libbearing_watch.a"), Command::new("sh"));
    shell.arg(workspace::root().join("c-api/export.sh")).arg(prefix).args([&library, &made]).env("LD_FLAGS", options);
    child::succeed(&mut shell)?;
    let mut symbols = Command::new(format!("{prefix}nm"));
    let names = child::output(symbols.args(["-g", "--defined-only", "-j"]).arg(&made)).unwrap_or_default();
    let foreign = |line: &&str| !line.is_empty() && !line.ends_with(':') && !line.starts_with("bw_");
    let foreign: Vec<&str> = names.lines().filter(foreign).collect();
    ensure!(names.contains("\nbw_start\n") && foreign.is_empty(), "the library defines {foreign:?}");
    Ok(made)
}

/// Builds a crate outside the workspace, in its folder and with its configuration, with a variable that names a path,
/// such as [`MODEL`]; returns its ELF file.
pub fn build_crate(way: Way, folder: &Path, name: &str, variable: Option<(&str, &Path)>) -> Result<PathBuf> {
    let (mut cargo, built) = cargo("build", way, DRIVE);
    cargo.current_dir(folder).envs(variable);
    child::succeed(&mut cargo)?;
    existing(built.join(name))
}

/// Builds the tests of a crate outside the workspace, in its folder, and returns the ELF file of one of them.
pub fn build_suite(way: Way, folder: &Path, test: &str) -> Result<PathBuf> {
    let (mut cargo, _) = cargo("test", way, DRIVE);
    cargo.args(["--no-run", "--test", test, "--message-format", "json-render-diagnostics"]).current_dir(folder);
    let messages = child::output(&mut cargo).context("the tests are not built")?;
    let messages = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mut made = messages.filter_map(|message| message.get("executable")?.as_str().map(PathBuf::from));
    existing(made.next().context("cargo names no program")?)
}

/// The names of all examples, with their package and the features that they ask for.
pub fn examples() -> Result<Vec<(String, (String, String))>> {
    let mut examples = Vec::new();
    for package in metadata()? {
        let name = package["name"].as_str().unwrap_or_default();
        let targets = package["targets"].as_array().map(Vec::as_slice).unwrap_or_default();
        for target in targets.iter().filter(|target| PACKAGES.contains(&name) && target["kind"][0] == "example") {
            let features = target["required-features"].as_array().map(Vec::as_slice).unwrap_or_default();
            let features = features.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(",");
            examples.push((target["name"].as_str().unwrap_or_default().to_owned(), (name.to_owned(), features)));
        }
    }
    Ok(examples)
}

/// The call of cargo up to what is built, and the folder that then holds it.
fn cargo(command: &str, way: Way, board: Board) -> (Command, PathBuf) {
    let mut cargo = if way == Way::Rustup { host_cargo(&[]) } else { Command::new(setup::of_compiler("cargo")) };
    prepare(&mut cargo, way);
    cargo.current_dir(workspace::root()).args([command, "--release", "--target", board.target]);
    if way == Way::Debian {
        // After the subcommand: cargo drops a `--config` before it if there is another one after it. For all bare Arm
        // targets: cargo overlooks it under a target's name with a dot.
        let linker = setup::of_compiler("ld.lld-19").display().to_string();
        let target = r#"target.'cfg(all(target_arch = "arm", target_os = "none"))'"#;
        cargo.args(["-Z", "build-std=core,alloc", "--config", &format!("{target}.linker = {linker:?}")]);
    }
    match board.memory {
        // Selects the memory map, see `build.rs`.
        Memory::Variable(folder) => cargo.env("BEARING_WATCH_BOARD", folder),
        Memory::Top | Memory::Linker(_) => cargo.env_remove("BEARING_WATCH_BOARD"),
    };
    // Debug information takes a tenth of the build time, and no check reads it.
    cargo.env("CARGO_PROFILE_RELEASE_DEBUG", "false");
    // Flags from the environment would replace those of the configuration, which name the linker script; the result
    // would be an empty program.
    cargo.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
    let folder = workspace::target_dir().join(if way == Way::Rustup { "" } else { "fw" });
    (cargo, folder.join(board.target).join("release"))
}

/// Gives cargo, or what calls it, the compiler for chips. Debian has no library for the target: core is built from its
/// source, which wants the nightly option `build-std`, and that in turn the variable that lets a stable compiler take
/// it.
pub fn prepare(caller: &mut Command, way: Way) {
    if way == Way::Rustup {
        // Said, because a workspace of its own would else have a folder of its own.
        caller.env("CARGO_TARGET_DIR", workspace::target_dir());
        return;
    }
    caller
        .env("CARGO", setup::of_compiler("cargo"))
        .env("RUSTC", setup::of_compiler("rustc"))
        .env("RUSTDOC", setup::of_compiler("rustdoc"))
        .env("RUSTC_BOOTSTRAP", "1")
        // A folder of its own: two compilers in one would take turns rebuilding.
        .env("CARGO_TARGET_DIR", workspace::target_dir().join("fw"))
        // What the cargo that started us leaves behind points at its own compiler's libraries.
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("LD_LIBRARY_PATH");
}

fn existing(elf: PathBuf) -> Result<PathBuf> {
    ensure!(elf.is_file(), "cargo succeeded, but there is no {}", elf.display());
    Ok(elf)
}
