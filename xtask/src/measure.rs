//! `cargo xtask measure`: the kernels' instructions and bytes, counted on the emulated chip, and the stack they take.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use crate::board::{Board, DRIVE, NO_FPU};
use crate::toolchain::{self, Way};
use crate::{elf, firmware, qemu, workspace};

/// How the names of figures of any data end.
const ANY_DATA: &str = ", any data";

/// What programs add to the flash of the smallest one: a name, its size, and the example.
const FOOTPRINTS: [(&str, Option<u64>, &str); 7] = [
    ("the whole detector, LS", Some(8), "footprint_squares"),
    ("the whole detector, SRIV", Some(8), "footprint_refined"),
    ("the whole detector, LS and shaft", Some(8), "footprint_shaft"),
    ("an arctangent, micromath, for a resolver's start", None, "footprint_coarse"),
    ("an arctangent, libm", None, "footprint_atan2"),
    ("a verification of a signed model", None, "footprint_signature"),
    ("sealing and opening of a saved state", None, "footprint_seal"),
];

/// One measured kernel, or a size of the whole monitor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    pub name: String,
    /// The kernel's size, where it has one.
    pub n: Option<u64>,
    /// A call, averaged.
    pub instructions: Option<u64>,
    /// State of a kernel, stack of a call, or flash or RAM of a program.
    pub bytes: Option<u64>,
}

/// Builds and runs the examples that measure, and adds what the example `monitor` takes of the chip.
pub fn figures(way: Way) -> Result<Vec<Figure>> {
    let mut figures = kernels(way)?;
    figures.extend(any_data(way, &figures)?);
    let sizes = elf::sizes(&firmware::build(way, DRIVE, "monitor")?)?;
    let recording = workspace::root().join("examples/support/standard_rig/held_out.bin");
    let recording = fs::metadata(&recording).with_context(|| format!("no {}", recording.display()))?.len();
    let rows = [
        ("monitor flash", sizes.flash),
        ("monitor flash, recording apart", sizes.flash.saturating_sub(recording)),
        ("monitor RAM, statics", sizes.ram),
    ];
    for (name, bytes) in rows {
        figures.push(Figure { name: name.to_owned(), n: None, instructions: None, bytes: Some(bytes) });
    }
    Ok(figures)
}

/// What the examples `measure`, `memory`, `stack` and `measure_signature` print, and what [`FOOTPRINTS`] add to the
/// smallest program.
pub fn kernels(way: Way) -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
    for example in ["measure", "memory", "stack", "measure_signature"] {
        figures.extend(printed(&firmware::build(way, DRIVE, example)?, DRIVE)?);
    }
    if toolchain::hindrance(way, NO_FPU.target).is_none() {
        for figure in printed(&firmware::build(way, NO_FPU, "measure_no_fpu")?, NO_FPU)? {
            figures.push(Figure { name: format!("{}, on a {}", figure.name, NO_FPU.core), ..figure });
        }
    }
    figures.extend(footprints(way, &FOOTPRINTS)?);
    Ok(figures)
}

/// What signatures take.
pub fn signatures(way: Way) -> Result<Vec<Figure>> {
    let mut figures = printed(&firmware::build(way, DRIVE, "measure_signature")?, DRIVE)?;
    figures.extend(footprints(way, FOOTPRINTS.last_chunk::<2>().context("two examples of signatures")?)?);
    Ok(figures)
}

fn footprints(way: Way, programs: &[(&str, Option<u64>, &str)]) -> Result<Vec<Figure>> {
    let flash = |example: &str| Ok::<_, anyhow::Error>(elf::sizes(&firmware::build(way, DRIVE, example)?)?.flash);
    let without = flash("footprint_none")?;
    let figure = |(name, n, example): &(&str, Option<u64>, &str)| {
        let (name, bytes) = (format!("flash of {name}"), Some(flash(example)?.saturating_sub(without)));
        Ok(Figure { name, n: *n, instructions: None, bytes })
    };
    programs.iter().map(figure).collect()
}

/// The most instructions of each call over all streams: those of a search over damaged ones, and those of `kernels`.
/// The search is another program, in which the same function may have a few instructions less.
pub fn any_data(way: Way, kernels: &[Figure]) -> Result<Vec<Figure>> {
    let mut found = printed(&firmware::build(way, DRIVE, "measure_any_data")?, DRIVE)?;
    found.iter_mut().for_each(|figure| raise(figure, kernels));
    Ok(found)
}

/// Raises a figure of any data to the one of the same call in `kernels`.
fn raise(figure: &mut Figure, kernels: &[Figure]) {
    let call = figure.name.strip_suffix(ANY_DATA);
    let usual = kernels.iter().find(|usual| Some(usual.name.as_str()) == call && usual.n == figure.n);
    figure.instructions = figure.instructions.max(usual.and_then(|usual| usual.instructions));
}

/// What a program prints on a board.
pub fn printed(elf: &Path, board: Board) -> Result<Vec<Figure>> {
    let lines = qemu::run(elf, board.machine, qemu::Echo::Off)?;
    ensure!(!lines.is_empty(), "{} printed nothing", elf.display());
    lines.iter().map(|line| figure(line)).collect()
}

fn figure(line: &str) -> Result<Figure> {
    let value: Value =
        serde_json::from_str(line).with_context(|| format!("the firmware printed no JSON object: {line}"))?;
    let name = value["name"].as_str().with_context(|| format!("a figure without a name: {line}"))?;
    Ok(Figure {
        name: name.to_owned(),
        n: value["n"].as_u64(),
        instructions: value["instructions"].as_u64(),
        bytes: value["bytes"].as_u64(),
    })
}

/// A JSON list, one object a line.
pub fn json(figures: &[Figure]) -> String {
    let objects: Vec<String> = figures
        .iter()
        .map(|f| {
            let object = json!({
                "name": f.name, "n": f.n, "instructions": f.instructions, "bytes": f.bytes
            });
            format!("  {object}")
        })
        .collect();
    format!("[\n{}\n]", objects.join(",\n"))
}

/// The rows of a table of a document.
pub fn rows(figures: &[Figure]) -> String {
    let cell = |value: Option<u64>| value.map_or_else(String::new, |v| v.to_string());
    let row = |f: &Figure| format!("| {} | {} | {} |\n", f.name, cell(f.instructions), cell(f.bytes));
    let head = "| What | Instructions | Bytes |\n|---|---:|---:|\n";
    std::iter::once(head.to_owned()).chain(figures.iter().map(row)).collect()
}

/// The same for people.
pub fn table(figures: &[Figure]) -> String {
    let cell = |value: Option<u64>| value.map_or_else(|| "–".to_owned(), |v| v.to_string());
    let width = figures.iter().map(|f| f.name.chars().count()).max();
    let width = width.unwrap_or(0).max("kernel".len());
    let mut text = format!("{:width$}  {:>4}  {:>12}  {:>8}\n", "kernel", "n", "instructions", "bytes");
    for f in figures {
        let (n, instructions, bytes) = (cell(f.n), cell(f.instructions), cell(f.bytes));
        let _string_grows = writeln!(text, "{:width$}  {n:>4}  {instructions:>12}  {bytes:>8}", f.name);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_the_firmware_becomes_a_figure_and_json_again() -> Result<()> {
        let line = r#"{"name":"dot product","n":8,"instructions":29,"bytes":null}"#;
        let read = figure(line)?;
        assert_eq!((read.n, read.instructions, read.bytes), (Some(8), Some(29), None));
        let list: Value = serde_json::from_str(&json(&[read]))?;
        assert_eq!(list, json!([serde_json::from_str::<Value>(line)?]));
        Ok(())
    }

    #[test]
    fn any_data_contain_the_usual_ones() {
        let figure = |name: &str, n, instructions| Figure {
            name: name.to_owned(),
            n: Some(n),
            instructions: Some(instructions),
            bytes: None,
        };
        let kernels = [figure("collect", 4, 900), figure("collect", 8, 100)];
        for (counted, expected) in [(90, 100), (110, 110)] {
            let mut found = figure("collect, any data", 8, counted);
            raise(&mut found, &kernels);
            assert_eq!(found.instructions, Some(expected));
        }
    }

    #[test]
    fn other_lines_are_refused() {
        assert!(figure("hello").is_err());
        assert!(figure(r#"{"n":8}"#).is_err());
    }
}
