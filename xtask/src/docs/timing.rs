//! The tables of cycles: of whole detectors in the book, and of the interrupts of a drive beside the chips.

use anyhow::{Context, Result};

use super::block::Block;
use super::figures::{self, DETECTORS, find, head, row};
use crate::measure::Figure;

/// The document of the interrupts.
const BOARDS: &str = figures::DOCUMENT;

/// Calls: a title, and how the name of the figure ends.
const CALLS: [(&str, &str); 5] = [
    ("cycles of `exchange`, mean sample", "collect, mean sample"),
    ("cycles of `exchange`, longest sample", "collect, longest sample"),
    ("cycles of `exchange`, the sample that closes a segment", "collect, sample that closes"),
    ("cycles of `conclude`", "conclude"),
    ("cycles of `Monitor::advance`, longest step", "longest step"),
];

/// What runs in the interrupts of a drive: a title, and the name of the figure.
const ROWS: [(&str, &str); 6] = [
    ("`WATCH.sample` in the current loop: mean row", "current loop of a drive, mean row"),
    ("longest row, any data", "current loop of a drive, longest row"),
    ("`WATCH.collect` below it, once in ten rows: mean sample", "below the current loop, mean sample"),
    ("longest sample without the next two", "below the current loop, longest sample"),
    ("the sample that closes a segment", "below the current loop, sample that closes"),
    ("the sample that discards those before a fault", "below the current loop, sample that discards"),
];

/// Cycles between two interrupts at 10 kHz, of a processor with 168 MHz.
const PERIOD: u64 = 16_800;

/// The tables.
pub fn blocks(figures: &[Figure]) -> Result<[Block; 2]> {
    let mut calls =
        head(["without / with 5 wait states"].into_iter().chain(DETECTORS.map(|(title, _)| title))).to_vec();
    for (title, call) in CALLS {
        let cells = DETECTORS.iter().map(|(_, name)| {
            let [none, some] = cycles(figures, &format!("{name}, {call}"))?;
            Ok(format!("{none} / {some}"))
        });
        calls.push(row(title, cells.collect::<Result<Vec<_>>>()?));
    }
    let titles = ["call", "instructions", "cycles", "with 5 wait states", "of 100 µs at 168 MHz"];
    let mut interrupt = head(titles.into_iter()).to_vec();
    for (title, name) in ROWS {
        let ([none, some], instructions) = (cycles(figures, name)?, find(figures, name, None)?.instructions);
        let percent = (100 * some).div_ceil(PERIOD);
        let counts = [instructions.context("no instructions")?, none, some].map(|count| count.to_string());
        interrupt.push(row(title, counts.into_iter().chain([format!("{percent} %")])));
    }
    let name = |end: &str| format!("{}-{end}", figures::NAME);
    Ok([
        Block { file: figures::DOCUMENT, name: name("cycles"), lines: calls },
        Block { file: BOARDS, name: name("interrupt"), lines: interrupt },
    ])
}

fn cycles(figures: &[Figure], name: &str) -> Result<[u64; 2]> {
    match find(figures, name, None)?.cycles {
        [Some(none), Some(some)] => Ok([none, some]),
        _ => None.with_context(|| format!("no cycles of {name}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_show_counts_and_their_part_of_the_period() -> Result<()> {
        let figure = |name: String| Figure {
            name,
            instructions: Some(1000),
            cycles: [Some(1600), Some(1681)],
            ..Figure::default()
        };
        let calls = DETECTORS.iter().flat_map(|(_, name)| CALLS.map(|(_, call)| format!("{name}, {call}")));
        let rows = ROWS.map(|(_, name)| name.to_owned());
        let figures: Vec<Figure> = calls.chain(rows).map(figure).collect();
        let [calls, interrupt] = blocks(&figures)?;
        assert!(calls.lines.iter().skip(2).all(|line| line.ends_with("| 1600 / 1681 |")));
        assert!(interrupt.lines.contains(&"| longest row, any data | 1000 | 1600 | 1681 | 11 % |".to_owned()));
        assert!(blocks(figures.get(1..).unwrap_or_default()).is_err());
        Ok(())
    }
}
