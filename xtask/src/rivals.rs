//! `cargo xtask measure --peers`: kernels of the core beside those of others, counted on the emulated chip in one run.
//!
//! CMSIS-DSP's C sources come in the Python package that wraps them, pinned by `peers/chip/requirements.txt`.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::board::DRIVE;
use crate::toolchain::Way;
use crate::{child, firmware, peers, qemu, workspace};

/// Who the others are measured against.
const OURS: &str = "bearing-watch";

/// One line of the firmware.
#[derive(Debug)]
struct Figure {
    work: String,
    who: String,
    instructions: u64,
    bytes: u64,
    error: String,
}

/// Fetches, builds, runs. Returns the table.
pub fn table(way: Way) -> Result<String> {
    let elf = firmware::build_peers(way, &cmsis()?)?;
    let lines = qemu::run(&elf, DRIVE.machine, qemu::Echo::Off)?;
    let figures = lines.iter().map(|line| figure(line)).collect::<Result<Vec<_>>>()?;
    rows(&figures)
}

/// The folder of CMSIS-DSP's sources, fetched where it lacks.
fn cmsis() -> Result<PathBuf> {
    let list = workspace::root().join("xtask/peers/chip/requirements.txt");
    let pin = std::fs::read_to_string(&list).with_context(|| format!("no {}", list.display()))?;
    let version = pin.split_once("==").and_then(|(_, rest)| rest.split_whitespace().next());
    let name = format!("cmsisdsp-{}", version.with_context(|| format!("{} pins nothing", list.display()))?);
    let folder = peers::folder();
    let sources = folder.join(&name);
    if !sources.join("Source").is_dir() {
        let mut pip = Command::new(peers::python()?);
        pip.args(["-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", "cmsisdsp", "--requirement"]);
        child::succeed(pip.arg(&list).arg("--dest").arg(&folder))?;
        let archive = folder.join(format!("{name}.tar.gz"));
        child::succeed(Command::new("tar").arg("-xzf").arg(archive).arg("-C").arg(&folder))?;
    }
    Ok(sources)
}

fn figure(line: &str) -> Result<Figure> {
    let value: Value = serde_json::from_str(line).with_context(|| format!("no JSON object: {line}"))?;
    let text = |key: &str| value[key].as_str().map(str::to_owned).with_context(|| format!("no {key}: {line}"));
    let number = |key: &str| value[key].as_u64().with_context(|| format!("no {key}: {line}"));
    Ok(Figure {
        work: text("work")?,
        who: text("who")?,
        instructions: number("instructions")?,
        bytes: number("bytes")?,
        error: text("error")?,
    })
}

/// Every line with its ratio to ours of the same work.
fn rows(figures: &[Figure]) -> Result<String> {
    let mut text =
        "| work | who | instructions | ratio | state bytes | error |\n|---|---|---|---|---|---|\n".to_owned();
    for f in figures {
        let ours = figures.iter().find(|other| other.work == f.work && other.who == OURS);
        let ours = ours.with_context(|| format!("nothing of ours to compare with: {}", f.work))?;
        let ratio = f.instructions as f64 / ours.instructions as f64;
        let Figure { work, who, instructions, bytes, error } = f;
        text += &format!("| {work} | {who} | {instructions} | {ratio:.2} | {bytes} | {error} |\n");
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
        let figures = lines.iter().map(|line| figure(line)).collect::<Result<Vec<_>>>()?;
        assert!(rows(&figures)?.ends_with("| a | C | 25 | 2.50 | 12 | NaN |\n"));
        assert!(rows(&figures[2..]).is_err());
        Ok(())
    }

    #[test]
    fn an_incomplete_line_is_refused() {
        assert!(figure(r#"{"work":"a","who":"C"}"#).is_err());
        assert!(figure("hello").is_err());
    }
}
