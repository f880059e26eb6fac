//! What an audit finds.

use std::sync::Arc;

use crate::turning::Turning;
use model::audit::column::Column;
use model::audit::friction::Excited;
use model::audit::times::Times;
use model::trace::Missing;
use model::train::Weight;

/// One trace: its columns by name, and the channels that were chosen.
#[derive(Debug)]
pub struct Audited {
    /// Its name.
    pub id: String,
    /// Names of its columns of numbers.
    pub names: Vec<String>,
    /// What was left out of its file, or guessed, a sentence each.
    pub left_out: Vec<String>,
    /// Its rate and gaps, if it has a time.
    pub times: Option<Times>,
    /// The time of each row, s.
    pub times_s: Option<Vec<f64>>,
    /// What is missing: rows by the time, and rows that lack a channel; of a trace without one, all of its columns.
    pub missing: Missing,
    /// What is found in each column.
    pub columns: Vec<Column>,
    /// The values of each column.
    pub values: Vec<Arc<Vec<f64>>>,
    /// The current: a column as it is, or computed. In the channels the last value stands for a missing one.
    pub current: Option<Arc<Vec<f64>>>,
    /// The velocity, rad/s.
    pub velocity: Option<Arc<Vec<f64>>>,
    /// The angle of the shaft, rad.
    pub angle: Option<Arc<Vec<f64>>>,
    /// What tells their units, and how they contradict each other.
    pub(super) turning: Turning,
    /// The reference of the velocity.
    pub velocity_ref: Option<Arc<Vec<f64>>>,
    /// The load.
    pub load: Option<Arc<Vec<f64>>>,
}

impl Audited {
    /// The values of each column.
    #[must_use]
    pub fn signals(&self) -> Vec<&[f64]> {
        self.values.iter().map(|own| own.as_slice()).collect()
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.first().map_or(0, |own| own.len())
    }

    /// What is missing in a trace with these columns and channels.
    pub(super) fn missing(times: Option<&Times>, columns: &[Arc<Vec<f64>>], channels: &[Arc<Vec<f64>>]) -> Missing {
        let rows = columns.first().map_or(0, |own| own.len());
        let lacks = |row: &usize| match channels {
            [] => columns.iter().all(|own| own[*row].is_nan()),
            _ => channels.iter().any(|own| own[*row].is_nan()),
        };
        let dropped = times.map_or(0, |times| times.missing);
        Missing { samples: rows + dropped, dropped, empty: (0..rows).filter(lacks).count(), ..Missing::default() }
    }
}

/// A finding, and the traces that have it.
#[derive(Debug)]
pub struct Finding {
    /// What was found.
    pub what: String,
    /// The traces.
    pub traces: Vec<String>,
}

/// All that was found in some files.
#[derive(Debug)]
pub struct Outcome {
    /// The traces.
    pub traces: Vec<Audited>,
    /// What is wrong.
    pub findings: Vec<Finding>,
    /// The rate by the lines of the rotor.
    pub rotor: Option<f64>,
    /// Lines of orders.
    pub lines: Vec<Line>,
    /// The smallest change of each term of friction.
    pub terms: Vec<Excited>,
    /// The weight on an axis, where no load is measured.
    pub weight: Option<Weight>,
}

/// Lines of orders in one trace, in the unit of the signal.
#[derive(Debug)]
pub struct Line {
    /// The trace.
    pub trace: String,
    /// Turns of the shaft.
    pub turns: f64,
    /// The level of the noise.
    pub floor: f64,
    /// The smallest line that stands out.
    pub smallest: f64,
    /// The line of order 1.
    pub first: f64,
}
