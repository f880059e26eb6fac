//! The workbench as one page for a browser: the program, compiled to WebAssembly, and the files of `workbench/web`.
//!
//! ```text
//! workbench/cli ─► bearing-watch.wasm ─► gzip, base64 ─┐
//! workbench/web: index.html, style.css, *.js ──────────┴─► bearing-watch.html
//! ```

mod build;
pub mod compare;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::firmware::way::Way;
use crate::{child, workspace};

use build::{TARGET, program};

/// Modules of the worker and of the page: each after those that it imports.
const WORKER: [&str; 3] = ["files.js", "wasi.js", "worker.js"];
const PAGE: [&str; 10] = [
    "dom.js",
    "program.js",
    "texts.js",
    "zip.js",
    "session.js",
    "runs.js",
    "description.js",
    "recordings.js",
    "live.js",
    "page.js",
];
/// Largest size of the page, in bytes.
const MOST: usize = 8_000_000;

/// What was built.
pub struct Built {
    pub program: PathBuf,
    pub page: PathBuf,
}

/// The files of the page.
pub fn sources() -> PathBuf {
    workspace::root().join("workbench/web")
}

/// Builds the program and the page around it; returns both files.
pub fn page(asked: Option<Way>) -> Result<Built> {
    let way = Way::ready_for(asked, TARGET, [&["clang"], &["compiler", "wasm"]])?;
    let program = program(way)?;
    Ok(Built { page: around(&program)?, program })
}

/// Writes the page around a program.
fn around(program: &Path) -> Result<PathBuf> {
    let folder = workspace::target_dir().join("web");
    fs::create_dir_all(&folder)?;
    let read = |name: &str| fs::read_to_string(sources().join(name)).with_context(|| name.to_owned());
    let joined = |names: &[&str]| -> Result<String> {
        names.iter().map(|name| Ok(without_modules(&read(name)?))).collect::<Result<String>>()
    };
    let packed = folder.join("bearing-watch.wasm.gz");
    let text = child::output(
        Command::new("sh").args(["-c", r#"gzip -9 -n -c "$0" > "$1" && base64 -w 0 "$1""#]).args([program, &packed]),
    );
    let parts = [
        ("/*{{style}}*/", read("style.css")?),
        ("//{{worker}}", joined(&WORKER)?),
        ("//{{page}}", joined(&PAGE)?),
        ("{{program}}", text.context("gzip and base64 failed")?),
    ];
    let mut page = read("index.html")?;
    for (place, content) in parts {
        ensure!(page.matches(place).count() == 1, "index.html has no single place {place}");
        ensure!(!content.contains("</script"), "{place}: a script would end early");
        page = page.replace(place, &content);
    }
    ensure!(page.len() <= MOST, "the page has {} bytes, more than {MOST}", page.len());
    let file = folder.join("bearing-watch.html");
    fs::write(&file, page)?;
    Ok(file)
}

/// A module without its imports and exports, to be joined with those that it imports.
fn without_modules(text: &str) -> String {
    let kept = text.lines().filter(|line| !line.starts_with("import "));
    kept.map(|line| format!("{}\n", line.strip_prefix("export ").unwrap_or(line))).collect()
}
