//! One page with the tables and plots of a campaign.

use crate::campaign::experiments::{Judge, part};
use crate::campaign::render::{ALARM_HEAD, HEAD, RATE_HEAD, alarm_cells, cells, groups, rate_rows, rate_title};
use crate::campaign::{Figure, Findings};
use crate::field::picture::rates;
use model::Error;
use pages::page::{Page, or_reason, paragraph};
use pages::palette::{Color, Marker};
use pages::plot::{self, Series};
use pages::table;

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
        page = page.section(name, &(table::table(&HEAD, &rows) + &sizes(name, &figures)));
    }
    let rows: Vec<Vec<String>> = findings.alarms.iter().map(alarm_cells).collect();
    let words =
        "Records follow each other through gate and evidence; the mean time between false alarms is set to 1000 h.";
    page = page.section("Alarm", &(paragraph(words) + &table::table(&ALARM_HEAD, &rows)));
    for rates in &findings.rates {
        page = page.section(rate_title(rates), &table::table(&RATE_HEAD, &rate_rows(rates)));
    }
    page.render()
}

/// How many goals are met, and the first that is not.
fn conclusion(findings: &Findings) -> String {
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
    let page = Page::new("bearing-watch: conditions of the field");
    Ok(page.section("Detected records", &rates(text)?).render())
}
