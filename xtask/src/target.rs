//! The checks on the emulated chip.

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};

use crate::board::{Board, DRIVE, NO_FPU, NO_FPU_LARGE, NOT_EMULATED, OTHERS};
use crate::bounds::BOUNDS;
use crate::tally::Tally;
use crate::toolchain::{self, Way};
use crate::{child, docs, elf, firmware, log, measure, public, qemu, size_profile, workspace};

/// Examples that must print the same lines, bit for bit, on the host and on the target.
const TWINS: [&str; 5] = ["monitor", "kernels", "deferred", "telemetry", "random_plans"];

/// Of these, the ones that run on other boards.
const ELSEWHERE: [&str; 2] = ["kernels", "deferred"];

/// A way to build an example for a board.
type Build = fn(Way, Board, &str) -> Result<PathBuf>;

/// Every example builds for the drive's chip, also with all features.
pub fn builds(tally: &mut Tally, way: Way) {
    const ALL_FEATURES: &str = "all examples, all features";
    let names = match firmware::examples() {
        Ok(names) => names,
        Err(error) => return tally.check::<&str, _>("examples", Err(error)),
    };
    for name in names {
        tally.check(&name, brief(firmware::build(way, DRIVE, &name).map(|_| "")));
    }
    tally.check(ALL_FEATURES, brief(firmware::check_all_features(way, DRIVE).map(|()| "")));
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
        let title = format!("monitor for {}", board.machine);
        tally.check(&title, brief(firmware::build(way, board, "monitor").map(|_| "")));
    }
    for board in OTHERS {
        for name in ELSEWHERE {
            same_on(tally, way, board, name);
        }
    }
    // `deferred` counts in an atomic variable, which this processor cannot do.
    same_on(tally, way, NO_FPU_LARGE, "kernels");
}

fn same_on(tally: &mut Tally, way: Way, board: Board, example: &str) {
    let title = format!("{example} on {} ({})", board.machine, board.core);
    match toolchain::hindrance(way, board.target) {
        Some(hindrance) => tally.missing(&title, &hindrance),
        None => tally.check(&title, brief(compare(way, board, example))),
    }
}

/// What the core logs by `defmt` decodes to the verdicts that the host's monitor prints, and to its rejections.
pub fn logging(tally: &mut Tally, way: Way) {
    const VERDICTS: &str = "decoded verdicts are the host's";
    const REFUSALS: &str = "lost, saturated and stuck samples are logged";
    let logged = firmware::build(way, DRIVE, "logging").and_then(|elf| qemu::run(&elf, DRIVE.machine, qemu::Echo::On));
    match logged {
        Ok(logged) => {
            tally.check(VERDICTS, brief(same_verdicts(&logged)));
            tally.check(REFUSALS, log::refusals(&logged));
        }
        Err(error) => tally.check::<&str, _>(VERDICTS, brief(Err(error))),
    }
}

/// The log goes on with traces that the monitor doesn't see.
fn same_verdicts(logged: &[String]) -> Result<String> {
    let printed = on_host("monitor")?;
    let (logged, printed) = (log::verdicts(logged), log::verdicts(&printed));
    ensure!(!printed.is_empty(), "the host has no verdict");
    ensure!(logged.starts_with(&printed), "host {printed:?}, log {logged:?}");
    Ok(printed.join(", "))
}

/// Nothing in the core can panic: the example that calls all of it links without a panic handler, and the monitor with
/// all that an application adds holds no call of the panic machinery.
pub fn no_panic(tally: &mut Tally, way: Way) {
    const ALL: &str = "every public function is called in panic_free";
    const LINKS: &str = "panic_free links and runs";
    const CHECKED: &str = "panic_free links and runs, overflow checks on";
    const SMALL: &str = "panic_free links and runs, opt-level s";
    const MONITOR: &str = "monitor links without a panic";
    let forgotten = brief(public::forgotten()).and_then(|names| match names.len() {
        0 => Ok(""),
        _ => Err(format!("missing: {}", names.join(", "))),
    });
    tally.check(ALL, forgotten);
    // All builds have the same file: each runs before the next is built.
    let builds: [(&str, Build); 3] =
        [(LINKS, firmware::build), (CHECKED, firmware::build_checked), (SMALL, firmware::build_small)];
    for (title, build) in builds {
        let runs = build(way, DRIVE, "panic_free").and_then(|elf| qemu::run(&elf, DRIVE.machine, qemu::Echo::Off));
        tally.check(title, brief(runs.map(|_| "")));
    }
    tally.check(MONITOR, brief(panic_free(way)));
}

fn panic_free(way: Way) -> Result<&'static str> {
    let found = elf::symbols_with(&firmware::build(way, DRIVE, "monitor")?, "core9panicking")?;
    ensure!(found.is_empty(), "it calls {}", found.join(", "));
    Ok("")
}

/// Two runs count the same instructions and bytes, no more than promised, and as the book has them.
pub fn bounds(tally: &mut Tally, way: Way) {
    const REPEATABLE: &str = "two runs count alike";
    const DOCUMENTED: &str = "the book's figures within 5 %";
    const SMALL: &str = "instructions of a sample at opt-level s";
    const SMALL_FLASH: &str = "flash at opt-level s";
    let runs = measure::kernels(way).and_then(|one| Ok((one, measure::kernels(way)?)));
    let mut figures = match runs {
        Ok((one, two)) => {
            let alike = (one == two).then_some("").context("the counts differ");
            tally.check(REPEATABLE, alike);
            one
        }
        Err(error) => {
            tally.check::<&str, _>(REPEATABLE, brief(Err(error)));
            Vec::new()
        }
    };
    match measure::any_data(way, &figures) {
        Ok(found) => figures.extend(found),
        Err(error) => tally.check::<&str, _>("cost for any data", brief(Err(error))),
    }
    print!("{}", measure::table(&figures));
    let no_fpu = toolchain::hindrance(way, NO_FPU.target);
    for bound in BOUNDS {
        match &no_fpu {
            Some(hindrance) if bound.name.ends_with(NO_FPU.core) => tally.missing(&bound.title(), hindrance),
            _ => tally.check(&bound.title(), bound.check(&figures)),
        }
    }
    tally.check(SMALL, size_profile::instructions(way, &figures));
    tally.check(SMALL_FLASH, brief(size_profile::flash(way)));
    tally.check(DOCUMENTED, docs::check_figures(&figures));
}

fn compare(way: Way, board: Board, example: &str) -> Result<String> {
    let target = qemu::run(&firmware::build(way, board, example)?, board.machine, qemu::Echo::Off)?;
    let host = on_host(example)?;
    for (number, (host, target)) in host.iter().zip(&target).enumerate() {
        if host != target {
            bail!("line {}: host `{host}`, target `{target}`", number + 1);
        }
    }
    ensure!(host.len() == target.len(), "{} lines on the host, {} on the target", host.len(), target.len());
    ensure!(!host.is_empty(), "neither printed anything");
    Ok(format!("{} lines", host.len()))
}

/// The lines that an example prints on the host.
pub fn on_host(example: &str) -> Result<Vec<String>> {
    child::printed(&mut workspace::example(example)?).context("on the host")
}

/// The whole chain of causes in one text.
pub fn brief<T>(outcome: Result<T>) -> Result<T, String> {
    outcome.map_err(|error| format!("{error:#}"))
}
