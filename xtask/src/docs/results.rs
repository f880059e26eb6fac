//! The table of results in README, and that of the book's chapter on limits, from the tables of other documents.

use anyhow::{Context, Result};

use super::block::Block;
use super::campaign::{self, groups};

/// The name of the block.
pub const NAME: &str = "results";
/// The sources of the documents from which it is made.
pub const SOURCES: [&str; 4] = ["campaign", "field", "recorded", super::figures::NAME];
/// The block of what a promise needs.
pub const NEEDS: &str = "needs";
/// The campaign under the effects of the field.
pub const FIELD: &str = "docs/field.md";
/// Recorded drives.
pub const RECORDED: &str = "docs/recorded.md";

/// The texts of the documents from which the table is made.
#[derive(Debug)]
pub struct Documents {
    pub campaign: String,
    pub field: String,
    pub recorded: String,
    pub target: String,
}

/// Makes the rows of one document: what was measured, and the result.
type Rows = fn(&Documents) -> Result<Vec<[String; 2]>>;

/// The table.
pub fn block(documents: &Documents) -> Result<Block> {
    let mut lines = vec!["| | result | from |".to_owned(), "|---|---|---|".to_owned()];
    let parts: [(&str, Rows); 4] = [
        (campaign::DOCUMENT, |all| simulated(&all.campaign)),
        (FIELD, |all| in_service(&all.field)),
        (RECORDED, |all| recorded(&all.recorded)),
        (super::figures::DOCUMENT, |all| cost(&all.target)),
    ];
    for (file, rows) in parts {
        let name = file.rsplit('/').next().unwrap_or(file).trim_end_matches(".md");
        for [what, result] in rows(documents).with_context(|| file.to_owned())? {
            lines.push(format!("| {what} | {result} | [{name}]({file}) |"));
        }
    }
    Ok(Block { file: "README.md", name: NAME.to_owned(), lines })
}

/// The table of the gates in [`FIELD`] for whoever names no features.
const GATES: &str = "Default gate of 150 healthy records";
/// Its columns.
const FALSE_ALARMS: usize = 1;
const SPALL: usize = 2;
const HALF_SPALL: usize = 3;
const SPALL_OF_1_8: usize = 5;
const ROUGHNESS_OF_1_8: usize = 7;

/// A promise, what it needs, a column of the table of the gates, and its rows.
type Need = (&'static str, &'static str, usize, &'static [&'static str]);

const ALL_NEEDS: [Need; 10] = [
    (
        "1 % false alarms with changing commands, temperature, slip, any motion, all effects with a sine, with any motion",
        "150 healthy records over all of them, a model for each motion",
        FALSE_ALARMS,
        &["mix", "temperature", "slip", "duty-any", "field-sine", "field-any"],
    ),
    (
        "spall of 1/8 of the full size",
        "load sensor, angle of 14 bits at equal sampling intervals",
        SPALL_OF_1_8,
        &["mix"],
    ),
    ("the same at any temperature", "healthy records from cold to hot", SPALL_OF_1_8, &["temperature"]),
    (
        "the same in one direction, at constant speed",
        "a model of its own for each motion",
        SPALL_OF_1_8,
        &["duty-one-way", "duty-constant"],
    ),
    (
        "the same with errors of the angle, a late load sensor, a compliant payload",
        "several records, if one is not enough",
        SPALL_OF_1_8,
        &["angle-errors", "bad-load-sensor", "payload"],
    ),
    ("the same on a bearing that slips by up to 2 %", "`--slip 0.022`", SPALL_OF_1_8, &["slip"]),
    (
        "spall of full size under all effects together: sine, motions of one kind each, any motion",
        "motion that reverses",
        SPALL,
        &["field-sine", "field-duties", "field-any"],
    ),
    (
        "spall of full size, of half size, without a load sensor",
        "angle, `--velocity-ref`; for smaller ones and roughness a motion that is repeated",
        SPALL,
        &["no-load-sensor"],
    ),
    (
        "roughness of 1/8",
        "motion that reverses, load sensor, `--rising viscous_log,viscous,drag`",
        ROUGHNESS_OF_1_8,
        &["mix"],
    ),
    (
        "the same under all effects together: sine, motions of one kind each, any motion",
        "several records",
        ROUGHNESS_OF_1_8,
        &["field-sine", "field-duties", "field-any"],
    ),
];

/// What a promise needs, from the text of [`FIELD`].
pub fn needs(document: &str) -> Result<Block> {
    let head = "| promise | what it needs | false alarms, or detected, % |";
    let mut lines = vec![head.to_owned(), "|---|---|---|".to_owned()];
    for (promise, need, column, rows) in ALL_NEEDS {
        let mut numbers = rows
            .iter()
            .map(|row| number(&fixed(document, GATES, row)?, column))
            .collect::<Result<Vec<_>>>()
            .with_context(|| FIELD.to_owned())?;
        if promise.contains("half size") {
            numbers.push(number(&fixed(document, GATES, "no-load-sensor")?, HALF_SPALL)?);
        }
        lines.push(format!("| {promise} | {need} | {} |", numbers.join(", ")));
    }
    Ok(Block { file: "book/src/limits.md", name: NEEDS.to_owned(), lines })
}

fn simulated(document: &str) -> Result<Vec<[String; 2]>> {
    let classes = fixed(document, "3-class error, conditions as trained", "MIX")?;
    let of_gate = |what: &str| {
        let row = fixed(document, "trained on healthy traces alone", &format!("mix, 100 healthy traces: {what}"))?;
        number(&row, 1)
    };
    let [spall, roughness, healthy] = ["spall at 1/8", "roughness at 1/8", "false alarms"].map(of_gate);
    Ok(vec![
        [
            "simulated drive: healthy, spall or roughness; command, load and resistance differ from record to record"
                .to_owned(),
            format!(
                "error {} %; method of the source {} %",
                number(&classes, 1)?,
                number(&classes, classes.len() - 1)?
            ),
        ],
        [
            "the same, trained with 100 healthy records only: spall, roughness of 1/8".to_owned(),
            format!("{}, {} % detected; {} % false alarms", spall?, roughness?, healthy?),
        ],
    ])
}

fn in_service(document: &str) -> Result<Vec<[String; 2]>> {
    let all = fixed(document, GATES, "field-any")?;
    let no_load = fixed(document, GATES, "no-load-sensor")?;
    let cells = |row: &[&str], places: &[usize]| -> Result<String> {
        Ok(places.iter().map(|place| number(row, *place)).collect::<Result<Vec<_>>>()?.join(", "))
    };
    Ok(vec![
        [
            "all simulated effects of service together (temperature, slip, compliance, sensor errors …), any motion: spall of \
             full size, 1/2, 1/4, 1/8"
                .to_owned(),
            format!("{} % detected; {} % false alarms", cells(&all, &[SPALL, HALF_SPALL, 4, SPALL_OF_1_8])?, number(&all, FALSE_ALARMS)?),
        ],
        [
            "changing load without a load sensor: spall of full size, 1/2; roughness of full size".to_owned(),
            format!("{} % detected", cells(&no_load, &[SPALL, HALF_SPALL, 6])?),
        ],
    ])
}

fn recorded(document: &str) -> Result<Vec<[String; 2]>> {
    let loads = |name: &str| -> Result<String> {
        let row = table(document, name)?;
        Ok([1, 2, 3].map(|place| number(&row, place)).into_iter().collect::<Result<Vec<_>>>()?.join(", "))
    };
    Ok(vec![
        [
            "recorded linear actuator at 20, 40, −40 kgf, trained with normal strokes of other runs: poor lubrication"
                .to_owned(),
            format!(
                "{} % detected; {} % false alarms",
                loads("lubrication 2")?,
                loads("normal, unseen runs (false alarms)")?
            ),
        ],
        [
            "the same for a fault that the authors call undetectable: these are differences between recording sessions"
                .to_owned(),
            format!("{} % detected", loads("spalling 2")?),
        ],
    ])
}

fn cost(document: &str) -> Result<Vec<[String; 2]>> {
    let cell = |name: &str| -> Result<String> { number(&table(document, name)?, 3) };
    let bytes = |name: &str| -> Result<u64> { Ok(cell(name)?.parse()?) };
    // Without and with wait states.
    let waiting = |name: &str| -> Result<String> {
        let row = table(document, name)?;
        let cell = row.get(3).and_then(|cell| cell.split('/').nth(1));
        Ok(cell.with_context(|| format!("no cycles in `{name}`"))?.trim().to_owned())
    };
    let segments = 2 * bytes("bytes of a `Segment`, one open and one spare")?;
    let ram = bytes("bytes of a `Detector`, its segment apart")? + segments + bytes("bytes of a `Monitor`")?;
    Ok(vec![[
        "cost on a Cortex-M4F with 8 parameters, friction, and four orders of three harmonics".to_owned(),
        format!(
            "{} instructions a sample (longest {}), about {} cycles ({}); {ram} bytes of state, {} of flash",
            cell("`exchange`, mean sample")?,
            cell("`exchange`, longest sample")?,
            waiting("cycles of `exchange`, mean sample")?,
            waiting("cycles of `exchange`, longest sample")?,
            cell("flash that the whole detector adds to an empty program")?,
        ),
    ]])
}

/// The cells of a row in a table of fixed width.
fn fixed<'d>(document: &'d str, title: &str, name: &str) -> Result<Vec<&'d str>> {
    let groups = groups(document);
    let group = groups.iter().find(|group| group.title.starts_with(title));
    let rows = &group.with_context(|| format!("no table `{title}`"))?.rows;
    let row = rows.iter().find(|row| row.first() == Some(&name));
    row.cloned().with_context(|| format!("no row `{name}`"))
}

/// The cells of the first row with this name in a table in Markdown.
fn table<'d>(document: &'d str, name: &str) -> Result<Vec<&'d str>> {
    let rows = document.lines().filter(|line| line.starts_with('|'));
    let mut rows = rows.map(|line| line.trim_matches('|').split('|').map(str::trim).collect::<Vec<_>>());
    rows.find(|row| row.first() == Some(&name)).with_context(|| format!("no row `{name}`"))
}

/// The number of a cell, without its deviation or interval.
fn number(row: &[&str], place: usize) -> Result<String> {
    let cell = row.get(place).with_context(|| format!("a short row: {row:?}"))?;
    let number = cell.split(' ').next().unwrap_or_default();
    number.parse::<f64>().with_context(|| format!("`{cell}` is no number"))?;
    // One decimal is enough if the next one is zero.
    let shorter = number.strip_suffix('0').filter(|rest| rest.contains('.') && !rest.ends_with('.'));
    Ok(shorter.unwrap_or(number).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_found_by_the_names_of_their_rows() -> Result<()> {
        let text = "Title of it\n         mean ± sd, %  met  source\n  one    0.04 ± 0.10   yes  36.2\n\n| two | 1.5 [0, 3] | |\n";
        let one = fixed(text, "Title", "one")?;
        assert_eq!([number(&one, 1)?, number(&one, 3)?], ["0.04", "36.2"]);
        assert!(number(&one, 2).is_err() && number(&one, 4).is_err(), "a word, and no cell");
        assert_eq!(number(&table(text, "two")?, 1)?, "1.5");
        assert_eq!(
            [number(&["0.00 ± 0.10"], 0)?, number(&["100.0"], 0)?, number(&["5730"], 0)?],
            ["0.0", "100.0", "5730"]
        );
        assert!(table(text, "one").is_err() && fixed(text, "Title", "two").is_err());
        Ok(())
    }
}
