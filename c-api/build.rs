//! Gives the library the plan that an environment variable names.

use std::path::Path;
use std::{env, fs};

/// Names a file that `bearing-watch train --rust` wrote, from the folder of this crate or absolute. If it is unset or
/// empty, the library takes every model up to fixed sizes.
const VARIABLE: &str = "BEARING_WATCH_PLAN";

/// What the file contains if it has a front end.
const FRONT_END: &str = "pub type DriveFrontEnd = ";
/// What it contains if that takes the quadrature current of the drive's own control.
const QUADRATURE: &str = "drive::PhaseCounts::Quadrature(";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    println!("cargo::rustc-check-cfg=cfg(bearing_watch_plan, bearing_watch_front_end, bearing_watch_quadrature)");
    let file = env::var(VARIABLE).unwrap_or_default();
    if file.is_empty() {
        return;
    }
    let path = Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join(&file);
    println!("cargo::rerun-if-changed={}", path.display());
    if let Ok(source) = fs::read_to_string(&path) {
        println!("cargo::rustc-cfg=bearing_watch_plan");
        // It was trained with `--front-end`.
        if source.contains(FRONT_END) {
            println!("cargo::rustc-cfg=bearing_watch_front_end");
            if source.contains(QUADRATURE) {
                println!("cargo::rustc-cfg=bearing_watch_quadrature");
            }
        }
        println!("cargo::rustc-env=BEARING_WATCH_PLAN_FILE={}", path.display());
    } else {
        println!("cargo::error={VARIABLE}={file}: there is no {}", path.display());
    }
}
