//! One page with the tables and plots of a campaign.

use crate::campaign::experiments::{Judge, part};
use crate::campaign::render::{ALARM_HEAD, HEAD, RATE_HEAD, alarm_cells, cells, groups, rate_rows, rate_title};
use crate::campaign::{Figure, Findings};
use crate::field::picture::{FieldRow, rates, table};
use crate::field::recipe::FALSE_ALARM;
use model::Error;
use pages::page::{Page, or_reason, paragraph};
use pages::palette::{Color, Marker};
use pages::plot::{self, Series};
use pages::table as html;

/// One self-contained page with tables and plots.
#[must_use]
pub fn page(findings: &Findings) -> String {
    let settings = &findings.settings;
    let lead = format!(
        "Simulated DC-motor rig, {} repetitions of training and validation sets of {} traces a class, no seed shared; every \
         verdict by the embedded detector in single precision.",
        settings.repetitions, settings.traces
    );
    let mut page = Page::new("bearing-watch: campaign on the standard rig").conclusion(conclusion(findings)).lead(lead);
    for (name, figures) in groups(findings) {
        let rows: Vec<Vec<String>> = figures.iter().map(|figure| cells(figure)).collect();
        page = page.section(name, &(html::table(&HEAD, &rows) + &sizes(name, &figures)));
    }
    let rows: Vec<Vec<String>> = findings.alarms.iter().map(alarm_cells).collect();
    let words =
        "Records follow each other through gate and evidence; the mean time between false alarms is set to 1000 h.";
    page = page.section("Alarm", &(paragraph(words) + &html::table(&ALARM_HEAD, &rows)));
    for rates in &findings.rates {
        page = page.section(rate_title(rates), &html::table(&RATE_HEAD, &rate_rows(rates)));
    }
    page.render()
}

/// How many goals are met, and the first that is not.
#[must_use]
pub fn conclusion(findings: &Findings) -> String {
    let goals: Vec<&Figure> = findings.figures.iter().filter(|figure| figure.met().is_some()).collect();
    let missed: Vec<&Figure> = goals.iter().copied().filter(|figure| figure.met() == Some(false)).collect();
    let all = goals.len();
    match missed.first() {
        _ if all == 0 => "No experiment has a goal: the tables have the rates.".into(),
        None => format!("All {all} goals are met. No action is needed."),
        Some(first) => format!(
            "{} of {all} goals are not met, first “{}” in “{}”: {}. Look at these rows before you change the detector.",
            missed.len(),
            first.experiment.name,
            first.experiment.group,
            first.pooled(),
        ),
    }
}

/// Rates of several sizes of a defect as lines over the size; an empty string if there are none.
fn sizes(name: &str, figures: &[&Figure]) -> String {
    let mut series: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for figure in figures {
        let experiment = &figure.experiment;
        let Some((condition, defect)) = experiment.tests.last().filter(|(_, defect)| defect.severity < 1.0) else {
            continue;
        };
        let (traces, kind) = (experiment.training.count, defect.kind.name());
        let line = format!("{}, {kind}, {traces} traces a class", condition.name);
        let point = (defect.severity.log2(), figure.mean_sd().0);
        match series.iter_mut().find(|(own, _)| *own == line) {
            Some((_, points)) => points.push(point),
            None => series.push((line, vec![point])),
        }
    }
    // A single size makes no line.
    series.retain(|(_, points)| points.iter().any(|(size, _)| (size - points[0].0).abs() > 0.0));
    if series.is_empty() {
        return String::new();
    }
    let lines: Vec<Series> = series
        .into_iter()
        .enumerate()
        .map(|(k, (name, points))| Series::new(name, Color::of(k), points).marked(Marker::of(k)))
        .collect();
    let what = match figures.first().map(|figure| figure.experiment.judge) {
        Some(Judge::Detected) => "detected, %",
        _ => "error, %",
    };
    let least = part(2.0_f64.powi(-7));
    or_reason(plot::lines(name, &format!("log2 of the size (0 full size, −7 {least})"), what, &lines))
}

/// The page of the table of the field: detected records over the size of a defect.
///
/// # Errors
/// [`Error::Usage`] if the text has no such table.
pub fn field_page(text: &str) -> Result<String, Error> {
    let page = Page::new("bearing-watch: conditions of the field").conclusion(field_conclusion(text)?);
    Ok(page.section("Detected records", &rates(text)?).render())
}

/// Under which conditions of this table the gate has more false alarms than set, and under which the full defects stay
/// hidden.
///
/// # Errors
/// [`Error::Usage`] if the text has no such table.
pub fn field_conclusion(text: &str) -> Result<String, Error> {
    table(text).map(|rows| of_field(&rows))
}

fn of_field(rows: &[FieldRow]) -> String {
    let (rows, refused): (Vec<&FieldRow>, Vec<&FieldRow>) = rows.iter().partition(|row| row.false_alarms.is_some());
    let all = rows.len();
    if all == 0 {
        return "No condition has a result: training refused each of them. Read the reasons below the table.".into();
    }
    let loud: Vec<&FieldRow> =
        rows.iter().copied().filter(|row| row.false_alarms.is_some_and(|own| own.low > FALSE_ALARM)).collect();
    let is_hidden = |row: &&FieldRow| row.defects.iter().any(|(_, size, found)| *size >= 1.0 && found.high < 1.0);
    let hidden: Vec<&FieldRow> = rows.iter().copied().filter(is_hidden).collect();
    let named = |rows: &[&FieldRow]| rows.first().map_or_else(String::new, |row| format!(", first {}", row.name));
    let set = 100.0 * FALSE_ALARM;
    let alarms = match loud.len() {
        0 => format!("Under none of {all} conditions are the false alarms above the set {set} % (95 % intervals)."),
        count => format!(
            "Under {count} of {all} conditions the false alarms are above the set {set} % (95 % interval){}.",
            named(&loud)
        ),
    };
    let found = match hidden.len() {
        0 => "Every defect of full size is found under each of them.".to_owned(),
        count => format!("Under {count}, a defect of full size is not always found{}.", named(&hidden)),
    };
    let next = if loud.is_empty() && hidden.is_empty() {
        "Look at the smallest sizes for what a drive of yours can show."
    } else {
        "Record healthy drives under these conditions before you rely on the detector there."
    };
    let without = match refused.len() {
        0 => String::new(),
        count => format!(" There is no result for {count} more{}.", named(&refused)),
    };
    format!("{alarms} {found}{without} {next}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_of_the_field_begins_with_what_it_shows() {
        let text = "Gate: detected\n        false alarms    spall 1              spall 1/2\n  mix   1.0 [0.5, 2.2]  \
                    100.0 [96.9, 100.0]  50.0 [40.0, 60.0]\n  slip  4.0 [2.5, 6.2]  80.0 [70.0, 88.0]  5.0 [1.0, 9.0]\n";
        let words = field_conclusion(text).expect("a table");
        assert!(words.starts_with("Under 1 of 2 conditions the false alarms are above the set 1 %"), "{words}");
        assert!(words.contains("first slip.") && words.contains("Under 1, a defect of full size is not always found"));
        let good = field_conclusion(&text.replace("  slip  4.0 [2.5", "  slip  1.2 [0.5")).expect("a table");
        assert!(good.starts_with("Under none of 2 conditions"), "{good}");
        let refused = text
            .replace("80.0 [70.0, 88.0]  5.0 [1.0, 9.0]", "refused             refused")
            .replace("4.0 [2.5, 6.2]", "refused       ");
        let partly = field_conclusion(&refused).expect("a table");
        assert!(
            partly.starts_with("Under none of 1 conditions") && partly.contains(" no result for 1 more, first slip."),
            "{partly}"
        );
        let none =
            field_conclusion(&refused.replace("  mix   1.0 [0.5, 2.2]  100.0 [96.9, 100.0]  50.0 [40.0, 60.0]\n", ""))
                .expect("a table");
        assert!(none.starts_with("No condition has a result"), "{none}");
        assert!(field_page(text).is_ok_and(|page| page.contains("class=\"conclusion\"")));
    }
}
