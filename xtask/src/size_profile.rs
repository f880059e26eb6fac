//! The core built for size, `opt-level = "s"`: what a sample then takes beside what it takes at level 3.
//!
//! Only the package of the core changes its level; libraries keep theirs, as the compiler's own library does for users
//! of rustup, and need not be built again.

use anyhow::{Context, Result, ensure};

use crate::board::DRIVE;
use crate::measure::{self, Figure};
use crate::toolchain::Way;
use crate::{elf, firmware};

/// Instructions at `opt-level = "s"`, in percent of those at level 3.
const MOST_PERCENT: u64 = 130;

/// Largest flash with the smallest profile: of shaft, four orders and least squares, and of a whole drive monitor with
/// front end and alarm. The response of the residual's filter and the parts of a block take 0.9 kB of it, and make a
/// sample faster; what a segment would have shown and the checks of its signals take 2 and 5 kB.
const MOST_FLASH: [(&str, u64); 2] = [("footprint_shaft", 32_700), ("footprint_drive", 48_800)];

/// What runs at every sample. The sample that closes a segment is left out: it copies the sums, and at this level
/// compiler and library copy twice.
const EVERY_SAMPLE: [&str; 17] = [
    "sin_cos + Clarke + Park",
    "LS sample",
    "LS sample, stuck sensor and outliers told",
    "LS sample, stuck sensor and outliers told, worst of 64",
    "SRIV sample",
    "SRIV sample, stuck sensor and outliers told",
    "SRIV sample, stuck sensor and outliers told, worst of 64",
    "LS detector, collect, mean sample",
    "LS detector, collect, longest sample",
    "SRIV detector, collect, mean sample",
    "SRIV detector, collect, longest sample",
    "LS and shaft, 4 orders of 3 harmonics, collect, mean sample",
    "LS and shaft, 4 orders of 3 harmonics, collect, longest sample",
    "shaft alone, 1 order without load, collect, mean sample",
    "shaft alone, 1 order without load, collect, longest sample",
    "half-band decimation, 3 channels, mean sample",
    "FIR decimation, 3 channels, mean sample",
];

/// Programs with a detector; at this level they must not take more flash.
const PROGRAMS: [&str; 3] = ["footprint_squares", "footprint_refined", "footprint_shaft"];

/// The figure that grows most, if none grows more than allowed.
pub fn instructions(way: Way, fast: &[Figure]) -> Result<String, String> {
    let small = firmware::build_small(way, DRIVE, "measure").and_then(|elf| measure::printed(&elf, DRIVE));
    compare(fast, &small.map_err(|error| format!("{error:#}"))?)
}

fn compare(fast: &[Figure], small: &[Figure]) -> Result<String, String> {
    let (mut worst, mut over) = ((0, String::new()), Vec::new());
    for name in EVERY_SAMPLE {
        let mut sizes = fast.iter().filter(|f| f.name == name).peekable();
        if sizes.peek().is_none() {
            return Err(format!("{name}: not measured"));
        }
        for f in sizes {
            let other = small.iter().find(|s| s.name == name && s.n == f.n).and_then(|s| s.instructions);
            let (Some(few), Some(many)) = (f.instructions, other) else {
                return Err(format!("{name}: not measured"));
            };
            let percent = 100 * many / few.max(1);
            let line = format!("{name}: {many} instead of {few}, {percent} %");
            if percent > MOST_PERCENT {
                over.push(line.clone());
            }
            worst = worst.max((percent, line));
        }
    }
    if over.is_empty() { Ok(worst.1) } else { Err(over.join("; ")) }
}

/// Flash of the programs at this level and at level 3, if none grows, and what programs add to the empty one with the
/// smallest profile.
pub fn flash(way: Way) -> Result<String> {
    let mut lines = Vec::new();
    for name in PROGRAMS {
        // Both builds have the same file.
        let fast = elf::sizes(&firmware::build(way, DRIVE, name)?)?.flash;
        let small = elf::sizes(&firmware::build_small(way, DRIVE, name)?)?.flash;
        (small <= fast).then_some(()).with_context(|| format!("{name}: {small} bytes instead of {fast}"))?;
        lines.push(format!("{name} {small} instead of {fast}"));
    }
    let smallest = |name: &str| Ok::<_, anyhow::Error>(elf::sizes(&firmware::build_smallest(way, DRIVE, name)?)?.flash);
    let empty = smallest("footprint_none")?;
    for (name, most) in MOST_FLASH {
        let added = smallest(name)?.saturating_sub(empty);
        ensure!(added <= most, "{name} adds {added} bytes with lto, {most} are allowed");
        lines.push(format!("{name} with lto {added}"));
    }
    Ok(lines.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(instructions: u64) -> Vec<Figure> {
        let figure =
            |name: &str| Figure { name: name.to_owned(), instructions: Some(instructions), ..Figure::default() };
        EVERY_SAMPLE.map(figure).to_vec()
    }

    #[test]
    fn up_to_130_percent_is_allowed() {
        let fast = figures(100);
        assert!(compare(&fast, &figures(130)).is_ok_and(|line| line.ends_with("130 instead of 100, 130 %")));
        assert!(compare(&fast, &figures(131)).is_err());
        assert!(compare(&fast, &[]).is_err());
        assert!(compare(&[], &fast).is_err());
    }
}
