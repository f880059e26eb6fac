//! Kernels of the core beside those of others, counted on the emulated chip in one run.
//!
//! CMSIS-DSP's C sources come in the Python package that wraps them, pinned by `peers/chip/requirements.txt`.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::firmware::board::DRIVE;
use crate::firmware::build::build_crate;
use crate::firmware::qemu;
use crate::firmware::way::Way;
use crate::python::with_packages;
use crate::{child, workspace};

/// Who the others are measured against.
const OURS: &str = "bearing-watch";

/// Fetches, builds, runs. Returns the table: every line with its ratio to ours of the same work.
pub fn table(way: Way) -> Result<String> {
    let folder = workspace::root().join("xtask/peers/chip");
    let elf = build_crate(way, &folder, "peers-chip", Some(("CMSIS_DSP", &cmsis()?)))?;
    rows(&qemu::run(&elf, DRIVE)?)
}

/// The folder of CMSIS-DSP's sources, fetched where it lacks.
fn cmsis() -> Result<PathBuf> {
    let list = workspace::root().join("xtask/peers/chip/requirements.txt");
    let pin = std::fs::read_to_string(&list).with_context(|| format!("no {}", list.display()))?;
    let version = pin.split_once("==").and_then(|(_, rest)| rest.split_whitespace().next());
    let name = format!("cmsisdsp-{}", version.with_context(|| format!("{} pins nothing", list.display()))?);
    let folder = workspace::target_dir().join("peers");
    let sources = folder.join(&name);
    if !sources.join("Source").is_dir() {
        let mut pip = Command::new(with_packages("peers-chip", &[])?);
        pip.args(["-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", "cmsisdsp", "--requirement"]);
        child::succeed(pip.arg(&list).arg("--dest").arg(&folder))?;
        let archive = folder.join(format!("{name}.tar.gz"));
        child::succeed(Command::new("tar").arg("-xzf").arg(archive).arg("-C").arg(&folder))?;
    }
    Ok(sources)
}

/// The table of the lines that the firmware printed, one JSON object each.
fn rows(lines: &[String]) -> Result<String> {
    let figures =
        lines.iter().map(|line| serde_json::from_str(line).with_context(|| format!("no JSON object: {line}")));
    let figures: Vec<Value> = figures.collect::<Result<_>>()?;
    let ours = |work: &Value| figures.iter().find(|own| own["work"] == *work && own["who"] == OURS);
    let mut text =
        "| work | who | instructions | ratio | state bytes | error |\n|---|---|---|---|---|---|\n".to_owned();
    for own in &figures {
        let number = |of: &Value| of["instructions"].as_f64().with_context(|| format!("no instructions: {of}"));
        let of_ours = ours(&own["work"]).with_context(|| format!("nothing of ours to compare with: {own}"))?;
        let ratio = number(own)? / number(of_ours)?;
        let word = |key: &str| own[key].as_str().with_context(|| format!("no {key}: {own}"));
        let [work, who, error] = [word("work")?, word("who")?, word("error")?];
        text += &format!("| {work} | {who} | {} | {ratio:.2} | {} | {error} |\n", own["instructions"], own["bytes"]);
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_is_to_ours_of_the_same_work() -> Result<()> {
        let lines = [
            r#"{"work":"a","who":"bearing-watch","instructions":10,"bytes":8,"error":"1e-3"}"#,
            r#"{"work":"b","who":"bearing-watch","instructions":1,"bytes":0,"error":"0"}"#,
            r#"{"work":"a","who":"C","instructions":25,"bytes":12,"error":"NaN"}"#,
        ];
        let lines = lines.map(String::from);
        assert!(rows(&lines)?.ends_with("| a | C | 25 | 2.50 | 12 | NaN |\n"));
        assert!(rows(&lines[2..]).is_err());
        assert!(rows(&["hello".to_owned()]).is_err());
        Ok(())
    }
}
