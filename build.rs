//! Gives the examples for bare chips the memory map of a board, and with the feature `defmt` its linker script; and the
//! example `drive` its model. So for the programs of `target-tests`. Crates that use this one get nothing from it.

use std::env;
use std::path::{Path, PathBuf};

/// Names a folder of `boards`. If it is unset or empty, the linker reads the `memory.x` at the top of the repository.
const VARIABLE: &str = "BEARING_WATCH_BOARD";

/// Names a file that `bearing-watch train --front-end … --rust` wrote, from the top of the repository or absolute.
const MODEL: &str = "BEARING_WATCH_MODEL";

fn main() {
    let top = top();
    println!("cargo::rerun-if-changed={}", top.join("build.rs").display());
    model_of_drive(&top);
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
        println!("cargo::rustc-link-arg-examples=-Tdefmt.x");
    }
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    println!("cargo::rerun-if-changed={}", top.join("memory.x").display());
    // All maps: the one of another board may also be given to the linker.
    println!("cargo::rerun-if-changed={}", top.join("boards").display());
    let board = env::var(VARIABLE).unwrap_or_default();
    if board.is_empty() {
        return;
    }
    let map = top.join("boards").join(&board).join("memory.x");
    if map.is_file() {
        // An `-L` would not do: the linker searches its working directory first, which holds the default map. This
        // option needs LLD.
        println!("cargo::rustc-link-arg-examples=--remap-inputs=memory.x={}", map.display());
    } else {
        println!("cargo::error={VARIABLE}={board}: there is no {}", map.display());
    }
}

/// The folder of the memory maps: that of the package, or the one above it.
fn top() -> PathBuf {
    let package = PathBuf::from(env::var("CARGO_MANIFEST_DIR").unwrap_or_default());
    let above = package.parent().filter(|_| !package.join("memory.x").is_file()).map(Path::to_path_buf);
    above.unwrap_or(package)
}

fn model_of_drive(top: &Path) {
    println!("cargo::rerun-if-env-changed={MODEL}");
    let file = env::var(MODEL).ok().filter(|file| !file.is_empty());
    let file = file.unwrap_or_else(|| "examples/support/actuator/model.rs".into());
    let path = top.join(&file);
    println!("cargo::rerun-if-changed={}", path.display());
    println!("cargo::rustc-env=BEARING_WATCH_MODEL_FILE={}", path.display());
}
