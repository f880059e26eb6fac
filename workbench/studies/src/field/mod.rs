//! The table of the field: what the detector finds if one effect of the field, or all of them, act on the rig.
//!
//! A row is a condition ([`Condition::FIELD`](rig::Condition::FIELD), each on top of MIX). For each draw a gate
//! is trained on healthy records of this condition alone, with one recipe for all rows, and judged on other records:
//! false alarms on healthy ones, detected records of each size of a defect. Some rows also have the error of a
//! discriminant of three classes, trained with defects at full size. Every verdict is that of the core in single
//! precision.
//!
//! | module | content |
//! |---|---|
//! | [`picture`] | the table as a picture |
//! | [`recipe`] | the configuration: features, false-alarm rate |
//! | [`rows`] | conditions, defects, and the cells of their traces |
//! | [`settings`] | draws, and records of each |
//! | [`run`] | one draw of one row |
//! | [`tally`] | counts, and rates with intervals |
//! | [`limits`] | defects at the limit that a healthy verdict states |
//! | [`delay`] | hours between false alarms and runs until the alarm |
//! | [`growth`] | size of a growing defect and the time left, beside the truth |
//! | [`render`] | the table as text, rows and JSON |

pub mod delay;
pub mod growth;
pub mod limits;
pub mod picture;
pub mod recipe;
pub mod render;
pub mod rows;
pub mod run;
pub mod settings;
pub mod tally;

use model::Error;
use rows::Row;
use run::Draw;

pub use settings::Settings;

/// A row with its draws.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// The row.
    pub row: Row,
    /// One result for each draw.
    pub draws: Vec<Draw>,
}

/// Runs the study; `done` is called once per row and draw.
///
/// # Errors
/// Returns an error if simulation fails. If training refuses a set, its draw has the reason.
pub fn study(rows: &[Row], settings: &Settings, done: impl Fn()) -> Result<Vec<Findings>, Error> {
    let each = |row: &Row| {
        let draws = (settings.first..settings.first + settings.draws).map(|number| {
            let found = run::draw(row, number, settings);
            done();
            found
        });
        Ok(Findings { row: *row, draws: draws.collect::<Result<_, _>>()? })
    };
    rows.iter().map(each).collect()
}
