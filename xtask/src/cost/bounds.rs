//! The bounds of `target-tests/bounds.toml`: instruction counts, cycles, stack depths and sizes that must be kept.

use std::fs;

use anyhow::{Context, Result, ensure};
use toml::{Table, Value};

use super::measure::{self, Figure};
use crate::firmware::board::{DRIVE, NO_FPU};
use crate::firmware::build::{self, build, build_with};
use crate::firmware::elf;
use crate::firmware::way::Way;
use crate::report::Tally;
use crate::workspace;

fn table() -> Result<Table> {
    let file = workspace::root().join("target-tests/bounds.toml");
    Ok(fs::read_to_string(&file).with_context(|| format!("no {}", file.display()))?.parse()?)
}

/// A whole number of the file.
pub fn number(key: &str) -> Result<u64> {
    let value = table()?.get(key).and_then(Value::as_integer).with_context(|| format!("no bound {key}"))?;
    Ok(u64::try_from(value)?)
}

fn names(table: &Table, key: &str) -> Result<Vec<String>> {
    let list = table.get(key).and_then(Value::as_array).with_context(|| format!("no list {key}"))?;
    Ok(list.iter().filter_map(Value::as_str).map(ToOwned::to_owned).collect())
}

/// Every figure is within its bounds; those of a chip that firmware cannot be built for are missing.
pub fn check(tally: &mut Tally, way: Way, figures: &[Figure]) -> Result<()> {
    let (table, no_fpu) = (table()?, way.hindrance(NO_FPU.target));
    for bound in table.get("bounds").and_then(Value::as_array).context("no bounds")? {
        let name = bound.get("name").and_then(Value::as_str).context("a bound without a name")?;
        let number = |key: &str| bound.get(key).and_then(Value::as_integer).and_then(|own| u64::try_from(own).ok());
        let unit = bound.get("unit").and_then(Value::as_str).unwrap_or_default();
        let (n, most) = (number("n"), number("most").with_context(|| format!("{name} has no bound"))?);
        let title = format!("{name}{} ≤ {most} {unit}", n.map_or_else(String::new, |n| format!(" n={n}")));
        match &no_fpu {
            Some(hindrance) if name.ends_with(NO_FPU.core) => tally.missing(&title, hindrance),
            _ => tally.check(&title, within(figures, name, n, most, unit)),
        }
    }
    Ok(())
}

/// What was measured, or why it is not between half of the bound and the bound.
fn within(figures: &[Figure], name: &str, n: Option<u64>, most: u64, unit: &str) -> Result<u64> {
    let figure = figures.iter().find(|own| own.name == name && (n.is_none() || own.n == n)).context("not measured")?;
    let counted = match unit {
        "cycles" => figure.cycles[1],
        "bytes" => figure.bytes,
        _ => figure.instructions,
    };
    let counted = counted.context("not measured")?;
    ensure!(counted <= most, "{counted} {unit}");
    ensure!(counted >= most / 2, "{counted} {unit}: was the work optimised away?");
    Ok(counted)
}

/// What a sample takes with `opt-level = "s"`; returns the figure that grows most, if none grows more than allowed.
pub fn small(way: Way, fast: &[Figure]) -> Result<String> {
    let (table, most) = (table()?, number("small_percent")?);
    let small = measure::printed(&build_with(way, DRIVE, "measure", build::SMALL, None)?, DRIVE)?;
    let mut worst = (0, String::new());
    for name in names(&table, "every_sample")? {
        ensure!(fast.iter().any(|figure| figure.name == name), "{name}: not measured");
        for figure in fast.iter().filter(|figure| figure.name == name) {
            let other = small.iter().find(|other| other.name == name && other.n == figure.n);
            let (few, many) = figure.instructions.zip(other.and_then(|other| other.instructions)).context("missing")?;
            let percent = 100 * many / few.max(1);
            worst = worst.max((percent, format!("{name}: {many} instead of {few}, {percent} %")));
        }
    }
    ensure!(worst.0 <= most, "{}", worst.1);
    Ok(worst.1)
}

/// Flash of programs for size and at level 3, if none grows, and what they add to the empty one with the smallest
/// profile.
pub fn flash(way: Way) -> Result<String> {
    let (table, mut lines) = (table()?, Vec::new());
    for name in names(&table, "not_larger")? {
        // Both builds have the same file.
        let fast = elf::sizes(&build(way, DRIVE, &name)?)?.flash;
        let small = elf::sizes(&build_with(way, DRIVE, &name, build::SMALL, None)?)?.flash;
        ensure!(small <= fast, "{name}: {small} bytes instead of {fast}");
        lines.push(format!("{name} {small} instead of {fast}"));
    }
    let flash = |name: &str| anyhow::Ok(elf::sizes(&build_with(way, DRIVE, name, build::SMALLEST, None)?)?.flash);
    let empty = flash("footprint_none")?;
    for (name, most) in table.get("smallest").and_then(Value::as_table).context("no table `smallest`")? {
        let (added, most) = (flash(name)? - empty, most.as_integer().unwrap_or_default());
        ensure!(added <= u64::try_from(most)?, "{name} adds {added} bytes with lto, {most} are allowed");
        lines.push(format!("{name} with lto {added}"));
    }
    Ok(lines.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_has_two_sides() {
        let figure =
            |counted| Figure { name: "a".into(), n: Some(8), instructions: Some(counted), ..Figure::default() };
        let holds = |counted, unit| within(&[figure(counted)], "a", Some(8), 100, unit).is_ok();
        assert!(holds(100, "instructions") && holds(50, "instructions"));
        assert!(!holds(101, "instructions") && !holds(49, "instructions") && !holds(100, "cycles"));
    }
}
