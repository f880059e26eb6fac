//! Strokes of a linear actuator with seeded faults (Cranfield, 25 Hz), by load, run and state, and detectors of them.
//!
//! At full rate the cross-correlation of velocity and current near 12.5 Hz tells the acquisition set-up, not damage, so
//! everything here works on block means of four samples; sets are split by run, never by stroke.

use std::path::PathBuf;

use model::Error;
use model::evaluate::{self, TraceVerdict};
use model::trace::labels::LabelledTrace;
use model::trace::{Channels, Preparation, Trace, stem};
use model::train::{Recipe, Trained, train};
use traces::read;

use crate::data;

/// Loads that were recorded, kgf.
pub const LOADS: [&str; 3] = ["20", "40", "-40"];
/// Runs of five strokes each, of every state and load.
pub const RUNS: std::ops::RangeInclusive<usize> = 1..=7;
/// Samples to a block.
pub const BLOCK: usize = 4;

/// The states with a fault; the last [`CONTROLS`] are negative controls.
pub const FAULTS: [&str; 12] = [
    "lackLubrication1",
    "lackLubrication2",
    "backlash1",
    "backlash2",
    "spalling6",
    "spalling7",
    "spalling8",
    // What the recording's authors call undetectable: the negative controls.
    "spalling1",
    "spalling2",
    "spalling3",
    "spalling4",
    "spalling5",
];
/// Number of levels that the recording's authors call undetectable.
pub const CONTROLS: usize = 5;

/// The fault at a place of [`FAULTS`] as the documents name it.
///
/// # Panics
/// If there is none.
#[must_use]
pub fn fault_name(place: usize) -> String {
    let (fault, level) = FAULTS[place].split_at(FAULTS[place].len() - 1);
    let control = if place == FAULTS.len() - CONTROLS { "*controls:* " } else { "" };
    format!("{control}{} {level}", fault.replace("lackLubrication", "lubrication"))
}

/// One out-and-back stroke.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// As recorded.
    pub trace: Trace,
    /// Block means, for training; the detector forms its own.
    pub prepared: Trace,
    /// State of the actuator.
    pub state: String,
    /// Load, kgf.
    pub load: &'static str,
    /// Run of that state and load.
    pub run: usize,
}

/// Every stroke of one load; nothing where the recordings are absent.
///
/// # Panics
/// Where the recordings are not as published.
#[must_use]
pub fn strokes(load: &'static str) -> Option<Vec<Stroke>> {
    let folder = data("cranfield_ema")?;
    let channels = Channels::new("current_a", "velocity_mm_s", "velocity_ref_mm_s");
    let file: PathBuf = folder.join(format!("strokes_{load}kgf.csv"));
    let traces = read(&[file], &channels).expect("readable strokes");
    let labels = traces::read_labels(&folder.join("labels.csv")).expect("readable labels");
    let preparation = Preparation { block_mean: BLOCK, decimate: 1 };
    let of_run = |run: usize| {
        let conditions = [format!("load_kgf={load}"), format!("run={run}")].map(|c| c.parse().expect("condition"));
        let each = |(id, state): (String, String)| {
            let trace = traces.iter().find(|t| stem(&t.id) == id).expect("labelled and recorded").clone();
            let prepared = preparation.apply(&trace).expect("long enough");
            Stroke { trace, prepared, state, load, run }
        };
        labels.select(&conditions).expect("rows").into_iter().map(each).collect::<Vec<_>>()
    };
    Some(RUNS.flat_map(of_run).collect())
}

/// Trains on block means, with the runs as groups of the cross-validation; `class` says which of `classes` a state is.
///
/// # Errors
/// As [`train`].
pub fn detector(
    strokes: &[&Stroke],
    classes: &[String],
    class: impl Fn(&str) -> Option<usize>,
    recipe: &Recipe,
) -> Result<Trained, Error> {
    let known = strokes.iter().filter_map(|s| Some((s, class(&s.state)?)));
    let traces: Vec<_> = known.clone().map(|(s, class)| LabelledTrace { trace: s.prepared.clone(), class }).collect();
    let mut recipe = recipe.clone();
    recipe.validation.groups = known.map(|(s, _)| format!("{} {}", s.load, s.run)).collect();
    let mut trained = train(&traces, classes, &recipe)?;
    trained.block_mean = BLOCK;
    Ok(trained)
}

/// What the core says of strokes as recorded.
///
/// # Panics
/// Where the model cannot be embedded.
#[must_use]
pub fn judge(trained: &Trained, strokes: &[&Stroke], class: impl Fn(&str) -> Option<usize>) -> Vec<TraceVerdict> {
    let known = strokes.iter().filter_map(|s| Some(LabelledTrace { trace: s.trace.clone(), class: class(&s.state)? }));
    let known: Vec<_> = known.collect();
    evaluate::run(&trained.embed().expect("embeddable"), &known, || ()).expect("runs")
}
