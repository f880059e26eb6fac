//! The source's tables on the standard rig, compared with the published figures.
//!
//! ```text
//! seed ─► draw: traces, estimates (shared) ─► distributions 2.2, chapter3, chapter4, pieces ─► Table, a value per cell
//!         once per repetition                 ours: training and verdicts of our method          │ absorb
//!         published: as printed                                    words: notes ─► render ◄──────┘ mean ± sd
//! ```
//!
//! Each repetition draws a training and a validation set; no two sets share a trace. Standard deviations are those of
//! one repetition, not of the mean, because the source made a single draw.

mod chapter3;
mod chapter4;
mod distributions;
pub mod draw;
pub mod ours;
mod overview;
mod pieces;
pub mod published;
pub mod recorded;
pub mod render;
pub mod result;
mod separation;
mod settings;
pub mod words;

use crate::Error;
use draw::Draw;
pub use result::{Cell, Statistic, Table};
pub use settings::{Id, Settings};

/// Computes the tables; `done` is called once per step.
///
/// The repetitions run one after the other, and each uses all processor cores for its traces: only one draw is in
/// memory at a time.
///
/// # Errors
/// Returns an error if a trace cannot be simulated or estimated, or features are singular.
pub fn run(settings: &Settings, done: impl Fn()) -> Result<Vec<Table>, Error> {
    let chapter_3 = settings.tables.iter().any(|id| id.name().starts_with('3'));
    let mut all: Vec<Table> = vec![];
    for repetition in 0..settings.repetitions {
        let draw = Draw::new(settings.sets(repetition), chapter_3)?;
        done();
        let mut tables = Vec::new();
        for id in &settings.tables {
            tables.extend(measure(*id, &draw)?);
            done();
        }
        if all.is_empty() {
            all = tables;
        } else {
            all.iter_mut().zip(tables).for_each(|(table, more)| table.absorb(more));
        }
    }
    for table in &mut all {
        table.words = words::of(table).into_iter().collect();
    }
    Ok(overview::of(&all).into_iter().chain(all).collect())
}

fn measure(id: Id, draw: &Draw) -> Result<Vec<Table>, Error> {
    match id.name() {
        "2.2" => Ok(vec![distributions::first_order(draw)?, distributions::separations(draw)?]),
        "3.1" => Ok(vec![chapter3::components(draw)?]),
        "3.2" => Ok(vec![chapter3::misclassified(draw)?, chapter3::orders(draw)?]),
        "piecewise" => Ok(vec![pieces::measure(draw)?]),
        number => published::CHAPTER_4
            .iter()
            .filter(|table| table.number == number)
            .map(|table| chapter4::measure(table, draw))
            .collect(),
    }
}
