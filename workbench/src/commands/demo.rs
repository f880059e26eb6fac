//! `bearing-watch demo`

use std::path::{Path, PathBuf};

use serde_json::json;

use super::options::Notes;
use super::output;
use crate::Error;
use crate::demo::{self, Draw, Repetition, Settings};
use crate::embedded::Finding;
use crate::report::Page;
use crate::report::page::{or_reason, paragraph};
use crate::report::plot::{self, Panel, Series};
use crate::report::table::table;
use crate::report::{Class, Color};
use crate::trace::{Channels, Preparation, Trace};
use crate::{export, pages};

/// The whole chain on the simulated standard rig: traces, training, verdicts of the embedded detector, plots
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch demo --out demo.html")]
pub(super) struct Args {
    /// The page with the plots
    #[arg(long, value_name = "FILE", default_value = "bearing-watch-demo.html")]
    out: PathBuf,
    /// Draws of training and validation sets
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repetitions: u32,
    /// Traces a class, in training and again in validation
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(8..=1000))]
    traces: u32,
    /// Seed
    #[arg(long, default_value_t = 1)]
    seed: u16,
    /// Also write the model of the first draw (model.bwm, model.rs) and one held-out trace of each class as converter
    /// counts (held_out.bin, for the firmware example) into this folder
    #[arg(long, value_name = "DIR")]
    model: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A method with its errors over the repetitions.
struct Row {
    name: &'static str,
    published: &'static str,
    mean: f64,
    /// Nothing from one draw.
    sd: Option<f64>,
}

impl Row {
    fn error(&self) -> String {
        match self.sd {
            Some(sd) => format!("{:.1} ± {sd:.1}", self.mean),
            None => format!("{:.1}", self.mean),
        }
    }
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let settings = Settings { repetitions: args.repetitions, traces: args.traces, seed: u32::from(args.seed) };
    let model_files =
        args.model.as_ref().map(|folder| ["model.rs", "model.bwm", "held_out.bin"].map(|f| folder.join(f)));
    if let Some(folder) = &args.model {
        std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    }
    let outputs: Vec<&Path> = model_files.iter().flatten().map(PathBuf::as_path).chain([args.out.as_path()]).collect();
    output::plan(&outputs, &[])?;
    let count = settings.repetitions * settings.traces * 2 * demo::CLASSES.len() as u32;
    let bar = output::progress("simulating", count as usize);
    let first = demo::draw(&settings, 0, || bar.inc(1))?;
    let mut repetitions = vec![first.repetition.clone()];
    for k in 1..settings.repetitions {
        repetitions.push(demo::draw(&settings, k, || bar.inc(1))?.repetition);
    }
    bar.finish_and_clear();
    let rows = rows(&repetitions);
    let page = page(&settings, &first, &rows)?;
    let contents = model_contents(&first)?;
    let mut files = vec![(args.out.as_path(), page.as_bytes())];
    files.extend(model_files.iter().flatten().map(PathBuf::as_path).zip(contents.iter().map(Vec::as_slice)));
    output::write_all(&files)?;
    if args.json { print_json(&first, &rows) } else { print(&settings, &first, &rows, args) }
}

/// The model as Rust and binary, and its recording.
fn model_contents(first: &Draw) -> Result<[Vec<u8>; 3], Error> {
    let lines = ["Standard DC-motor rig: y = current, u1 = velocity reference, u2 = load torque.".to_string()];
    let notes = Notes::new(&channels(), Preparation::NONE, (&first.trained.feature_names, vec![]), &first.training);
    Ok([
        export::rust_source(&first.trained, &lines)?.into_bytes(),
        first.trained.to_bytes(&notes.to_text())?,
        converter_counts(first),
    ])
}

/// One held-out trace of each class as a converter over the model's range would give it: y, u1, u2 as `i16`,
/// little-endian, limit · count / 2¹⁵.
fn converter_counts(first: &Draw) -> Vec<u8> {
    let mut bytes = Vec::new();
    for class in 0..demo::CLASSES.len() {
        let Some(held_out) = first.validation.iter().find(|t| t.class == class) else { continue };
        let trace = &held_out.trace;
        for k in 0..trace.y.len() {
            for (x, limit) in
                [trace.y[k], trace.u1[k], trace.u2[k]].into_iter().zip(first.trained.regression.guard.limit)
            {
                let count = (x / f64::from(limit) * 32_768.0).round() as i16;
                bytes.extend(count.to_le_bytes());
            }
        }
    }
    bytes
}

fn channels() -> Channels {
    Channels::new("current_a", "velocity_ref_rad_s", "load_torque_nm")
}

fn rows(repetitions: &[Repetition]) -> Vec<Row> {
    let row = |name, published, error: fn(&Repetition) -> f64| {
        let (mean, sd) = demo::mean_sd_percent(&repetitions.iter().map(error).collect::<Vec<_>>());
        Row { name, published, mean, sd: (repetitions.len() > 1).then_some(sd) }
    };
    vec![
        row("embedded: LS, all of a b c, LDA", "–", |r| r.all_parameters.error_rate().value),
        row("embedded: torque balance and bearing order, QDA", "–", |r| r.shaft.error_rate().value),
        row("embedded: LS, a only, PCA 2, LDA", "–", |r| r.a_only.error_rate().value),
        row("source: iv4, a only, PCA 2, LDA of 3 classes", "–", |r| r.literal.all_classes.error_rate().value),
        row("source: the same, two binary LDAs", "28.3 (Table 4.1)", |r| r.literal.binary_error()),
    ]
}

fn print(settings: &Settings, first: &Draw, rows: &[Row], args: &Args) -> Result<(), Error> {
    let Settings { repetitions, traces, .. } = *settings;
    output::say(format!(
        "Standard DC-motor rig, y = current, u1 = velocity reference, u2 = load torque, order 2,1,2,1,1;\n\
         {traces} + {traces} traces a class (training + validation), every trace simulated from its own seed.\n"
    ))?;
    output::say("First draw, validation traces through the embedded detector (LS, all of a b c, LDA):")?;
    output::say(format!("{}\n", first.repetition.all_parameters))?;
    output::say(format!(
        "The same traces by the source's method (iv4, a only, PCA 2, LDA; healthy fit {:.1} %, published 86.58 %):",
        first.repetition.literal.fit_percent
    ))?;
    output::say(format!("{}\n", first.repetition.literal.all_classes))?;
    output::say(format!("Validation error over {repetitions} draws, %:            mean ± sd   published"))?;
    for row in rows {
        output::say(format!("  {:46} {:>12}   {}", row.name, row.error(), row.published))?;
    }
    output::say(
        "With na = 2 a PCA to two components is an invertible map, which cannot change a linear discriminant.",
    )?;
    output::say(format!("\nPlots: {}", args.out.display()))
}

fn print_json(first: &Draw, rows: &[Row]) -> Result<(), Error> {
    let methods: Vec<_> = rows
        .iter()
        .map(|row| json!({ "method": row.name, "error_percent_mean": row.mean, "error_percent_sd": row.sd }))
        .collect();
    output::json(&json!({
        "first_draw": first.repetition.all_parameters.to_json(),
        "first_draw_literal": first.repetition.literal.all_classes.to_json(),
        "methods": methods,
    }))
}

fn page(settings: &Settings, first: &Draw, rows: &[Row]) -> Result<String, Error> {
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
        .lead(format!(
            "DC motor under velocity control; y = current, u1 = velocity reference, u2 = load torque; order [2 1 2 1 1]. \
             {traces} + {traces} traces a class, seeds from {seed}; every verdict is the embedded detector's."
        ))
        .section("Result of the first draw", &pages::confusion_html(&first.repetition.all_parameters))
        .section("The source's method on the same traces", &pages::confusion_html(&first.repetition.literal.all_classes))
        .section("All draws", &methods)
        .section("Signals of each class", &signals(&classes, &examples))
        .section("Features and decision regions", &pages::scatter(&first.trained, &first.verdicts)?)
        .section("Posteriors over time: one held-out trace after another", &pages::posteriors_by_trace(&classes, &first.verdicts))
        .section("Posteriors over time: while a segment fills", &filling(first, &examples)?);
    Ok(page.render())
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

/// The posterior the detector would give if the segment ended at each time.
fn filling(first: &Draw, examples: &[(&Trace, usize)]) -> Result<String, Error> {
    const STEP: usize = 50;
    let classes = Class::all(&demo::class_names());
    let mut html = paragraph(
        "Preview of the open segment every 0.1 s; the model is trained on whole segments of 10 s, so early posteriors are overconfident.",
    );
    for &(trace, truth) in examples {
        let step = trace.interval_s.unwrap_or(1.0);
        let previews = first.model.previews(trace, STEP).map_err(|e| Error::Usage(e.to_string()))?;
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
