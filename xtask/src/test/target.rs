//! The checks on the emulated chip.

use anyhow::{Context, Result, ensure};

use crate::cargo::lines_of_example;
use crate::cost::{bounds, measure};
use crate::docs;
use crate::firmware::board::{Board, DRIVE, NO_FPU_LARGE, NOT_EMULATED, OTHERS};
use crate::firmware::build::{self, build, build_with};
use crate::firmware::way::Way;
use crate::firmware::{elf, qemu};
use crate::report::Tally;

/// Examples that must print the same lines, bit for bit, on the host and on the target.
const TWINS: [&str; 6] = ["monitor", "kernels", "deferred", "telemetry", "two_motors", "random_plans"];

/// Every example builds for the drive's chip, also with all features.
pub fn builds(tally: &mut Tally, way: Way) {
    for (name, _) in build::examples().unwrap_or_default() {
        tally.check(&name, build(way, DRIVE, &name).map(|_| ""));
    }
    tally.check("all examples, all features", build::check_all_features(way, DRIVE));
}

/// The same source gives the same bits on the drive's chip.
pub fn same_lines(tally: &mut Tally, way: Way) {
    for name in TWINS {
        same_on(tally, way, DRIVE, name);
    }
}

/// Other chips: firmware is built for those that the emulator does not have, and gives the same bits on the others.
pub fn other_boards(tally: &mut Tally, way: Way) {
    for board in NOT_EMULATED {
        tally.check(&format!("monitor for {}", board.machine), build(way, board, "monitor").map(|_| ""));
    }
    for board in OTHERS {
        for name in ["kernels", "deferred"] {
            same_on(tally, way, board, name);
        }
    }
    // `deferred` counts in an atomic variable, which this processor cannot do.
    same_on(tally, way, NO_FPU_LARGE, "kernels");
}

fn same_on(tally: &mut Tally, way: Way, board: Board, example: &str) {
    let title = format!("{example} on {} ({})", board.machine, board.core);
    let compare = || equal(&lines_of_example(example)?, &qemu::run(&build(way, board, example)?, board)?);
    match way.hindrance(board.target) {
        Some(hindrance) => tally.missing(&title, &hindrance),
        None => tally.check(&title, compare()),
    }
}

/// Compares lines; both sides must have some. Returns their number.
pub fn equal(host: &[String], target: &[String]) -> Result<String> {
    for (number, (host, target)) in host.iter().zip(target).enumerate() {
        ensure!(host == target, "line {}: host `{host}`, target `{target}`", number + 1);
    }
    ensure!(host.len() == target.len(), "{} lines on the host, {} on the target", host.len(), target.len());
    ensure!(!host.is_empty(), "neither printed anything");
    Ok(format!("{} lines", host.len()))
}

/// The classes that lines name after the word `verdict: `.
pub fn verdicts(lines: &[String]) -> Vec<String> {
    lines.iter().filter_map(|line| line.split_once("verdict: ")).map(|(_, class)| class.trim().to_owned()).collect()
}

/// What the core logs by `defmt` decodes to the verdicts that the host's monitor prints, and to warnings of lost and
/// saturated samples, and of the segment that a stuck sensor denied its verdict.
pub fn logging(tally: &mut Tally, way: Way) {
    let logged = || {
        let logged = qemu::run(&build(way, DRIVE, "logging")?, DRIVE)?;
        let (verdicts, printed) = (verdicts(&logged), verdicts(&lines_of_example("monitor")?));
        // The log goes on with traces that the monitor doesn't see.
        ensure!(!printed.is_empty() && verdicts.starts_with(&printed), "host {printed:?}, log {verdicts:?}");
        for words in ["samples refused: 5 rejected, 5 saturated", "no verdict: Stuck { channel: 0 }"] {
            let found = logged.iter().any(|line| line.contains("WARN") && line.contains(words));
            ensure!(found, "no warning `{words}`");
        }
        Ok(printed.join(", "))
    };
    tally.check("decoded verdicts are the host's, and warnings are there", logged());
}

/// Nothing in the core can panic: the example that calls all of it links without a panic handler, and the monitor with
/// all that an application adds holds no call of the panic machinery.
pub fn no_panic(tally: &mut Tally, way: Way) {
    // All builds have the same file: each runs before the next is built.
    for (title, settings) in
        [("", &[] as &[&str]), (", overflow checks on", build::CHECKED), (", opt-level s", build::SMALL)]
    {
        let built = build_with(way, DRIVE, "panic_free", settings, None);
        let ran = built.and_then(|elf| qemu::run(&elf, DRIVE)).map(|_| "");
        tally.check(&format!("panic_free links and runs{title}"), ran);
    }
    let monitor = build(way, DRIVE, "monitor").and_then(|elf| elf::ensure_no_panic(&elf));
    tally.check("monitor links without a panic", monitor);
}

/// Two runs count the same instructions and bytes, no more than promised, and as the book has them.
pub fn bounds(tally: &mut Tally, way: Way) {
    let counted = || {
        let (mut figures, again) = (measure::kernels(way)?, measure::kernels(way)?);
        ensure!(figures == again, "two runs count differently");
        figures.extend(measure::any_data(way, &figures)?);
        anyhow::Ok(figures)
    };
    let figures = counted();
    tally.check("two runs count alike", figures.as_ref().map(|_| "").map_err(|error| anyhow::anyhow!("{error:#}")));
    let figures = figures.unwrap_or_default();
    print!("{}", measure::table(&figures));
    if let Err(error) = bounds::check(tally, way, &figures) {
        tally.check("bounds", Err::<&str, _>(error));
    }
    tally.check("instructions of a sample at opt-level s", bounds::small(way, &figures));
    tally.check("flash at opt-level s", bounds::flash(way));
    let documented = docs::check_figures(&figures).context("the book's figures");
    tally.check("the book's figures within 5 %", documented);
}
