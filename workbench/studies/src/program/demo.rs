//! `bearing-watch-studies demo`, which is `cargo demo`.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use model::Error;
use model::outputs;
use model::session::{Notes, Progress as _};
use model::trace::{Channels, Preparation, stem};
use model::train::c_header::c_header;
use model::train::export;

use super::output::{self, Output};
use bearing_watch_studies::demo::{CLASSES, Draw, Row, Settings, draw, rows};
use bearing_watch_studies::pages::demo::page;

/// The whole chain on the simulated standard rig: traces, training, verdicts of the embedded detector, plots
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch-studies demo --out demo.html")]
pub(crate) struct Args {
    /// The page with the plots
    #[arg(long, value_name = "FILE", default_value = "bearing-watch-demo.html")]
    out: PathBuf,
    /// Number of draws of training and validation sets
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repetitions: u32,
    /// Traces per class, in training and again in validation
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(8..=1000))]
    traces: u32,
    /// Seed
    #[arg(long, default_value_t = 1)]
    seed: u16,
    /// Also write the model of the first draw (model.bwm, model.rs, model.h) and one held-out trace of each class as
    /// converter counts (held_out.bin, for the firmware example) into this folder
    #[arg(long, value_name = "DIR")]
    model: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Simulates, trains, evaluates, and writes the page and the files of the model.
pub(crate) fn run(args: &Args, output: Output) -> Result<(), Error> {
    let settings = Settings { repetitions: args.repetitions, traces: args.traces, seed: u32::from(args.seed) };
    let model_files =
        args.model.as_ref().map(|folder| ["model.rs", "model.h", "model.bwm", "held_out.bin"].map(|f| folder.join(f)));
    if let Some(folder) = &args.model {
        std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    }
    let outputs: Vec<&Path> = model_files.iter().flatten().map(PathBuf::as_path).chain([args.out.as_path()]).collect();
    outputs::plan(&outputs, &[])?;
    let count = settings.repetitions * settings.traces * 2 * CLASSES.len() as u32;
    let done = output.start("simulating", count as usize);
    let first = draw(&settings, 0, || done(1))?;
    let mut repetitions = vec![first.repetition.clone()];
    for k in 1..settings.repetitions {
        repetitions.push(draw(&settings, k, || done(1))?.repetition);
    }
    drop(done);
    let rows = rows(&repetitions);
    let page = page(&settings, &first, &rows)?;
    let contents = model_contents(&first)?;
    let mut files = vec![(args.out.as_path(), page.as_bytes())];
    files.extend(model_files.iter().flatten().map(PathBuf::as_path).zip(contents.iter().map(Vec::as_slice)));
    outputs::write_all(&files)?;
    if args.json {
        return output::json(&to_json(&first, &rows));
    }
    lines(&settings, &first, &rows, &args.out).iter().try_for_each(output::say)
}

/// Returns the model as Rust source, as C header and in binary form, and the recording of held-out traces.
fn model_contents(first: &Draw) -> Result<[Vec<u8>; 4], Error> {
    let lines = ["Standard DC-motor rig: y = current, u1 = velocity reference, u2 = load torque.".to_string()];
    let ids = first.training.iter().map(|t| stem(&t.trace.id).to_string()).collect();
    let notes = Notes::new(&channels(), Preparation::NONE, &first.trained, (ids, &[]), None);
    Ok([
        export::rust_source(&first.trained, &lines)?.into_bytes(),
        c_header(&first.trained.to_core()?, (&lines, &notes.orders), None, None)?.into_bytes(),
        first.trained.to_bytes(&notes.to_text())?,
        converter_counts(first),
    ])
}

/// Returns one held-out trace of each class as counts of a converter whose range is that of the model's channels: y,
/// u1, u2 as `i16`, little-endian; value = limit · count / 2¹⁵.
fn converter_counts(first: &Draw) -> Vec<u8> {
    let mut bytes = Vec::new();
    for class in 0..CLASSES.len() {
        let Some(held_out) = first.validation.iter().find(|t| t.class == class) else { continue };
        let trace = &held_out.trace;
        for k in 0..trace.y.len() {
            let values = [trace.y[k], trace.u1[k], trace.u2[k]].into_iter();
            for (x, channel) in values.zip(&first.trained.parts.channels) {
                let count = (x / f64::from(channel.limit) * 32_768.0).round() as i16;
                bytes.extend(count.to_le_bytes());
            }
        }
    }
    bytes
}

fn channels() -> Channels {
    Channels::new("current_a", "velocity_ref_rad_s", "load_torque_nm")
}

fn lines(settings: &Settings, first: &Draw, rows: &[Row], page: &Path) -> Vec<String> {
    let Settings { repetitions, traces, .. } = *settings;
    let mut lines = vec![
        format!(
            "Standard DC-motor rig, y = current, u1 = velocity reference, u2 = load torque, order 2,1,2,1,1;\n\
             {traces} + {traces} traces a class (training + validation), every trace simulated from its own seed.\n"
        ),
        "First draw, validation traces through the embedded detector (LS, all of a b c, LDA):".into(),
        format!("{}\n", first.repetition.all_parameters),
        format!(
            "The same traces by the source's method (iv4, a only, PCA 2, LDA; healthy fit {:.1} %, published 86.58 %):",
            first.repetition.literal.fit_percent
        ),
        format!("{}\n", first.repetition.literal.all_classes),
        format!("Validation error over {repetitions} draws, %:            mean ± sd   published"),
    ];
    lines.extend(rows.iter().map(|row| format!("  {:46} {:>12}   {}", row.name, row.error(), row.published)));
    lines.push(
        "With na = 2 a PCA to two components is an invertible map, which cannot change a linear discriminant.".into(),
    );
    lines.push(format!("\nPlots: {}", page.display()));
    lines.push(
        "To damage a simulated drive and see its alarm in a browser: cargo xtask web, then open its page.".into(),
    );
    lines
}

fn to_json(first: &Draw, rows: &[Row]) -> Value {
    let methods: Vec<_> = rows
        .iter()
        .map(|row| json!({ "method": row.name, "error_percent_mean": row.mean, "error_percent_sd": row.sd }))
        .collect();
    json!({
        "first_draw": first.repetition.all_parameters.to_json(),
        "first_draw_literal": first.repetition.literal.all_classes.to_json(),
        "methods": methods,
    })
}
