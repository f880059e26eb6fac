//! What an audit finds.

use model::audit::column::Column;
use model::audit::friction::Excited;
use model::audit::times::Times;

/// One trace: its columns by name, and the channels that were chosen.
pub(super) struct Audited {
    pub(super) id: String,
    pub(super) names: Vec<String>,
    pub(super) times: Option<Times>,
    pub(super) times_s: Option<Vec<f64>>,
    pub(super) columns: Vec<Column>,
    pub(super) values: Vec<Vec<f64>>,
    pub(super) current: Option<Vec<f64>>,
    pub(super) velocity: Option<Vec<f64>>,
    pub(super) angle: Option<Vec<f64>>,
    pub(super) velocity_ref: Option<Vec<f64>>,
    pub(super) load: Option<Vec<f64>>,
}

/// A finding, and the traces that have it.
pub(super) struct Finding {
    pub(super) what: String,
    pub(super) traces: Vec<String>,
}

/// All that was found in some files.
pub(super) struct Outcome {
    pub(super) traces: Vec<Audited>,
    pub(super) findings: Vec<Finding>,
    /// The rate by the lines of the rotor.
    pub(super) rotor: Option<f64>,
    pub(super) lines: Vec<Line>,
    /// The smallest change of each term of friction.
    pub(super) terms: Vec<Excited>,
}

/// Lines of orders in one trace, in the unit of the signal.
pub(super) struct Line {
    pub(super) trace: String,
    pub(super) turns: f64,
    pub(super) floor: f64,
    pub(super) smallest: f64,
    /// The line of order 1.
    pub(super) first: f64,
}
