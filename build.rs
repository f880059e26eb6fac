//! Gives the examples for bare chips the memory map of a board, and with the feature `defmt` its linker script. Crates
//! that use this one get nothing from it.

use std::env;
use std::path::Path;

/// Names a folder of `boards`. If it is unset or empty, the linker reads the `memory.x` at the top of the repository.
const VARIABLE: &str = "BEARING_WATCH_BOARD";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
        println!("cargo::rustc-link-arg-examples=-Tdefmt.x");
    }
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    println!("cargo::rerun-if-changed=memory.x");
    let board = env::var(VARIABLE).unwrap_or_default();
    if board.is_empty() {
        return;
    }
    let top = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let map = Path::new(&top).join("boards").join(&board).join("memory.x");
    println!("cargo::rerun-if-changed={}", map.display());
    if map.is_file() {
        // An `-L` would not do: the linker searches its working directory first, which holds the default map. This
        // option needs LLD.
        println!("cargo::rustc-link-arg-examples=--remap-inputs=memory.x={}", map.display());
    } else {
        println!("cargo::error={VARIABLE}={board}: there is no {}", map.display());
    }
}
