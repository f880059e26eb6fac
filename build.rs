//! Gives the examples for bare chips the memory map of a board, and with the feature `defmt` its linker script. Crates
//! that use this one get nothing from it.

use std::env;
use std::path::Path;

/// Names a folder of `boards`.
const VARIABLE: &str = "BEARING_WATCH_BOARD";

const USUAL: &str = "stm32f405";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
        println!("cargo::rustc-link-arg-examples=-Tdefmt.x");
    }
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    let board = env::var(VARIABLE).unwrap_or_else(|_| USUAL.to_owned());
    let folder = Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("boards").join(&board);
    let map = folder.join("memory.x");
    println!("cargo::rerun-if-changed={}", map.display());
    if map.is_file() {
        println!("cargo::rustc-link-arg-examples=-L{}", folder.display());
    } else {
        println!("cargo::error={VARIABLE}={board}: there is no {}", map.display());
    }
}
