//! Extracts the firmware code of README.md, so that a test compiles it.

use std::{env, fs, path::Path};

fn main() {
    let folder = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let readme = Path::new(&folder).join("../README.md");
    println!("cargo::rerun-if-changed={}", readme.display());
    let text = fs::read_to_string(&readme).unwrap_or_default();
    let block =
        text.split("<!-- compiled by host-tests -->\n```rust\n").nth(1).and_then(|rest| rest.split("```").next());
    let model = "mod model { include!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/../examples/support/standard_rig/model.rs\")); }";
    match (block, env::var("OUT_DIR")) {
        (Some(code), Ok(out)) if code.starts_with("mod model;") => {
            if let Err(error) = fs::write(Path::new(&out).join("readme.rs"), code.replacen("mod model;", model, 1)) {
                println!("cargo::error=cannot write the code of README.md: {error}");
            }
        }
        _ => println!("cargo::error=README.md has no firmware code that starts with `mod model;`"),
    }
}
