//! The page of the demonstration: errors of the methods, signals, decision regions and posteriors of the first draw.

use crate::demo::{self, Draw, Row, Settings};
use model::Error;
use model::core::Finding;
use model::trace::Trace;
use pages::page::{or_reason, paragraph};
use pages::plot::{self, Panel, Series};
use pages::table::table;
use pages::training;
use pages::{Class, Color, Page};

/// Creates the page.
///
/// # Errors
/// Returns an error if the model cannot be embedded.
pub fn page(settings: &Settings, first: &Draw, rows: &[Row]) -> Result<String, Error> {
    let classes = demo::class_names();
    let Settings { repetitions, traces, seed } = *settings;
    let header = ["method", "error %, mean ± sd", "published %"];
    let cells: Vec<Vec<String>> =
        rows.iter().map(|row| vec![row.name.into(), row.error(), row.published.into()]).collect();
    let methods = paragraph(&format!("Validation error over {repetitions} draws of training and validation sets."))
        + &table(&header, &cells)
        + &paragraph(
            "With na = 2 a projection to two components is an invertible map, which cannot change a linear discriminant: the source's method and ours differ in what they keep (a only, or all of a, b, c) and in the estimator.",
        );
    let examples: Vec<_> = (0..classes.len())
        .filter_map(|k| first.validation.iter().find(|t| t.class == k).map(|t| (&t.trace, k)))
        .collect();
    let page = Page::new("bearing-watch: demonstration on the standard rig")
        .conclusion(conclusion(first, rows))
        .lead(format!(
            "DC motor under velocity control; y = current, u1 = velocity reference, u2 = load torque; order [2 1 2 1 1]. \
             {traces} + {traces} traces a class, seeds from {seed}; every verdict is the embedded detector's."
        ))
        .section("Result of the first draw", &training::confusion_html(&first.repetition.all_parameters))
        .section("The source's method on the same traces", &training::confusion_html(&first.repetition.literal.all_classes))
        .section("All draws", &methods)
        .section("Signals of each class", &signals(&classes, &examples))
        .section("Features and decision regions", &training::scatter(&first.trained, &[], &first.verdicts)?)
        .section("Posteriors over time: one held-out trace after another", &training::posteriors_by_trace(&classes, &first.verdicts))
        .section("Posteriors over time: while a segment fills", &filling(first, &examples)?);
    Ok(page.render())
}

/// What was found, and what to do next.
fn conclusion(first: &Draw, rows: &[Row]) -> String {
    let confusion = &first.repetition.all_parameters;
    let rate = confusion.error_rate();
    let mut text = format!(
        "In the first draw {} of {} simulated traces get another class than their own: {:.1} % (95 % interval {:.1} to \
         {:.1} %).",
        confusion.wrong(),
        confusion.total(),
        100.0 * rate.value,
        100.0 * rate.low,
        100.0 * rate.high,
    );
    if let Some(best) = rows.iter().min_by(|one, other| one.mean.total_cmp(&other.mean)) {
        text += &format!(" Over all draws the best method is “{}”, {} % wrong.", best.name, best.error());
    }
    text + " Next: bearing-watch train with records of your own drive."
}

fn signals(classes: &[String], examples: &[(&Trace, usize)]) -> String {
    let points = |trace: &Trace, pick: fn(&Trace) -> &[f64]| {
        let step = trace.interval_s.unwrap_or(1.0);
        pick(trace).iter().enumerate().map(|(k, x)| (k as f64 * step, *x)).collect::<Vec<_>>()
    };
    let mut panels: Vec<Panel> = examples
        .iter()
        .map(|&(trace, k)| {
            let series = Series::new(classes[k].clone(), Color::of(k), points(trace, |t| &t.y));
            Panel::new(format!("current, {} / A", classes[k]), vec![series])
        })
        .collect();
    if let Some((trace, _)) = examples.first() {
        let neutral = Color::of(classes.len());
        panels.push(Panel::new(
            "velocity reference / rad/s",
            vec![Series::new("reference", neutral, points(trace, |t| &t.u1))],
        ));
        panels.push(Panel::new("load torque / N·m", vec![Series::new("load", neutral, points(trace, |t| &t.u2))]));
    }
    or_reason(plot::signals("One held-out trace of each class", "time / s", &panels))
}

/// The posterior that the detector would compute if the segment ended at each time.
fn filling(first: &Draw, examples: &[(&Trace, usize)]) -> Result<String, Error> {
    const STEP: usize = 50;
    let classes = Class::all(&demo::class_names());
    let mut html = paragraph(
        "Preview of the open segment every 0.1 s; the model is trained on whole segments of 10 s, so early posteriors are overconfident.",
    );
    for &(trace, truth) in examples {
        let step = trace.interval_s.unwrap_or(1.0);
        let previews = first.model.previews(trace, STEP);
        let segments: Vec<plot::Segment> = previews
            .into_iter()
            .map(|preview| plot::Segment {
                start: (preview.length - STEP) as f64 * step,
                end: preview.length as f64 * step,
                truth: Some(truth),
                decided: preview.verdict.ok().and_then(Finding::class),
                posteriors: preview.posteriors.iter().map(|p| f64::from(*p)).collect(),
            })
            .collect();
        let title = format!("A {} trace", classes[truth].name);
        html += &or_reason(plot::posteriors(&title, "time / s", &classes, &segments));
    }
    Ok(html)
}
