//! Extracts the firmware code of README.md, so that a test compiles it.

use std::{env, fs, path::Path};

fn main() {
    let folder = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let readme = Path::new(&folder).join("../README.md");
    println!("cargo::rerun-if-changed={}", readme.display());
    let text = fs::read_to_string(&readme).unwrap_or_default();
    let block = text.split("<!-- src/monitor.rs -->\n```rust\n").nth(1).and_then(|rest| rest.split("```").next());
    match (block, env::var("OUT_DIR")) {
        (Some(code), Ok(out)) if code.contains("pub fn current_loop(") => {
            if let Err(error) = fs::write(Path::new(&out).join("readme.rs"), code) {
                println!("cargo::error=cannot write the code of README.md: {error}");
            }
        }
        _ => println!("cargo::error=README.md has no firmware code of `src/monitor.rs`"),
    }
}
