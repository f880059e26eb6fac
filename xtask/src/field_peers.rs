//! The second part of `cargo xtask peers`: the table of the field beside that of a plain program in numpy, on the same
//! records.

use std::fs;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::{child, peers, workspace};

/// Number of draws of training and validation sets. One takes about a quarter of an hour.
const DRAWS: &str = "1";
/// Exit code of the script if the detector is behind in a cell.
const BEHIND: i32 = 3;
/// Rows of the document, one for each way in which the field is hard.
pub const SHORT: &str = "mix,temperature,no-load-sensor,slip,duty-one-way,field-any";
const PACKAGE: [&str; 2] = ["--package", "bearing-watch-studies"];

/// Measures both on these rows, or on all. Returns the text to print, and whether the detector is nowhere behind.
pub fn measure(only: Option<&str>) -> Result<(String, bool)> {
    let folder = peers::folder();
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let python = peers::python_with_packages()?;
    let ours = folder.join("field.json");
    let mut cargo = workspace::cargo(&["run", "--release", "--quiet"]);
    cargo.args(PACKAGE).args(["--", "campaign", "--field", "--json", "--draws", DRAWS]);
    cargo.args(only.map_or_else(Vec::new, |rows| vec!["--only", rows]));
    peers::keep(&mut cargo, &ours)?;
    let mut cargo = workspace::cargo(&["build", "--release", "--quiet"]);
    child::succeed(cargo.args(PACKAGE).args(["--example", "field_records"]))?;
    let records = workspace::target_dir().join("release/examples/field_records");
    let mut script = Command::new(python);
    script.arg(peers::scripts().join("field.py")).args([records, ours]);
    let mut text = String::new();
    let status = child::lines(&mut script, |line| text = format!("{text}{line}\n"))?;
    match status.code() {
        Some(0) => Ok((text, true)),
        Some(BEHIND) => Ok((text, false)),
        _ => bail!("field.py failed ({status})"),
    }
}
