//! Tables of documents as templates (`templates/`), whose references in braces are replaced by measured figures, or by
//! cells of other documents.
//!
//! ```text
//! {counts NAME}                   three cells: instructions, cycles without and with wait states
//! {instructions NAME @5 8}        one figure, of one name or several between slashes, for each size behind the @; or
//!                                 `bytes`, `n`, `both` (cycles without / with wait states), `share` (of the period)
//! %columns A; B                   from here on `*` in a reference stands for A in a cell, and for B in the next one
//! %from FILE | TITLE              from here on references are cells of the table with this title in a document, or of
//!                                 its tables in Markdown if there is no title
//! {ROW; COLUMN FORMAT}            a number of a row; formats are `.1` for one decimal, `max` for the largest,
//!                                 `percent` of a rate, `span` of records, `second` behind a slash; the column `source`
//!                                 is the first number behind the second column; several between + are summed
//! ```

use std::fs;

use anyhow::{Context, Result};

use crate::cost::measure::Figure;
use crate::workspace;

/// Cycles between two interrupts at 10 kHz, of a processor with 168 MHz.
const PERIOD: u64 = 16_800;

/// The lines of a template.
pub fn filled(template: &str, figures: &[Figure]) -> Result<Vec<String>> {
    let (mut columns, mut from, mut lines) = (Vec::new(), None, Vec::new());
    for line in template.lines() {
        if let Some(names) = line.strip_prefix("%columns ") {
            columns = names.split("; ").collect();
        } else if let Some(place) = line.strip_prefix("%from ") {
            let (file, title) = place.split_once(" | ").unwrap_or((place, ""));
            let text =
                fs::read_to_string(workspace::root().join(file)).with_context(|| format!("cannot read {file}"))?;
            from = Some(table(&text, title).with_context(|| place.to_owned())?);
        } else {
            let resolved = replaced(line, |reference| match &from {
                Some(rows) => quoted(rows, reference),
                None if reference.contains('*') => {
                    let cells = columns.iter().map(|column| figure(figures, &reference.replace('*', column)));
                    Ok(cells.collect::<Result<Vec<_>>>()?.join(" | "))
                }
                None => figure(figures, reference),
            });
            lines.push(resolved?);
        }
    }
    Ok(lines)
}

/// A line with what stands for its references.
fn replaced(line: &str, resolve: impl Fn(&str) -> Result<String>) -> Result<String> {
    let (mut text, mut rest) = (String::new(), line);
    while let Some((before, behind)) = rest.split_once('{') {
        let (reference, after) = behind.split_once('}').with_context(|| format!("an open brace: {line}"))?;
        text = text + before + &resolve(reference).with_context(|| reference.to_owned())?;
        rest = after;
    }
    Ok(text + rest)
}

/// The figures of a reference.
fn figure(figures: &[Figure], reference: &str) -> Result<String> {
    let (kind, names) = reference.split_once(' ').context("a kind without a name")?;
    let (names, sizes) = names.split_once(" @").unwrap_or((names, ""));
    let sizes: Vec<Option<u64>> = sizes.split(' ').map(|size| size.parse().ok()).collect();
    let values = |value: &dyn Fn(&Figure) -> Option<u64>, optional: bool| {
        let mut numbers = Vec::new();
        for name in names.split(" / ") {
            for n in &sizes {
                let found = figures.iter().find(|own| own.name == name && (n.is_none() || own.n == *n));
                let value = value(found.with_context(|| format!("not measured: {name}"))?);
                // Cycles of any data are not estimated.
                let none = (optional && name.ends_with(", any data")).then(|| "–".to_owned());
                numbers.push(value.map(|number| number.to_string()).or(none).with_context(|| format!("{name}: none"))?);
            }
        }
        anyhow::Ok(numbers.join(" / "))
    };
    let cycles = |place: usize| values(&|own| own.cycles.get(place).copied().flatten(), true);
    Ok(match kind {
        "counts" => format!("{} | {} | {}", values(&|own| own.instructions, false)?, cycles(0)?, cycles(1)?),
        "instructions" => values(&|own| own.instructions, false)?,
        "bytes" => values(&|own| own.bytes, false)?,
        "n" => values(&|own| own.n, false)?,
        "both" => format!("{} / {}", cycles(0)?, cycles(1)?),
        _ => format!("{} %", (100 * cycles(1)?.parse::<u64>()?).div_ceil(PERIOD)),
    })
}

/// The rows of a table of fixed width, whose title is followed by headings, and which an empty line ends; or of all
/// tables in Markdown.
fn table(document: &str, title: &str) -> Result<Vec<Vec<String>>> {
    let own = |cells: &mut dyn Iterator<Item = &str>| cells.map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    if title.is_empty() {
        let rows = document.lines().filter(|line| line.starts_with('|'));
        return Ok(rows.map(|line| own(&mut line.trim_matches('|').split('|'))).collect());
    }
    let lines: Vec<&str> = document.lines().collect();
    let is_title = |pair: &[&str]| pair[0].starts_with(title) && pair[1].starts_with("  ");
    let start = lines.windows(2).position(is_title).context("no such table")?;
    let rows = lines.iter().skip(start + 2).take_while(|line| line.starts_with("  "));
    Ok(rows.map(|line| own(&mut line.split("  ").filter(|cell| !cell.trim().is_empty()))).collect())
}

/// A cell, or the sum of several.
fn quoted(rows: &[Vec<String>], reference: &str) -> Result<String> {
    let parts: Vec<&str> = reference.split(" + ").collect();
    if parts.len() > 1 {
        let numbers = parts.iter().map(|part| Ok(quoted(rows, part)?.parse::<u64>()?)).collect::<Result<Vec<_>>>();
        return Ok(numbers?.iter().sum::<u64>().to_string());
    }
    let (name, place) = reference.rsplit_once("; ").context("a row without a column")?;
    let (column, format) = place.split_once(' ').unwrap_or((place, ""));
    let cell = |row: &[String]| -> Result<String> {
        let cell = match column.parse::<usize>() {
            Ok(place) => row.get(place),
            Err(_) => row.iter().skip(2).find(|cell| cell.parse::<f64>().is_ok()),
        };
        Ok(cell.with_context(|| format!("a short row: {row:?}"))?.clone())
    };
    let number = |cell: &str| -> Result<f64> {
        let number = cell.split(' ').next().unwrap_or_default();
        number.parse().with_context(|| format!("`{cell}` is no number"))
    };
    if format == "max" {
        let numbers = rows.iter().map(|row| number(&cell(row)?)).collect::<Result<Vec<_>>>()?;
        return Ok(format!("{:.1}", numbers.into_iter().fold(0.0, f64::max)));
    }
    let named = |exact: bool| rows.iter().find(|row| row[0] == name || !exact && row[0].starts_with(name));
    let text = cell(named(true).or_else(|| named(false)).context("no such row")?)?;
    Ok(match format {
        ".1" => format!("{:.1}", number(&text)?),
        "percent" => format!("{:.2}", 100.0 * number(&text)?),
        // `record 2 to 2`
        "span" => match text.rsplit_once(" to ") {
            Some((first, last)) if first.ends_with(&format!(" {last}")) => first.to_owned(),
            _ => text,
        },
        "second" => text.split('/').nth(1).context("one number only")?.trim().to_owned(),
        _ => {
            number(&text)?;
            // One decimal is enough if the next one is zero.
            let text = text.split(' ').next().unwrap_or_default();
            let shorter = text.strip_suffix('0').filter(|rest| rest.contains('.') && !rest.ends_with('.'));
            shorter.unwrap_or(text).to_owned()
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_and_cells_take_the_places_of_their_references() -> Result<()> {
        let figure = |name: &str, n| Figure {
            name: name.to_owned(),
            n: Some(n),
            instructions: Some(10 * n),
            cycles: [Some(n), Some(1681)],
            ..Figure::default()
        };
        let figures = [figure("a, b", 5), figure("a, b", 8), figure("c, b", 5)];
        let lines =
            filled("%columns a; c\n| {instructions *, b @5} |\n| {counts a, b @5 8} | {share c, b} |", &figures)?;
        assert_eq!(lines, ["| 50 | 50 |", "| 50 / 80 | 5 / 8 | 1681 / 1681 | 11 % |"]);
        assert!(filled("{bytes a, b}", &figures).is_err() && filled("{counts d}", &figures).is_err());
        let text = "Title of it\n         mean ± sd, %  met  source\n  one    0.04 ± 0.10   yes  36.2\n  two  1.50  x\n\n| x | 12 / 3 |\n";
        let rows = table(text, "Title")?;
        let cells = ["one; 1", "one; source", "tw; 1", "all; 1 max", "one; 1 .1"].map(|own| quoted(&rows, own).ok());
        assert_eq!(cells.map(Option::unwrap_or_default), ["0.04", "36.2", "1.5", "1.5", "0.0"]);
        assert_eq!(quoted(&table(text, "")?, "x; 1 second")?, "3");
        assert!(quoted(&rows, "three; 1").is_err() && quoted(&rows, "one; 2").is_err() && table(text, "No").is_err());
        Ok(())
    }
}
