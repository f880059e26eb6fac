//! `cargo xtask measure`: the kernels' instructions and bytes, counted on the emulated chip, cycles estimated from a
//! trace, and the stack they take.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use super::cycles;
use crate::firmware::board::{Board, DRIVE, NO_FPU};
use crate::firmware::build::build;
use crate::firmware::way::Way;
use crate::firmware::{elf, qemu};
use crate::workspace;

/// How the names of figures of any data end.
pub const ANY_DATA: &str = ", any data";

/// The smallest program.
const SMALLEST: &str = "footprint_none";

/// What programs add to the flash of others: a name, its size, the example, and the one that it is compared with.
const FOOTPRINTS: [(&str, Option<u64>, &str, &str); 9] = [
    ("the whole detector, LS", Some(8), "footprint_squares", SMALLEST),
    ("the whole detector, SRIV", Some(8), "footprint_refined", SMALLEST),
    ("the whole detector, LS and shaft", Some(8), "footprint_shaft", SMALLEST),
    ("the whole detector, shaft alone", None, "footprint_chosen", SMALLEST),
    ("the evidence of runs, its reason and its growth", Some(5), "footprint_evidence", "footprint_decided"),
    ("an arctangent, micromath, for a resolver's start", None, "footprint_coarse", SMALLEST),
    ("an arctangent, libm", None, "footprint_atan2", SMALLEST),
    ("a verification of a signed model", None, "footprint_signature", SMALLEST),
    ("sealing and opening of a saved state", None, "footprint_seal", SMALLEST),
];

/// One measured kernel, or a size of the whole monitor.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Figure {
    pub name: String,
    /// The kernel's size, where it has one.
    pub n: Option<u64>,
    /// A call, averaged.
    pub instructions: Option<u64>,
    /// The same in cycles, for each of [`cycles::WAIT_STATES`].
    pub cycles: [Option<u64>; cycles::WAIT_STATES.len()],
    /// State of a kernel, stack of a call, or flash or RAM of a program.
    pub bytes: Option<u64>,
}

/// Builds and runs the examples that measure, and adds what the example `monitor` takes of the chip.
pub fn figures(way: Way) -> Result<Vec<Figure>> {
    let mut figures = kernels(way)?;
    figures.extend(any_data(way, &figures)?);
    let sizes = elf::sizes(&build(way, DRIVE, "monitor")?)?;
    let recording = workspace::root().join("examples/support/standard_rig/held_out.bin");
    let recording = fs::metadata(&recording).with_context(|| format!("no {}", recording.display()))?.len();
    let rows = [
        ("monitor flash", sizes.flash),
        ("monitor flash, recording apart", sizes.flash.saturating_sub(recording)),
        ("monitor RAM, statics", sizes.ram),
    ];
    for (name, bytes) in rows {
        figures.push(Figure { name: name.to_owned(), bytes: Some(bytes), ..Figure::default() });
    }
    Ok(figures)
}

/// What the examples `measure`, `measure_interrupt`, `memory`, `stack`, `measure_signature` and `measure_telemetry`
/// print, and what [`FOOTPRINTS`] add to other programs.
pub fn kernels(way: Way) -> Result<Vec<Figure>> {
    let mut figures = timed(&build(way, DRIVE, "measure")?)?;
    figures.extend(timed(&build(way, DRIVE, "measure_interrupt")?)?);
    for example in ["memory", "stack", "measure_signature", "measure_telemetry"] {
        figures.extend(printed(&build(way, DRIVE, example)?, DRIVE)?);
    }
    if way.hindrance(NO_FPU.target).is_none() {
        for figure in printed(&build(way, NO_FPU, "measure_no_fpu")?, NO_FPU)? {
            figures.push(Figure { name: format!("{}, on a {}", figure.name, NO_FPU.core), ..figure });
        }
    }
    let flash = |example: &str| anyhow::Ok(elf::sizes(&build(way, DRIVE, example)?)?.flash);
    for (name, n, example, without) in FOOTPRINTS {
        let (name, bytes) = (format!("flash of {name}"), Some(flash(example)?.saturating_sub(flash(without)?)));
        figures.push(Figure { name, n, bytes, ..Figure::default() });
    }
    Ok(figures)
}

/// The most instructions of each call over all streams: those of a search over damaged ones, and those of `kernels`.
/// The search is another program, in which the same function may have a few instructions less.
pub fn any_data(way: Way, kernels: &[Figure]) -> Result<Vec<Figure>> {
    let mut found = printed(&build(way, DRIVE, "measure_any_data")?, DRIVE)?;
    for figure in &mut found {
        let call = figure.name.strip_suffix(ANY_DATA);
        let usual = kernels.iter().find(|usual| Some(usual.name.as_str()) == call && usual.n == figure.n);
        figure.instructions = figure.instructions.max(usual.and_then(|usual| usual.instructions));
    }
    Ok(found)
}

/// What a program prints on a board.
pub fn printed(elf: &Path, board: Board) -> Result<Vec<Figure>> {
    let lines = qemu::run(elf, board)?;
    ensure!(!lines.is_empty(), "{} printed nothing", elf.display());
    lines.iter().map(|line| figure(line)).collect()
}

/// What the compiler may move over the marks that a trace has of start and end of a call.
const MOVED: u64 = 4;

/// The same with cycles on the drive's chip.
fn timed(elf: &Path) -> Result<Vec<Figure>> {
    let (lines, with_counts) = cycles::lines(elf, DRIVE)?;
    let read = |lines: &[String]| lines.iter().map(|line| figure(line)).collect::<Result<Vec<_>>>();
    let (mut figures, [traced, none, some]) = (read(&lines)?, with_counts.map(|lines| read(&lines)));
    let (traced, none, some) = (traced?, none?, some?);
    for (place, one) in figures.iter_mut().enumerate() {
        let of = |all: &[Figure]| all.get(place).filter(|own| own.name == one.name && own.n == one.n).cloned();
        let traced = of(&traced).and_then(|own| own.instructions);
        let difference = one.instructions.unwrap_or(0).abs_diff(traced.unwrap_or(0));
        ensure!(difference <= MOVED, "{} n={:?}: the trace has {difference} more or fewer", one.name, one.n);
        one.cycles = [of(&none), of(&some)].map(|own| own.and_then(|own| own.instructions));
    }
    Ok(figures)
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
        ..Figure::default()
    })
}

/// A JSON list, one object a line.
pub fn json(figures: &[Figure]) -> String {
    let object = |f: &Figure| {
        let Figure { name, n, instructions, cycles, bytes } = f;
        let own = json!({ "name": name, "n": n, "instructions": instructions, "cycles": cycles, "bytes": bytes });
        format!("  {own}")
    };
    format!("[\n{}\n]", figures.iter().map(object).collect::<Vec<_>>().join(",\n"))
}

/// A table for people, with cycles without wait states of the flash and with those of the drive's chip.
pub fn table(figures: &[Figure]) -> String {
    let cell = |value: Option<u64>| value.map_or_else(|| "–".to_owned(), |v| v.to_string());
    let width = figures.iter().map(|f| f.name.chars().count()).max();
    let width = width.unwrap_or(0).max("kernel".len());
    let waiting = cycles::WAIT_STATES.map(|wait_states| format!("cycles, {wait_states} ws"));
    let head = ["instructions", &waiting[0], &waiting[1], "bytes"].map(|title| format!("  {title:>12}")).concat();
    let mut text = format!("{:width$}  {:>4}{head}\n", "kernel", "n");
    for f in figures {
        let counts = [f.instructions, f.cycles[0], f.cycles[1], f.bytes].map(|v| format!("  {:>12}", cell(v))).concat();
        let _string_grows = writeln!(text, "{:width$}  {:>4}{counts}", f.name, cell(f.n));
    }
    text
}
