//! The page of an evaluation: confusion, rates, features over runs and in a plane, distances, posteriors, calibration.

use super::trained::{confusion_html, posteriors_by_trace};
use super::worth::calibration;
use crate::conclusion;
use crate::page::table::table;
use crate::page::{or_reason, paragraph};
use crate::plot::{self, RunPoint, ScatterClass};
use crate::segments::{Chosen, Judged, Limits, evidence, over_runs, points, strips};
use crate::{Class, Page};
use model::core::{Embedded, Finding};
use model::evaluate::{Breakdown, Confusion, Discrimination, Rate, Stability, TraceVerdict, area_words};
use model::train::Scores;

/// What was found on labelled traces.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<'a> {
    /// The model.
    pub model: &'a Embedded,
    /// Its features.
    pub chosen: Chosen<'a>,
    /// Names of the trained classes, then of the others.
    pub classes: &'a [String],
    /// All traces.
    pub verdicts: &'a [TraceVerdict],
    /// The run of each trace.
    pub runs: Option<&'a [String]>,
    /// Counts of the traces of trained classes.
    pub confusion: &'a Confusion,
    /// Scores of the traces of trained classes.
    pub scores: &'a Scores,
    /// Further results as sentences.
    pub notes: &'a [String],
    /// How well each score distinguishes each class from healthy.
    pub roc_areas: &'a [Discrimination],
    /// Rates by columns of the labels.
    pub by: &'a [Breakdown],
    /// Stability of the features of each class over runs.
    pub stability: &'a [(String, Vec<Stability>)],
}

/// Creates the page.
#[must_use]
pub fn page(lead: &str, found: Evaluation) -> Page {
    let Evaluation { model, chosen, classes, verdicts, .. } = found;
    let points = points(chosen, verdicts, found.runs);
    let mut result = if found.confusion.total() > 0 { confusion_html(found.confusion) } else { String::new() };
    result += &found.notes.iter().map(|note| paragraph(note)).collect::<String>();
    result += &areas(found.roc_areas);
    result += &found.by.iter().map(breakdown).collect::<String>();
    let words = conclusion::evaluation::words(found.confusion, verdicts, classes);
    let mut page = Page::new("bearing-watch: evaluation").conclusion(words).lead(lead).section("Result", &result);
    let over = over_runs(chosen.names, classes, &points) + &stability(found.stability);
    page = page.section("Features over runs", &over);
    page = page.section("Features in a plane", &scatter(classes, chosen.names, &points, verdicts));
    if model.healthy().is_some() {
        page = page.section("Distance from healthy, segment after segment", &distances(model, classes, verdicts));
    }
    let trained: Vec<TraceVerdict> = verdicts.iter().filter(|v| v.class < model.classes.len()).cloned().collect();
    if !trained.is_empty() {
        page = page.section("Posteriors, segment after segment", &posteriors_by_trace(&model.classes, &trained));
        page = page.section("Calibration", &calibration(&model.classes, found.scores, "decisions"));
    }
    page
}

fn breakdown(one: &Breakdown) -> String {
    let header: Vec<String> =
        [format!("right by {}", one.column), "traces".into()].into_iter().chain(one.classes.clone()).collect();
    let cell = |rate: &Option<Rate>| rate.map_or_else(|| "–".into(), |rate| rate.to_string().replace(' ', "\u{a0}"));
    let row = |(value, traces, rates): &(String, usize, Vec<Option<Rate>>)| {
        [vec![value.clone(), traces.to_string()], rates.iter().map(cell).collect()].concat()
    };
    table(&header, &one.rows.iter().map(row).collect::<Vec<_>>())
}

fn areas(found: &[Discrimination]) -> String {
    if found.is_empty() {
        return String::new();
    }
    let cell = |rate: Option<Rate>| rate.map_or_else(|| "–".into(), area_words);
    let row = |one: &Discrimination| {
        let units = if one.has_units { one.areas.units.to_string() } else { "–".into() };
        let words = one.difference().unwrap_or_default().to_string();
        vec![
            one.class.clone(),
            one.score.clone(),
            cell(one.areas.within),
            units,
            one.of_one_class.len().to_string(),
            cell(one.areas.pooled),
            words,
        ]
    };
    let header =
        ["class against healthy", "by", "ROC area within units", "units", "of one class", "of all together", ""];
    table(&header, &found.iter().map(row).collect::<Vec<_>>())
}

fn stability(found: &[(String, Vec<Stability>)]) -> String {
    let rows: Vec<Vec<String>> = found
        .iter()
        .flat_map(|(class, rows)| rows.iter().map(move |row| (class, row)))
        .map(|(class, row)| {
            let Stability { feature, runs, icc, drift, p } = row;
            let icc = format!("{:.2} [{:.2}, {:.2}]", icc.value, icc.low, icc.high);
            vec![class.clone(), feature.clone(), runs.to_string(), icc, format!("{drift:+.3}"), format!("{p:.3}")]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let header =
        ["class", "feature", "runs", "likeness within a run (ICC)", "drift a run / sd within a run", "p of the drift"];
    table(&header, &rows)
}

/// The two features that separate the classes best, with novel and wrong segments marked.
fn scatter(classes: &[String], names: &[String], points: &[RunPoint], verdicts: &[TraceVerdict]) -> String {
    let mut order: Vec<(usize, f64)> = (0..names.len()).map(|k| (k, separation(points, classes.len(), k))).collect();
    order.sort_by(|one, other| other.1.total_cmp(&one.1));
    let Some(&(first, _)) = order.first() else { return paragraph("The model has no features.") };
    let second = order.get(1).map(|(k, _)| *k);
    let at =
        |(k, point): (usize, &RunPoint)| (point.values[first], second.map_or(k as f64, |second| point.values[second]));
    let of_class = |class: usize| {
        let own = |novel: bool| {
            let chosen =
                points.iter().enumerate().filter(move |(_, point)| point.class == class && point.novel == novel);
            chosen.map(at).collect::<Vec<_>>()
        };
        let class = Class::new(class, classes[class].clone());
        ScatterClass { class, training: vec![], held_out: own(false), novel: own(true) }
    };
    let scattered: Vec<ScatterClass> = (0..classes.len()).map(of_class).collect();
    let y = second.map_or("segment", |second| names[second].as_str());
    let plot =
        or_reason(plot::scatter("The two features that separate the classes best", &names[first], y, &scattered));
    let novel = points.iter().filter(|point| point.novel).count();
    let wrong = verdicts.iter().filter(|v| v.decided != Some(Finding::Class(v.class))).count();
    plot + &paragraph(&format!(
        "Segments; {novel} of {} are novel. {wrong} of {} traces have another verdict than their class.",
        points.len(),
        verdicts.len()
    ))
}

/// Variance of the class means of a feature over the variance within classes; 0 without two classes.
fn separation(points: &[RunPoint], classes: usize, feature: usize) -> f64 {
    let of = |class: usize| -> Vec<f64> {
        let own = points.iter().filter(|point| point.class == class).map(|point| point.values[feature]);
        own.filter(|value| value.is_finite()).collect()
    };
    let own: Vec<(f64, f64)> = (0..classes)
        .map(of)
        .filter(|values| values.len() > 1)
        .map(|values| model::statistics::mean_sd(&values))
        .collect();
    if own.len() < 2 {
        return 0.0;
    }
    let (_, between) = model::statistics::mean_sd(&own.iter().map(|(mean, _)| *mean).collect::<Vec<_>>());
    let within = own.iter().map(|(_, sd)| sd * sd).sum::<f64>() / own.len() as f64;
    between * between / within.max(f64::MIN_POSITIVE)
}

fn distances(model: &Embedded, classes: &[String], verdicts: &[TraceVerdict]) -> String {
    let all: Vec<_> = verdicts.iter().flat_map(|v| v.segments.iter().map(move |segment| (v.class, segment))).collect();
    let place = |k: usize| (k as f64, k as f64 + 1.0);
    let judged = |(k, (_, segment))| Judged::new(place(k), segment, None, model.classes.len());
    let judged: Vec<Judged> = all.iter().copied().enumerate().map(judged).collect();
    let spans = all.iter().enumerate();
    let spans = spans.map(|(k, (class, _))| plot::Span { start: place(k).0, end: place(k).1, name: Some(*class) });
    let truth = plot::Strip {
        label: "true class".into(),
        names: Class::all(classes),
        spans: spans.collect(),
        in_legend: false,
    };
    let strips = [vec![truth], strips(&model.classes, &judged)].concat();
    or_reason(plot::timeline("Distance and surprise", "segment", &evidence(Limits::of(model), &judged), &strips, &[]))
}
