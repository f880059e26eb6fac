//! The source's tables on the standard rig, beside the published figures.
//!
//! ```text
//! seed ─► draw: traces, estimates (shared) ─► distributions 2.2, chapter3, chapter4, pieces ─► Table, a value a cell
//!         once a repetition                   ours: the one place that knows our method          │ absorb
//!         published: as printed                                       words ─► render, page ◄────┘ mean ± sd
//! ```
//!
//! A repetition draws a training and a validation set; no trace is ever shared between sets. Deviations are those of
//! one repetition, not of the mean: the source made one.

mod chapter3;
mod chapter4;
mod chapter4_words;
mod distributions;
pub mod draw;
pub mod ours;
mod overview;
mod pieces;
pub mod published;
pub mod render;
pub mod result;
mod separation;
pub mod words;

use crate::Error;
use crate::study::demo;
use draw::Draw;
pub use result::{Cell, Statistic, Table};

/// The tables there are, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Id(&'static str);

impl Id {
    /// All of them.
    pub const ALL: [Self; 8] =
        [Self("2.2"), Self("3.1"), Self("3.2"), Self("4.1"), Self("4.2"), Self("4.3"), Self("4.4"), Self("piecewise")];

    /// Reads a number.
    ///
    /// # Errors
    /// Says which tables there are.
    pub fn parse(text: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|id| id.0 == text.trim());
        let names = Self::ALL.map(|id| id.0).join(", ");
        known.ok_or_else(|| format!("there is no table \"{text}\"; there are {names}"))
    }

    /// As it is written.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.0
    }
}

/// What is reproduced.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Draws of training and validation sets.
    pub repetitions: u32,
    /// Repetition r trains on set `seed` + 2r and validates on set `seed` + 2r + 1.
    pub seed: u32,
    /// Tables, in the order they are shown.
    pub tables: Vec<Id>,
}

impl Settings {
    /// Steps of which [`run`] tells.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.repetitions as usize * (self.tables.len() + 1)
    }

    fn sets(&self, repetition: u32) -> (u32, u32) {
        demo::Settings { repetitions: self.repetitions, traces: 0, seed: self.seed }.sets(repetition)
    }
}

/// Makes the tables; `done` is called once a step.
///
/// Repetitions follow one another, and each uses every core over its traces: memory stays that of one draw.
///
/// # Errors
/// Where a trace cannot be simulated or estimated, or features are singular.
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
        table.words = words::of(table);
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
