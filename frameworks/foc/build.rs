//! Lets the linker find the memory map at the top of the repository, and the compiler the model.

use std::env;

/// Names what `bearing-watch train --rust` has written.
const MODEL: &str = "BEARING_WATCH_MODEL";

fn main() {
    let package = env!("CARGO_MANIFEST_DIR");
    println!("cargo::rustc-link-search={package}/../..");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../../memory.x");
    println!("cargo::rerun-if-env-changed={MODEL}");
    if let Ok(file) = env::var(MODEL) {
        println!("cargo::rerun-if-changed={file}");
        println!("cargo::rustc-env=MODEL_FILE={file}");
    }
}
