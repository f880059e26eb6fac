//! Results of the campaign on the actuator as text, rows and JSON.

use serde_json::{Value, json};

use super::run::{Count, MODELS};
use super::{Calibration, Findings};
use crate::campaign::render::{HEAD, grid};
use crate::literal::Judged;
use model::evaluate::Rate;
use model::statistics::mean_sd;
use rig::ema::EmaDefect;

/// Mean and standard deviation over the draws, percent, as text.
fn over_draws(rates: impl Iterator<Item = f64>, digits: usize) -> String {
    let (mean, sd) = mean_sd(&rates.map(|rate| 100.0 * rate).collect::<Vec<_>>());
    format!("{mean:.digits$} ± {sd:.digits$}")
}

/// The rate over all draws together, with a 95 % interval.
#[must_use]
pub fn pooled(counts: &[Count]) -> Rate {
    Rate::wilson(counts.iter().map(|own| own.counted).sum(), counts.iter().map(|own| own.judged).sum())
}

fn rate(count: &Count) -> f64 {
    count.counted as f64 / count.judged.max(1) as f64
}

/// Mean of the rates over the draws, percent.
fn mean_percent(counts: &[Count]) -> f64 {
    mean_sd(&counts.iter().map(|count| 100.0 * rate(count)).collect::<Vec<_>>()).0
}

/// All results as plain text.
#[must_use]
pub fn text(findings: &Findings) -> String {
    let head = &HEAD[..5];
    let mut sections: Vec<(&str, Vec<Vec<String>>)> = vec![];
    for figure in &findings.figures {
        let Rate { value, low, high } = pooled(&figure.counts);
        let goal = figure.experiment.goal;
        let met = goal.map(|goal| goal.met(mean_percent(&figure.counts)));
        let cells = vec![
            figure.experiment.name.clone(),
            over_draws(figure.counts.iter().map(rate), 2),
            format!("{:.2} [{:.2}, {:.2}]", 100.0 * value, 100.0 * low, 100.0 * high),
            goal.map_or_else(String::new, |goal| goal.to_string()),
            met.map_or("", |met| if met { "yes" } else { "no" }).into(),
        ];
        match sections.iter_mut().find(|(name, _)| *name == figure.experiment.section) {
            Some((_, rows)) => rows.push(cells),
            None => sections.push((figure.experiment.section, vec![cells])),
        }
    }
    let ours: String = sections.iter().map(|(name, rows)| grid(name, head, rows)).collect();
    if findings.settings.default { ours } else { ours + &source(findings) + &calibration(findings) }
}

const SOURCE_HEAD: [&str; 6] = ["", "three classes", "healthy / spall", "healthy / roughness", "both pooled", "traces"];

/// Errors of the source's method over draws.
fn errors(all: &[Judged]) -> Vec<String> {
    let rates: [fn(&Judged) -> f64; 5] = [
        Judged::all_error,
        |judged| judged.pair_error(1),
        |judged| judged.pair_error(2),
        Judged::pooled_error,
        Judged::row_error,
    ];
    rates.iter().map(|rate| over_draws(all.iter().map(rate), 1)).collect()
}

fn source(findings: &Findings) -> String {
    let row = |(model, all): (&crate::tables::chapter5::published::Published, &Vec<Judged>)| {
        let order = model.order.orders().map(|n| n.to_string()).join(" ");
        let name = format!("MIX: Table {}, u1 = {}, order [{order}]", model.number, model.input.name());
        std::iter::once(name).chain(errors(all)).collect()
    };
    let title = "source's method on the same records, logged as at Moog: iv4, PCA to 2, LDA, mean ± sd, %";
    grid(title, &SOURCE_HEAD, &MODELS.iter().zip(&findings.source).map(row).collect::<Vec<_>>())
}

fn calibration(findings: &Findings) -> String {
    let row = |own: &Calibration| {
        let name = format!("{}: size {}", own.condition.name, own.severity);
        std::iter::once(name).chain(errors(&own.judged)).collect()
    };
    let title = format!(
        "source's method by the size of the defects, Table {}: mean ± sd, %; calibrated size {}",
        MODELS[0].number,
        EmaDefect::CALIBRATED
    );
    grid(&title, &SOURCE_HEAD, &findings.calibration.iter().map(row).collect::<Vec<_>>())
}

/// One row per experiment and draw.
#[must_use]
pub fn tidy(findings: &Findings) -> Vec<Vec<String>> {
    let mut rows = vec![["section", "experiment", "draw", "counted", "judged"].map(String::from).to_vec()];
    for figure in &findings.figures {
        for (k, count) in figure.counts.iter().enumerate() {
            rows.push(vec![
                figure.experiment.section.into(),
                figure.experiment.name.clone(),
                (findings.settings.first as usize + k).to_string(),
                count.counted.to_string(),
                count.judged.to_string(),
            ]);
        }
    }
    rows
}

/// Keys `draws`, `records`, `default`, `experiments`, `source`, `calibration`.
#[must_use]
pub fn to_json(findings: &Findings) -> Value {
    let judged = |all: &[Judged]| {
        let (mean, sd) = mean_sd(&all.iter().map(|own| 100.0 * own.all_error()).collect::<Vec<_>>());
        json!({ "three_classes_percent": mean, "sd_percent": sd })
    };
    let experiment = |figure: &super::Figure| {
        json!({
            "section": figure.experiment.section,
            "name": figure.experiment.name,
            "mean_percent": mean_percent(&figure.counts),
            "pooled": pooled(&figure.counts).to_json(),
            "goal": figure.experiment.goal.map(|goal| goal.to_string()),
        })
    };
    let size = |own: &Calibration| json!({ "condition": own.condition.name, "size": own.severity, "errors": judged(&own.judged) });
    let source = MODELS.iter().zip(&findings.source);
    json!({
        "draws": findings.settings.draws,
        "records": findings.settings.records,
        "default": findings.settings.default,
        "experiments": findings.figures.iter().map(experiment).collect::<Vec<_>>(),
        "source": source.map(|(model, all)| json!({ "table": model.number, "errors": judged(all) })).collect::<Vec<_>>(),
        "calibration": findings.calibration.iter().map(size).collect::<Vec<_>>(),
    })
}
