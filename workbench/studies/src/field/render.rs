//! The table of the field as text, tidy rows and JSON.

use serde_json::{Value, json};

use super::recipe::{FALSE_ALARM, GATE_FEATURES, chosen};
use super::rows::{CLASS_SIZES, COLUMNS};
use super::run::Draw;
use super::tally::{Tally, rate};
use super::{Findings, Settings};
use crate::campaign::render::grid;
use model::evaluate::Rate;
use rig::{Defect, DefectKind};

/// A part of a draw: the tallies, or why training refused the set.
type Part = Result<Vec<Tally>, String>;

/// Heading of a column.
#[must_use]
pub fn heading(defect: Defect) -> String {
    if defect.kind == DefectKind::Healthy { "false alarms".into() } else { named(defect) }
}

/// Kind and size of a defect, for example `spall 1/2`.
fn named(defect: Defect) -> String {
    let size = size(defect.severity);
    format!("{} {size}", defect.kind.name())
}

fn size(severity: f64) -> String {
    if severity >= 1.0 { "1".into() } else { format!("1/{}", (1.0 / severity).round()) }
}

impl Findings {
    /// The tallies of all draws in which training accepted the set, for the column with this number.
    #[must_use]
    pub fn column(&self, column: usize) -> Vec<Tally> {
        parts(self, |draw| Some(&draw.gate), column)
    }

    /// The tallies of the discriminant at the size with this number in [`CLASS_SIZES`].
    #[must_use]
    pub fn class_errors(&self, size: usize) -> Vec<Tally> {
        parts(self, |draw| draw.classes.as_ref(), size)
    }

    /// Numbers of draws in which training refused a set for the gate and for the discriminant, each with the first
    /// reason.
    #[must_use]
    pub fn refusals(&self) -> Vec<(&'static str, usize, String)> {
        let of = |what, part: fn(&Draw) -> Option<&Part>| {
            let reasons: Vec<&String> =
                self.draws.iter().filter_map(part).filter_map(|part| part.as_ref().err()).collect();
            reasons.first().map(|first| (what, reasons.len(), (*first).clone()))
        };
        let both = [of("gate", |draw| Some(&draw.gate)), of("three classes", |draw| draw.classes.as_ref())];
        both.into_iter().flatten().collect()
    }
}

fn parts(findings: &Findings, part: fn(&Draw) -> Option<&Part>, column: usize) -> Vec<Tally> {
    let accepted = findings.draws.iter().filter_map(part).filter_map(|part| part.as_ref().ok());
    accepted.filter_map(|tallies| tallies.get(column).copied()).collect()
}

/// Rate and interval in percent; `refused` without a draw.
fn cell(tallies: &[Tally]) -> String {
    if tallies.is_empty() {
        return "refused".into();
    }
    percent(rate(tallies))
}

/// Rate and interval in percent.
pub(crate) fn percent(Rate { value, low, high }: Rate) -> String {
    format!("{:.1} [{:.1}, {:.1}]", 100.0 * value, 100.0 * low, 100.0 * high)
}

/// Share of undetermined records in percent, without interval.
fn undetermined(tallies: &[Tally]) -> String {
    if tallies.is_empty() {
        return String::new();
    }
    let counts: Vec<Tally> = tallies.iter().map(|tally| tally.of_undetermined()).collect();
    format!("{:.1}", 100.0 * rate(&counts).value)
}

/// All tallies of the columns with a defect.
fn defects(findings: &Findings) -> Vec<Tally> {
    (1..COLUMNS.len()).flat_map(|column| findings.column(column)).collect()
}

fn counted_as_error(tallies: &[Tally]) -> Vec<Tally> {
    tallies.iter().map(|tally| tally.undetermined_counted()).collect()
}

/// The table, the errors of three classes, and the sets that training refused, as plain text.
#[must_use]
pub fn text(findings: &[Findings], settings: &Settings) -> String {
    let Settings { draws, healthy_training, healthy, defects_training, .. } = settings;
    let judged = match settings.together {
        1 => "records".into(),
        together => format!("runs of {together} records"),
    };
    let title = format!(
        "{} {healthy_training} healthy records at {} %: detected, % [95 % interval]; {draws} draws of {healthy} \
         healthy {judged} and {} of each defect; features {}",
        if settings.default { "Default gate of" } else { "Gate of" },
        100.0 * FALSE_ALARM,
        settings.defects,
        features(settings).map_or("chosen by training".into(), |features| features.join(", "))
    );
    let mut out = gate_grid(&title, findings);
    let title = format!(
        "{} of {healthy_training}, {defects_training} and {defects_training} records with full-size defects: error, % \
         [95 % interval]",
        if settings.default { "Default for three classes" } else { "Three classes" }
    );
    out += &class_grid(&title, findings);
    let lines = findings.iter().flat_map(|own| own.refusals().into_iter().map(move |refusal| (own, refusal)));
    let lines: Vec<String> = lines
        .map(|(own, (what, count, reason))| format!("  {}, {what}, {count} of {draws}: {reason}\n", own.row.name()))
        .collect();
    if !lines.is_empty() {
        out += &format!("Training refused the set of these draws\n{}\n", lines.concat());
    }
    out
}

fn gate_grid(title: &str, findings: &[Findings]) -> String {
    let last = ["no verdict: healthy", "defects"].map(String::from);
    let head: Vec<String> = [String::new()].into_iter().chain(COLUMNS.map(heading)).chain(last).collect();
    let row = |own: &Findings| {
        let rates = (0..COLUMNS.len()).map(|column| cell(&own.column(column)));
        let without = [undetermined(&own.column(0)), undetermined(&defects(own))];
        [own.row.name()].into_iter().chain(rates).chain(without).collect()
    };
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    grid(title, &head, &findings.iter().map(row).collect::<Vec<_>>())
}

/// Empty if no row has a discriminant.
fn class_grid(title: &str, findings: &[Findings]) -> String {
    let row = |own: &Findings| {
        let errors = (0..CLASS_SIZES.len()).map(|size| cell(&counted_as_error(&own.class_errors(size))));
        let without = (0..CLASS_SIZES.len()).map(|size| undetermined(&own.class_errors(size)));
        [own.row.name()].into_iter().chain(errors).chain(without).collect()
    };
    let rows: Vec<Vec<String>> = findings.iter().filter(|own| own.row.classes).map(row).collect();
    let head = ["", "full size", "half size", "no verdict: full size", "half size"];
    if rows.is_empty() { String::new() } else { grid(title, &head, &rows) }
}

/// None if training chooses them.
fn features(settings: &Settings) -> Option<Vec<String>> {
    (!settings.default).then(|| chosen(&settings.features, &GATE_FEATURES))
}

/// One row of counts for each row of the table, draw and column.
#[must_use]
pub fn tidy(findings: &[Findings], settings: &Settings) -> Vec<Vec<String>> {
    let head = ["row", "draw", "kind", "column", "counted", "opposite", "undetermined", "refused"];
    let mut rows = vec![head.map(String::from).to_vec()];
    let errors: Vec<String> = CLASS_SIZES.iter().map(|severity| size(*severity)).collect();
    for own in findings {
        for (draw, number) in own.draws.iter().zip(settings.first..) {
            let start = vec![own.row.name(), number.to_string()];
            rows.extend(tidy_part(&start, "detected", &draw.gate, &COLUMNS.map(heading)));
            rows.extend(draw.classes.iter().flat_map(|part| tidy_part(&start, "three-class-error", part, &errors)));
        }
    }
    rows
}

fn tidy_part(start: &[String], kind: &str, part: &Part, columns: &[String]) -> Vec<Vec<String>> {
    let row = |rest: &[String]| [start, &[kind.to_string()], rest].concat();
    match part {
        Err(reason) => vec![row(&["", "", "", "", reason].map(String::from))],
        Ok(tallies) => {
            let each = |(column, tally): (&String, &Tally)| {
                let Tally { counted, opposite, undetermined } = tally;
                let counts = [counted, opposite, undetermined].map(ToString::to_string);
                row(&[std::slice::from_ref(column), &counts, &[String::new()]].concat())
            };
            columns.iter().zip(tallies).map(each).collect()
        }
    }
}

/// Keys `settings`, `columns`, and `rows` with rates and counts.
#[must_use]
pub fn to_json(findings: &[Findings], settings: &Settings) -> Value {
    json!({
        "draws": settings.draws,
        "first": settings.first,
        "healthy_training": settings.healthy_training,
        "defects_training": settings.defects_training,
        "healthy": settings.healthy,
        "defects": settings.defects,
        "false_alarm": FALSE_ALARM,
        "features": features(settings),
        "columns": COLUMNS.map(heading),
        "rows": findings.iter().map(row_json).collect::<Vec<_>>(),
    })
}

fn row_json(own: &Findings) -> Value {
    let counts = |tallies: &[Tally]| {
        let sum = |count: fn(&Tally) -> usize| tallies.iter().map(count).sum::<usize>();
        let [counted, opposite, undetermined] = [sum(|t| t.counted), sum(|t| t.opposite), sum(|t| t.undetermined)];
        json!({ "counted": counted, "opposite": opposite, "undetermined": undetermined })
    };
    let cell = |tallies: Vec<Tally>, rated: Vec<Tally>| {
        (!tallies.is_empty()).then(|| json!({ "rate": rate(&rated).to_json(), "counts": counts(&tallies) }))
    };
    let detected = (0..COLUMNS.len()).map(|k| cell(own.column(k), own.column(k)));
    let errors = (0..CLASS_SIZES.len()).map(|k| cell(own.class_errors(k), counted_as_error(&own.class_errors(k))));
    let refusals = own.refusals().into_iter();
    let refusals = refusals.map(|(what, draws, reason)| json!({ "what": what, "draws": draws, "reason": reason }));
    json!({
        "name": own.row.name(),
        "about": own.row.judged.about,
        "detected": detected.collect::<Vec<_>>(),
        "three_class_error": own.row.classes.then(|| errors.collect::<Vec<_>>()),
        "refused": refusals.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::rows;
    use super::*;

    fn findings() -> Vec<Findings> {
        let tally = |counted| Tally { counted, opposite: 9 - counted, undetermined: 1 };
        let accepted = Draw { gate: Ok((1..9).map(tally).collect()), classes: Some(Ok(vec![tally(0), tally(2)])) };
        let refused = Draw { gate: Err("a reason".into()), classes: None };
        let row = |name: &str| rows::named(&[name.to_string()]).expect("known")[0];
        vec![
            Findings { row: row("mix"), draws: vec![accepted; 2] },
            Findings { row: row("duty-constant"), draws: vec![refused; 2] },
        ]
    }

    #[test]
    fn text_has_all_rows_and_reasons() {
        let text = text(&findings(), &Settings::standard(2, 0));
        assert!(
            text.contains("false alarms") && text.contains("spall 1/8") && text.contains("roughness 1/32"),
            "{text}"
        );
        assert!(text.contains("  mix            10.0 [2.8, 30.1]"), "{text}");
        assert!(text.contains("  duty-constant  refused"), "{text}");
        assert!(text.contains("duty-constant, gate, 2 of 2: a reason"), "{text}");
        // One of ten has no verdict, which is an error of the class.
        assert!(text.contains("\n  mix  10.0 [2.8, 30.1]  30.0 [14.5, 51.9]  10.0                   10.0\n"), "{text}");
    }

    #[test]
    fn rows_and_json_have_the_counts() {
        let settings = Settings::standard(2, 5);
        let tidy = tidy(&findings(), &settings);
        assert_eq!(tidy.len(), 1 + 2 * (8 + 2) + 2);
        assert!(tidy.iter().all(|row| row.len() == tidy[0].len()));
        assert_eq!(tidy[2], ["mix", "5", "detected", "spall 1", "2", "7", "1", ""]);
        assert_eq!(tidy[21], ["duty-constant", "5", "detected", "", "", "", "", "a reason"]);
        let json = to_json(&findings(), &settings);
        let counts = &json["rows"][0]["detected"][1]["counts"];
        assert_eq!(
            [&counts["counted"], &counts["opposite"], &counts["undetermined"]].map(Value::as_u64),
            [4, 14, 2].map(Some)
        );
        assert!(json["rows"][1]["detected"][0].is_null() && json["rows"][1]["refused"][0]["draws"] == 2);
    }
}
