//! Results of a campaign as text, tidy rows and JSON.

use serde_json::{Value, json};

use super::alarms::{Alarmed, Rates};
use super::{Figure, Findings};
use model::statistics::mean_sd;
use rig::DefectKind;

pub(crate) const HEAD: [&str; 6] = ["", "mean ± sd, %", "pooled [95 %], %", "goal, %", "met", "source's method, %"];

/// Cells of the row of a figure, in the columns [`HEAD`].
pub(crate) fn cells(figure: &Figure) -> Vec<String> {
    let (mean, sd) = figure.mean_sd();
    let pooled = figure.pooled();
    vec![
        figure.experiment.name.clone(),
        format!("{mean:.2} ± {sd:.2}"),
        format!("{:.2} [{:.2}, {:.2}]", 100.0 * pooled.value, 100.0 * pooled.low, 100.0 * pooled.high),
        figure.experiment.goal.map_or_else(String::new, |goal| goal.to_string()),
        figure.met().map_or("", |met| if met { "yes" } else { "no" }).into(),
        figure.literal().map_or_else(String::new, |percent| format!("{percent:.1}")),
    ]
}

/// Groups, in the order of their first figure.
pub(crate) fn groups(findings: &Findings) -> Vec<(&'static str, Vec<&Figure>)> {
    let mut groups: Vec<(&'static str, Vec<&Figure>)> = Vec::new();
    for figure in &findings.figures {
        match groups.iter_mut().find(|(name, _)| *name == figure.experiment.group) {
            Some((_, own)) => own.push(figure),
            None => groups.push((figure.experiment.group, vec![figure])),
        }
    }
    groups
}

pub(crate) fn alarm_cells(alarmed: &Alarmed) -> Vec<String> {
    let all = alarmed.records.len();
    let within = alarmed.records.iter().flatten().filter(|k| **k <= 3).count();
    let alarms: Vec<usize> = alarmed.records.iter().flatten().copied().collect();
    let (first, last) = (alarms.iter().min(), alarms.iter().max());
    let span = first.zip(last).map_or_else(|| "none".into(), |(a, b)| format!("record {a} to {b}"));
    let goal = if alarmed.kind == DefectKind::Healthy { "none" } else { "within 3 records" };
    vec![
        alarmed.kind.name().into(),
        format!("{} of {all}", alarms.len()),
        format!("{within} of {all}"),
        span,
        goal.into(),
    ]
}

pub(crate) const ALARM_HEAD: [&str; 5] = ["sequences of 5 records", "alarmed", "within 3 records", "alarm at", "goal"];
pub(crate) const RATE_HEAD: [&str; 5] = [
    "set rate",
    "mean rate of all gates",
    "5 % and 95 % of single gates",
    "goal",
    "healthy traces for 3 × the rate at most",
];

pub(crate) fn rate_rows(rates: &Rates) -> Vec<Vec<String>> {
    let row = |((set, found), needed): (&(f64, Vec<f64>), &usize)| {
        let mut sorted = found.clone();
        sorted.sort_by(f64::total_cmp);
        let at =
            |part: f64| sorted.get((part * (sorted.len() - 1) as f64).round() as usize).copied().unwrap_or(f64::NAN);
        vec![
            format!("{set:e}"),
            format!("{:.2e}", mean_sd(found).0),
            format!("{:.1e} and {:.1e}", at(0.05), at(0.95)),
            "set rate × 1.5^±1".into(),
            needed.to_string(),
        ]
    };
    rates.rates.iter().zip(&rates.needed).map(row).collect()
}

pub(crate) fn rate_title(rates: &Rates) -> String {
    format!(
        "False alarms, {}: {} gates of {} healthy traces, {} judged traces each",
        rates.condition,
        rates.rates.first().map_or(0, |(_, found)| found.len()),
        rates.traces,
        rates.judged
    )
}

/// All results as plain text.
#[must_use]
pub fn text(findings: &Findings) -> String {
    let mut out = String::new();
    for (name, figures) in groups(findings) {
        out += &grid(name, &HEAD, &figures.into_iter().map(cells).collect::<Vec<_>>());
    }
    out += &grid(
        "Alarm (mean time between false alarms 1000 h)",
        &ALARM_HEAD,
        &findings.alarms.iter().map(alarm_cells).collect::<Vec<_>>(),
    );
    for rates in &findings.rates {
        out += &grid(&rate_title(rates), &RATE_HEAD, &rate_rows(rates));
    }
    out
}

/// A table of fixed-width text: title, headings, rows, and an empty line.
pub(crate) fn grid(title: &str, head: &[&str], rows: &[Vec<String>]) -> String {
    let width = |text: &str| text.chars().count();
    let column = |k: usize| rows.iter().map(|row| width(&row[k])).chain([width(head[k])]).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len()).map(column).collect();
    let line = |row: &mut dyn Iterator<Item = &str>| {
        let cells = row.zip(&widths).map(|(cell, wide)| format!("{cell}{}", " ".repeat(wide - width(cell))));
        format!("  {}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    let mut out = format!("{title}\n{}", line(&mut head.iter().copied()));
    rows.iter().for_each(|row| out += &line(&mut row.iter().map(String::as_str)));
    out + "\n"
}

/// Cells of a row of a table, which two spaces or more separate.
#[must_use]
pub fn grid_cells(row: &str) -> Vec<&str> {
    row.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect()
}

/// One row per figure and repetition.
#[must_use]
pub fn tidy(findings: &Findings) -> Vec<Vec<String>> {
    let head = ["group", "figure", "repetition", "counted", "judged", "source_error"];
    let mut rows = vec![head.map(String::from).to_vec()];
    for figure in &findings.figures {
        for (k, count) in figure.counts.iter().enumerate() {
            rows.push(vec![
                figure.experiment.group.into(),
                figure.experiment.name.clone(),
                (findings.settings.first as usize + k).to_string(),
                count.counted.to_string(),
                count.judged.to_string(),
                count.literal.map_or_else(String::new, |error| error.to_string()),
            ]);
        }
    }
    rows
}

/// Keys `repetitions`, `figures`, `alarms`, `false_alarms`.
#[must_use]
pub fn to_json(findings: &Findings) -> Value {
    let figure = |figure: &Figure| {
        let (mean, sd) = figure.mean_sd();
        let pooled = figure.pooled();
        json!({
            "group": figure.experiment.group,
            "name": figure.experiment.name,
            "mean_percent": mean,
            "sd_percent": sd,
            "pooled": { "value": pooled.value, "low": pooled.low, "high": pooled.high },
            "goal": figure.experiment.goal.map(|goal| goal.to_string()),
            "met": figure.met(),
            "source_error_percent": figure.literal(),
        })
    };
    let alarm = |alarmed: &Alarmed| json!({ "class": alarmed.kind.name(), "alarm_at_record": alarmed.records });
    let rate = |rates: &Rates| {
        json!({
            "condition": rates.condition,
            "healthy_traces": rates.traces,
            "rates": rates.rates.iter().map(|(set, found)| json!({ "set": set, "gates": found })).collect::<Vec<_>>(),
            "healthy_traces_needed": rates.needed,
        })
    };
    json!({
        "repetitions": findings.settings.repetitions,
        "figures": findings.figures.iter().map(figure).collect::<Vec<_>>(),
        "alarms": findings.alarms.iter().map(alarm).collect::<Vec<_>>(),
        "false_alarms": findings.rates.iter().map(rate).collect::<Vec<_>>(),
    })
}
