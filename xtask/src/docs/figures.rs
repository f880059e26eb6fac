//! The tables of the book's chapter on cost, from the figures that `cargo xtask measure` counts.

use anyhow::{Context, Result};

use super::block::Block;
use super::compare::Tolerance;
use crate::measure::{ANY_DATA, Figure};

/// The same source gives the same counts with one compiler; other compilers differ by a few percent.
pub const TOLERANCE: Tolerance = Tolerance::Within(0.05);

/// The chapter with the tables.
pub const DOCUMENT: &str = "book/src/target.md";

/// The name of the block.
pub const NAME: &str = "target";

/// Names and sizes of the figures of one cell; no size means the only one.
type Picks = (&'static [&'static str], &'static [Option<u64>]);

/// Kernels: a title, the figures of its instructions, and those of its bytes.
const KERNELS: [(&str, Picks, Picks); 17] = [
    kernel("sine and cosine of a binary angle", &["sin_cos"], ONE, NO_BYTES),
    kernel("the same with Clarke and Park transforms", &["sin_cos + Clarke + Park"], ONE, NO_BYTES),
    kernel("least-squares update, 5 / 8 / 12 / 15 parameters", &["LS update, lambda 1"], ALL, &["LS update"]),
    kernel("the same with forgetting", &["LS update"], ALL, &["LS update"]),
    kernel("instrumental-variables update with forgetting, 8 / 15 parameters", &["IV update"], TWO, &["IV update"]),
    kernel("a sample of least squares, 8 parameters", &["LS sample"], EIGHT, &["LS sample"]),
    kernel("the same with tests for a stuck sensor and outliers", &[LS_GUARDED], EIGHT, &[LS_GUARDED]),
    kernel("a sample of instrumental variables, 8 parameters", &["SRIV sample"], EIGHT, &["SRIV sample"]),
    kernel("the same with tests for a stuck sensor and outliers", &[IV_GUARDED], EIGHT, &[IV_GUARDED]),
    kernel(
        "solve and covariance, 8 parameters: least squares / instrumental variables",
        &["LS solve + covariance", "SRIV solve + covariance"],
        EIGHT,
        NO_BYTES,
    ),
    kernel("projection of 9 features to 3", &["projection 9 to 3"], ONE, NO_BYTES),
    kernel("quadratic discriminant with posterior probabilities and costs", &[DISCRIMINANT], ONE, NO_BYTES),
    kernel("half-band decimation of 3 channels by 8: mean / worst sample", HALF_BAND, EIGHT, &[HALF_BAND_MEAN]),
    kernel("FIR decimation of 3 channels by 8: mean / worst sample", FIR, EIGHT, &[FIR_MEAN]),
    kernel(
        "front end by 8, 2 currents and a converter: mean / worst sample / worst sample of any data",
        CONVERTER,
        EIGHT,
        &[CONVERTER_MEAN],
    ),
    kernel(
        "front end by 8, 3 currents, a resolver and 2 further channels: mean / worst sample / worst sample of any data",
        RESOLVER,
        EIGHT,
        &[RESOLVER_MEAN],
    ),
    kernel("the same and a detector, 8 parameters, shaft with 1 / 2 / 3 / 4 orders", NO_COUNTS, ORDERS, &[RAM]),
];

const ONE: &[Option<u64>] = &[None];
const EIGHT: &[Option<u64>] = &[Some(8)];
const TWO: &[Option<u64>] = &[Some(8), Some(15)];
const ALL: &[Option<u64>] = &[Some(5), Some(8), Some(12), Some(15)];
const ORDERS: &[Option<u64>] = &[Some(1), Some(2), Some(3), Some(4)];
const NO_COUNTS: &[&str] = &[];
const NO_BYTES: &[&str] = &[];
const LS_GUARDED: &str = "LS sample, stuck sensor and outliers told";
const IV_GUARDED: &str = "SRIV sample, stuck sensor and outliers told";
const DISCRIMINANT: &str = "quadratic discriminant with posteriors and costs";
const HALF_BAND_MEAN: &str = "half-band decimation, 3 channels, mean sample";
const HALF_BAND: &[&str] = &[HALF_BAND_MEAN, "half-band decimation, 3 channels, worst sample"];
const FIR_MEAN: &str = "FIR decimation, 3 channels, mean sample";
const FIR: &[&str] = &[FIR_MEAN, "FIR decimation, 3 channels, worst sample"];

const CONVERTER_MEAN: &str = "front end, converter, 2 currents, mean sample";
const CONVERTER: &[&str] = &[
    CONVERTER_MEAN,
    "front end, converter, 2 currents, worst sample",
    "front end, converter, 2 currents, worst sample, any data",
];
const RESOLVER_MEAN: &str = "front end, resolver, 3 currents, 2 further, mean sample";
const RESOLVER: &[&str] = &[
    RESOLVER_MEAN,
    "front end, resolver, 3 currents, 2 further, worst sample",
    "front end, resolver, 3 currents, 2 further, worst sample, any data",
];

const RAM: &str = "front end and detector, RAM";

const fn kernel(
    title: &'static str,
    counts: &'static [&'static str],
    sizes: &'static [Option<u64>],
    bytes: &'static [&'static str],
) -> (&'static str, Picks, Picks) {
    (title, (counts, sizes), (bytes, sizes))
}

/// The value of a figure that a cell shows.
type Value = fn(&Figure) -> Option<u64>;

/// Whole detectors: a title, how the name of the figure ends, and its value. One column each, see [`DETECTORS`].
const CALLS: [(&str, &str, Value); 16] = [
    ("`exchange`, mean sample", "collect, mean sample", |f| f.instructions),
    ("`exchange`, longest sample", "collect, longest sample", |f| f.instructions),
    ("the same for any data", "collect, longest sample, any data", |f| f.instructions),
    ("`exchange`, the sample that closes a segment", "collect, sample that closes", |f| f.instructions),
    ("the same for any data", "collect, sample that closes, any data", |f| f.instructions),
    ("`conclude`", "conclude", |f| f.instructions),
    ("the same for any data", "conclude, any data", |f| f.instructions),
    ("`Monitor::advance`, longest step", "longest step", |f| f.instructions),
    ("the same for any data", "longest step, any data", |f| f.instructions),
    ("`adopt`, any data", "adopt, any data", |f| f.instructions),
    ("`discard`, any data", "discard, any data", |f| f.instructions),
    // The example `measure` prints this number in the place of the size.
    ("`Monitor::advance`, number of steps", "number of steps", |f| f.n),
    ("reading and checking a model", "reading and checking its model", |f| f.instructions),
    ("bytes of a `Detector`, its segment apart", "collect, mean sample", |f| f.bytes),
    ("bytes of a `Segment`, one open and one spare", "collect, sample that closes", |f| f.bytes),
    ("bytes of a `Monitor`", "longest step", |f| f.bytes),
];

/// The columns: a heading, and how the names of the figures start.
pub const DETECTORS: [(&str, &str); 4] = [
    ("least squares, 8 parameters", "LS detector"),
    ("instrumental variables, 8 parameters", "SRIV detector"),
    ("least squares, 8 parameters, and shaft, 4 orders of 3 harmonics", "LS and shaft, 4 orders of 3 harmonics"),
    ("shaft alone, 1 order", "shaft alone, 1 order without load"),
];

/// Stack of a call and flash, in bytes, by figure.
const MEMORY: [(&str, &str); 6] = [
    ("stack of `step`, a sample inside a segment", "stack, {stack} sample"),
    ("stack of `step`, the end of a segment", "stack, {stack} segment end"),
    ("stack of `exchange`", "stack, {stack} collect"),
    ("stack of `conclude`", "stack, {stack} conclude"),
    ("stack of `Monitor::advance`", "stack, {stack} step of the solve"),
    ("flash that the whole detector adds to an empty program", "flash of the whole detector, {flash}"),
];

/// The columns of [`MEMORY`]: a heading, and what stands for `{stack}` and `{flash}`.
const PROGRAMS: [(&str, &str, &str); 3] = [
    ("least squares", "detector", "LS"),
    ("instrumental variables", "SRIV detector", "SRIV"),
    ("least squares and shaft", "detector with shaft of 4 orders", "LS and shaft"),
];

/// The tables.
pub fn block(figures: &[Figure]) -> Result<Block> {
    let titles = ["kernel", "instructions", "cycles", "cycles, 5 wait states", "bytes of state"];
    let mut lines = head(titles.into_iter()).to_vec();
    for (title, counts, bytes) in KERNELS {
        let values: [Value; 3] = [|f| f.instructions, |f| f.cycles[0], |f| f.cycles[1]];
        let counts = values.into_iter().map(|value| cell(figures, counts, value));
        let cells = counts.chain([cell(figures, bytes, |f| f.bytes)]).collect::<Result<Vec<_>>>()?;
        lines.push(row(title, cells));
    }
    lines.push(String::new());
    lines.extend(head(["instructions of a call"].into_iter().chain(DETECTORS.map(|(title, _)| title))));
    for (title, call, value) in CALLS {
        let cells = DETECTORS.iter().map(|(_, name)| {
            let name = format!("{name}, {call}");
            shown(value(find(figures, &name, None)?), &name)
        });
        lines.push(row(title, cells.collect::<Result<Vec<_>>>()?));
    }
    lines.push(String::new());
    lines.extend(head(["bytes"].into_iter().chain(PROGRAMS.map(|(title, _, _)| title))));
    for (title, name) in MEMORY {
        let cells = PROGRAMS.iter().map(|(_, stack, flash)| {
            let name = name.replace("{stack}", stack).replace("{flash}", flash);
            let figure = find(figures, &name, None)?;
            shown(figure.bytes, &name)
        });
        lines.push(row(title, cells.collect::<Result<Vec<_>>>()?));
    }
    Ok(Block { file: DOCUMENT, name: NAME.to_owned(), lines })
}

pub fn find<'f>(figures: &'f [Figure], name: &str, n: Option<u64>) -> Result<&'f Figure> {
    let found = figures.iter().find(|figure| figure.name == name && (n.is_none() || figure.n == n));
    found.with_context(|| format!("not measured: {name}{}", n.map_or_else(String::new, |n| format!(", n = {n}"))))
}

fn shown(value: Option<u64>, name: &str) -> Result<String> {
    value.map(|value| value.to_string()).with_context(|| format!("no value of {name}"))
}

/// The numbers of one cell, separated by slashes. Cycles of any data are not estimated.
fn cell(figures: &[Figure], (names, sizes): Picks, value: Value) -> Result<String> {
    let mut numbers = Vec::new();
    for name in names {
        for n in sizes {
            let figure = find(figures, name, *n)?;
            let is_missing = value(figure).is_none() && figure.name.ends_with(ANY_DATA);
            numbers.push(if is_missing { "–".to_owned() } else { shown(value(figure), name)? });
        }
    }
    Ok(numbers.join(" / "))
}

pub fn head<'t>(titles: impl Iterator<Item = &'t str>) -> [String; 2] {
    let titles: Vec<&str> = titles.collect();
    [format!("| {} |", titles.join(" | ")), format!("|{}", "---|".repeat(titles.len()))]
}

pub fn row(title: &str, cells: impl IntoIterator<Item = String>) -> String {
    cells.into_iter().fold(format!("| {title} |"), |line, cell| {
        let space = if cell.is_empty() { "" } else { " " };
        line + space + &cell + " |"
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_lists_every_name_and_size() -> Result<()> {
        let one = |n, instructions| Figure {
            name: "a".to_owned(),
            n: Some(n),
            instructions: Some(instructions),
            ..Figure::default()
        };
        let figures = [one(5, 10), one(8, 20)];
        let count: Value = |figure| figure.instructions;
        assert_eq!(cell(&figures, (&["a"], &[Some(8), Some(5)]), count)?, "20 / 10");
        assert_eq!(cell(&figures, (&["a"], &[None]), count)?, "10");
        assert!(cell(&figures, (&["a"], &[None]), |figure| figure.bytes).is_err());
        assert!(cell(&figures, (&["b"], &[None]), count).is_err() && block(&figures).is_err());
        Ok(())
    }

    #[test]
    fn tables_are_markdown() {
        assert_eq!(head(["a", "b"].into_iter()), ["| a | b |", "|---|---|"]);
        assert_eq!(row("t", ["1".to_owned(), String::new()]), "| t | 1 | |");
    }
}
