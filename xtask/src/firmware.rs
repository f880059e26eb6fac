//! Builds an example for a board, either way.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::board::{Board, DRIVE, Memory};
use crate::toolchain::Way;
use crate::{c_symbols, child, setup, workspace};

/// The setting of the linker, for all bare Arm targets: cargo overlooks it under a target's name with a dot.
fn linker() -> String {
    let program = setup::of_compiler("ld.lld-19");
    format!(
        "target.'cfg(all(target_arch = \"arm\", target_os = \"none\"))'.linker = {:?}",
        program.display().to_string()
    )
}

/// Selects the memory map, see `build.rs`.
const BOARD: &str = "BEARING_WATCH_BOARD";

/// The packages with examples: the core, whose examples are there to be copied, and that of the programs that measure
/// and check.
const PACKAGES: [&str; 2] = ["bearing-watch", "target-tests"];

/// The folder of the programs that measure and check.
pub const MEASURING: &str = "target-tests/examples";

/// Names the model of the example `drive`, see `build.rs`.
pub const MODEL: &str = "BEARING_WATCH_MODEL";

/// The profile of firmware that has to be small: the whole program is optimised at once.
const SMALLEST: [&str; 3] = [r#"opt-level="s""#, r#"lto="fat""#, "codegen-units=1"];

/// Builds one example in release and returns its ELF file. Boards of one target share the place of that file: use it
/// before you build for another.
pub fn build(way: Way, board: Board, example: &str) -> Result<PathBuf> {
    build_with(way, board, example, &[])
}

/// Builds the example `drive` with the model of a source file.
pub fn build_with_model(way: Way, board: Board, example: &str, source: &Path) -> Result<PathBuf> {
    let (mut cargo, folder) = cargo(way, board);
    child::succeed(cargo.args(["--package", "bearing-watch", "--example", example]).env(MODEL, source))?;
    existing(folder.join("examples").join(example))
}

/// Builds one example with overflow checks in the core and in itself, and returns its ELF file, which replaces the one
/// of [`build`]. Other packages are built without: the compiler's library is shipped so, and `libm` has sums whose
/// checks the compiler cannot remove although they never overflow.
pub fn build_checked(way: Way, board: Board, example: &str) -> Result<PathBuf> {
    build_with(way, board, example, &PACKAGES.map(|name| format!("package.{name}.overflow-checks=true")))
}

/// Builds one example with the core and itself at `opt-level = "s"`, and returns its ELF file, which replaces the one
/// of [`build`].
pub fn build_small(way: Way, board: Board, example: &str) -> Result<PathBuf> {
    build_with(way, board, example, &PACKAGES.map(|name| format!(r#"package.{name}.opt-level="s""#)))
}

/// Builds one example with the profile of firmware that has to be small: `opt-level = "s"`, and the whole program
/// optimised at once. Returns its ELF file, which replaces the one of [`build`].
pub fn build_smallest(way: Way, board: Board, example: &str) -> Result<PathBuf> {
    build_with(way, board, example, &SMALLEST.map(String::from))
}

/// Builds one example with further settings of the profile.
fn build_with(way: Way, board: Board, example: &str, settings: &[String]) -> Result<PathBuf> {
    let (mut cargo, folder) = cargo_to("rustc", way, board);
    for setting in settings {
        cargo.args(["--config", &format!("profile.release.{setting}")]);
    }
    // By package, so that features which only host packages want do not leak in.
    cargo.args(["--package", package(example), "--example", example, "--no-default-features"]).args(features(example));
    if matches!(board.memory, Memory::Linker(_)) {
        // As build.rs does. A flag for this crate alone: the core is the same for all boards of a target.
        let flag = format!("link-arg=--remap-inputs=memory.x={}", board.memory.file().display());
        cargo.args(["--", "-C", &flag]);
    }
    child::succeed(&mut cargo)?;
    existing(folder.join("examples").join(example))
}

/// Checks every example with every feature of the core but `alloc`, which is for hosts. Checks, since each example is
/// also built with its own features, and building takes minutes.
pub fn check_all_features(way: Way, board: Board) -> Result<()> {
    const FEATURES: &str = "bounded,defmt,embedded-hal,embedded-storage,signature,telemetry,watch";
    for package in PACKAGES {
        let (mut cargo, _) = cargo_to("check", way, board);
        cargo.args(["--package", package, "--examples", "--no-default-features", "--features", FEATURES]);
        child::succeed(&mut cargo)?;
    }
    Ok(())
}

/// Builds the C interface as a static library that exports nothing else, for an exported plan or, if that is empty, for
/// any model; returns its file, which is the same for all plans and features.
pub fn build_c_library(way: Way, board: Board, plan: &str, features: &str) -> Result<PathBuf> {
    c_library((way, board), plan, &["--features", features])
}

/// The same with the profile of firmware that has to be small.
pub fn build_smallest_c_library(way: Way, board: Board, plan: &str) -> Result<PathBuf> {
    let settings = SMALLEST.map(|setting| format!("--config=profile.release.{setting}"));
    c_library((way, board), plan, &settings.each_ref().map(String::as_str))
}

fn c_library((way, board): (Way, Board), plan: &str, arguments: &[&str]) -> Result<PathBuf> {
    let (mut cargo, folder) = cargo(way, board);
    cargo.env("BEARING_WATCH_PLAN", plan);
    child::succeed(cargo.args(["--package", "bearing-watch-c", "--lib"]).args(arguments))?;
    c_symbols::export(board.utilities(), &existing(folder.join("libbearing_watch_c.a"))?)
}

/// Builds a crate outside the workspace, in its folder and with its configuration, and returns its ELF file.
pub fn build_crate(way: Way, folder: &Path, name: &str) -> Result<PathBuf> {
    built_in(cargo(way, DRIVE), folder, name)
}

/// The same with the model of a source file.
pub fn build_crate_with_model(way: Way, folder: &Path, name: &str, source: &Path) -> Result<PathBuf> {
    let (mut cargo, built) = cargo(way, DRIVE);
    cargo.env(MODEL, source);
    built_in((cargo, built), folder, name)
}

fn built_in((mut cargo, built): (Command, PathBuf), folder: &Path, name: &str) -> Result<PathBuf> {
    child::succeed(cargo.current_dir(folder))?;
    existing(built.join(name))
}

/// Builds the tests of a crate outside the workspace, in its folder, and returns the ELF file of one of them.
pub fn build_suite(way: Way, folder: &Path, test: &str) -> Result<PathBuf> {
    let (mut cargo, _) = cargo_to("test", way, DRIVE);
    cargo.args(["--no-run", "--test", test, "--message-format", "json-render-diagnostics"]).current_dir(folder);
    let messages = child::output(&mut cargo).context("the tests are not built")?;
    let messages = messages.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let mut made = messages.filter_map(|message| message.get("executable")?.as_str().map(PathBuf::from));
    existing(made.next().context("cargo names no program")?)
}

/// Builds the chip's program of the peers, a workspace of its own, against CMSIS-DSP's sources; returns its ELF file.
pub fn build_peers(way: Way, cmsis: &Path) -> Result<PathBuf> {
    let (mut cargo, folder) = cargo(way, DRIVE);
    child::succeed(cargo.args(["--manifest-path", "xtask/peers/chip/Cargo.toml"]).env("CMSIS_DSP", cmsis))?;
    existing(folder.join("peers-chip"))
}

/// The build command up to what is built, and the folder that then holds it.
fn cargo(way: Way, board: Board) -> (Command, PathBuf) {
    cargo_to("build", way, board)
}

fn cargo_to(command: &str, way: Way, board: Board) -> (Command, PathBuf) {
    let (mut cargo, folder) = match way {
        Way::Rustup => rustup(),
        Way::Debian => debian(),
    };
    cargo.args([command, "--release", "--target", board.target]);
    if way == Way::Debian {
        // After the subcommand: cargo drops a `--config` before it if there is another one after it.
        cargo.args(["-Z", "build-std=core", "--config", &linker()]);
    }
    match board.memory {
        Memory::Variable(folder) => cargo.env(BOARD, folder),
        Memory::Top | Memory::Linker(_) => cargo.env_remove(BOARD),
    };
    // Debug information takes a tenth of the build time, and no check reads it.
    cargo.env("CARGO_PROFILE_RELEASE_DEBUG", "false");
    // Flags from the environment would replace those of the configuration, which name the linker
    // script; the result would be an empty program.
    cargo.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
    (cargo, folder.join(board.target).join("release"))
}

fn existing(elf: PathBuf) -> Result<PathBuf> {
    if !elf.is_file() {
        bail!("cargo succeeded, but there is no {}", elf.display());
    }
    Ok(elf)
}

/// The features that an example asks for in `Cargo.toml`.
fn features(example: &str) -> &'static [&'static str] {
    match example {
        "logging" => &["--features", "defmt"],
        "panic_free" => &["--features", "embedded-hal,embedded-storage,signature,telemetry,watch"],
        "measure_interrupt" => &["--features", "watch"],
        "random_plans" => &["--features", "bounded"],
        "footprint_seal" | "footprint_signature" | "measure_signature" | "signed" => &["--features", "signature"],
        "storage" => &["--features", "embedded-storage"],
        "measure_telemetry" | "telemetry" => &["--features", "telemetry"],
        _ => &[],
    }
}

/// The package of an example.
fn package(example: &str) -> &'static str {
    let [core, tests] = PACKAGES;
    let copied = workspace::root().join("examples").join(example).with_extension("rs");
    if copied.is_file() { core } else { tests }
}

/// The names of all examples, sorted.
pub fn examples() -> Result<Vec<String>> {
    let mut names = Vec::new();
    for folder in ["examples", MEASURING] {
        for entry in workspace::root().join(folder).read_dir().with_context(|| format!("no folder `{folder}`"))? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "rs")
                && let Some(name) = path.file_stem()
            {
                names.push(name.to_string_lossy().into_owned());
            }
        }
    }
    names.sort();
    Ok(names)
}

fn rustup() -> (Command, PathBuf) {
    let folder = workspace::target_dir();
    let mut cargo = workspace::cargo(&[]);
    // Said, because a workspace of its own would else have a folder of its own.
    cargo.env("CARGO_TARGET_DIR", &folder);
    (cargo, folder)
}

/// Debian has no library for the target: core is built from its source, which wants the nightly
/// option `build-std`, and that in turn the variable that lets a stable compiler take it.
fn debian() -> (Command, PathBuf) {
    let mut cargo = Command::new(setup::of_compiler("cargo"));
    let folder = of_debian(&mut cargo);
    (cargo, folder)
}

/// Gives a command Debian's compiler; returns the target directory.
fn of_debian(command: &mut Command) -> PathBuf {
    // A folder of its own: two compilers in one would take turns rebuilding.
    let folder = workspace::target_dir().join("fw");
    command
        .current_dir(workspace::root())
        .env("RUSTC", setup::of_compiler("rustc"))
        .env("RUSTDOC", setup::of_compiler("rustdoc"))
        .env("RUSTC_BOOTSTRAP", "1")
        .env("CARGO_TARGET_DIR", &folder)
        // What the cargo that started us leaves behind points at its own compiler's libraries.
        .env_remove("CARGO")
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("LD_LIBRARY_PATH");
    folder
}

/// Lets a program that calls cargo check for chips, and returns the further arguments of cargo.
pub fn prepare(caller: &mut Command, way: Way) -> &'static [&'static str] {
    if way == Way::Rustup {
        return &[];
    }
    of_debian(caller);
    caller.env("CARGO", setup::of_compiler("cargo"));
    &["-Z", "build-std=core,alloc"]
}
