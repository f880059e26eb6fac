//! The table of the book that quotes `docs/campaign.md`.

use anyhow::{Context, Result, ensure};

use super::block::Block;

/// The document that holds the campaign's output.
pub const DOCUMENT: &str = "docs/campaign.md";

/// A group of the campaign, by the start of its title, and experiments, by the start of their names.
type Of = (&'static str, &'static [&'static str]);

/// Title, experiments, and what is shown of them.
const ROWS: [(&str, Of, Show); 9] = [
    (
        "three classes, conditions as trained: standard / every trace under its own (MIX)",
        ("3-class error, conditions as trained", &["standard", "MIX"]),
        Show::Each,
    ),
    (
        "trained on the standard rig; other reference, other load, R ± 10 %: the worst of 13",
        ("3-class error, trained on the standard rig, judged under another condition", &[""]),
        Show::Worst,
    ),
    (
        "half-size defects, trained at full size, in MIX: misnamed / called healthy",
        ("half-size defects", &["mix: misnamed", "mix: called healthy"]),
        Show::Each,
    ),
    (
        "100 healthy traces alone, 1 % false alarms, MIX: spall at 1/2, 1/4, 1/8 found",
        (
            "trained on healthy traces alone",
            &[
                "mix, 100 healthy traces: spall at 1/2",
                "mix, 100 healthy traces: spall at 1/4",
                "mix, 100 healthy traces: spall at 1/8",
            ],
        ),
        Show::Each,
    ),
    (
        "healthy or not in MIX, one record: spall at 1/5, roughness at 1/32",
        (
            "healthy or not, retrained at each size: error of one 10 s record",
            &["mix: spall at 1/5", "mix: roughness at 1/32"],
        ),
        Show::Each,
    ),
    (
        "the same, four records: spall at 1/8, roughness at 1/64",
        (
            "healthy or not, retrained at each size: error of four records",
            &["mix: spall at 1/8", "mix: roughness at 1/64"],
        ),
        Show::Each,
    ),
    (
        "spall against Coulomb roughness of equal torque, full / half / quarter size",
        ("spall against Coulomb roughness", &["standard: size full size", "standard: size 1/2", "standard: size 1/4"]),
        Show::Each,
    ),
    (
        "false alarms of 20 gates of 200 healthy traces, set to 1 % / 0.1 %",
        ("False alarms, standard", &["1e-2", "1e-3"]),
        Show::Rates,
    ),
    ("alarm on a full-size spall / roughness", ("Alarm", &["spall", "roughness"]), Show::Alarms),
];

/// What a row shows.
#[derive(Clone, Copy, Debug)]
enum Show {
    /// The mean of each experiment.
    Each,
    /// The largest mean.
    Worst,
    /// Rates, as percentages.
    Rates,
    /// The records that alarm.
    Alarms,
}

/// One table of the campaign's output.
#[derive(Debug)]
pub(super) struct Group<'d> {
    pub(super) title: &'d str,
    /// The cells of each row, without the row of headings.
    pub(super) rows: Vec<Vec<&'d str>>,
}

/// The table, from the text of [`DOCUMENT`].
pub fn block(document: &str) -> Result<Block> {
    let groups = groups(document);
    let mut lines =
        vec!["| | error or rate, mean of 20 draws | source's method |".to_owned(), "|---|---|---|".to_owned()];
    for (title, of, show) in ROWS {
        let [ours, source] = cells(&groups, of, show).with_context(|| format!("{DOCUMENT}: {title}"))?;
        lines.push(format!("| {title} | {ours} | {source} |").replace("|  |", "| |"));
    }
    Ok(Block { file: "book/src/introduction.md", name: "summary".to_owned(), lines })
}

/// The tables of the output: a title, a line of headings, and rows; an empty line ends a table.
pub(super) fn groups(document: &str) -> Vec<Group<'_>> {
    let lines: Vec<&str> = document.lines().collect();
    let tables = lines.split(|line| line.is_empty() || line.starts_with("```"));
    tables
        .filter_map(|table| match table {
            [title, head, rows @ ..] if head.starts_with("  ") => {
                Some(Group { title, rows: rows.iter().map(|row| cells_of(row)).collect() })
            }
            _ => None,
        })
        .collect()
}

/// The cells of a row, which two spaces or more separate.
fn cells_of(row: &str) -> Vec<&str> {
    row.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()
}

/// The cells for ours and for the source's method.
fn cells(groups: &[Group<'_>], (title, names): Of, show: Show) -> Result<[String; 2]> {
    let group = groups.iter().find(|group| group.title.starts_with(title));
    let group = group.with_context(|| format!("no table `{title}`"))?;
    let mut rows: Vec<&[&str]> = Vec::new();
    for name in names {
        let before = rows.len();
        rows.extend(
            group.rows.iter().filter(|row| row.first().is_some_and(|cell| cell.starts_with(name))).map(Vec::as_slice),
        );
        ensure!(rows.len() > before, "no row `{name}`");
    }
    let column = |k: usize| -> Result<Vec<&str>> {
        rows.iter().map(|row| row.get(k).copied().with_context(|| format!("a short row: {row:?}"))).collect()
    };
    match show {
        Show::Each | Show::Worst => {
            // Behind the mean a row has the pooled rate, and may have a goal, whether it is met, and the source's
            // error.
            let source = rows.iter().map(|row| row.iter().skip(2).copied().find(|cell| cell.parse::<f64>().is_ok()));
            let source = source.collect::<Option<Vec<&str>>>();
            Ok([percent(&column(1)?, show)?, source.map_or_else(|| Ok(String::new()), |cells| percent(&cells, show))?])
        }
        Show::Rates => {
            let rates = column(1)?.into_iter().map(|rate| Ok(format!("{:.2}", 100.0 * rate.parse::<f64>()?)));
            Ok([format!("{} %", rates.collect::<Result<Vec<_>>>()?.join(" / ")), String::new()])
        }
        Show::Alarms => {
            // `record 2 to 2`
            let alarms = column(3)?.into_iter().map(|span| match span.rsplit_once(" to ") {
                Some((first, last)) if first.ends_with(&format!(" {last}")) => first,
                _ => span,
            });
            Ok([alarms.collect::<Vec<_>>().join(" / "), String::new()])
        }
    }
}

/// The numbers before ` ± `, with one decimal: each, or the largest.
fn percent(cells: &[&str], show: Show) -> Result<String> {
    let number = |cell: &&str| {
        let mean = cell.split(" ± ").next().unwrap_or_default();
        mean.parse::<f64>().with_context(|| format!("`{cell}` is no number"))
    };
    let mut numbers = cells.iter().map(number).collect::<Result<Vec<_>>>()?;
    if matches!(show, Show::Worst) {
        numbers = vec![numbers.iter().fold(0.0, |worst, number| number.max(worst))];
    }
    let texts: Vec<String> = numbers.iter().map(|number| format!("{number:.1}")).collect();
    Ok(format!("{} %", texts.join(" / ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
```text
Errors
            mean ± sd, %  goal, %  met  source's method, %
  one       0.04 ± 0.10   ≤ 0.2    yes  36.2
  two, N·m  1.25 ± 0.10                 49.8
  three     2.00 ± 0.00   ≤ 2      yes

Rates
  set rate  mean rate of all gates  goal
  1e-2      9.88e-3                 none
```
";

    #[test]
    fn rows_are_read_by_name() -> Result<()> {
        let groups = groups(TEXT);
        assert_eq!(cells(&groups, ("Errors", &["two", "one"]), Show::Each)?, ["1.2 / 0.0 %", "49.8 / 36.2 %"]);
        assert_eq!(cells(&groups, ("Errors", &[""]), Show::Worst)?, ["2.0 %", ""]);
        assert_eq!(cells(&groups, ("Rates", &["1e-2"]), Show::Rates)?, ["0.99 %", ""]);
        assert!(cells(&groups, ("Errors", &["four"]), Show::Each).is_err());
        assert!(cells(&groups, ("Alarm", &["spall"]), Show::Alarms).is_err());
        Ok(())
    }
}
