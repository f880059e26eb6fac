//! Training and evaluation as functions: settings, labels and a source of traces come in; a model, its report and
//! warnings go out. Nothing is printed, and no file format is named.
//!
//! ```text
//! Settings ─┐                    ┌─ Training ─► Found, lines, JSON
//! Given ────┼─► Session::train ──┤
//! Log ──────┘                    └─ bytes of a model ─► ModelFile ─► Evaluation
//! ```

mod doubts;
mod evaluation;
mod judging;
mod log;
mod model_file;
pub(crate) mod notes;
mod selection;
mod source;
mod training;

pub use doubts::{
    codes, contradictory, irregular, is_irregular, of_irregular, refuse_gaps, refuse_held, refuse_scale, refused,
};
pub use evaluation::{Evaluation, Findings, Judging, JudgingOptions};
pub use judging::{check_rate, judge, prepare};
pub use log::{Log, Progress, Quiet, Steps};
pub use model_file::ModelFile;
pub use notes::Notes;
pub use selection::{Chosen, Groups, Selection};
pub use source::{Given, Piece, TemperatureColumn, TraceSource};
pub use training::{Found, HeldOut, Session, Training, description, lines, read_by, rust_source, to_json};
