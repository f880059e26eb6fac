//! Training and evaluation as functions: settings, labels and a source of traces come in; a model, its report and
//! warnings go out. Nothing is printed, and no file format is named.
//!
//! ```text
//! Settings ─┐                    ┌─ Training ─► Found, lines, JSON
//! Given ────┼─► Session::train ──┤
//! Log ──────┘                    └─ bytes of a model ─► ModelFile ─► Evaluation
//! ```

mod chosen;
mod contents;
pub mod description;
mod doubts;
mod evaluation;
mod evidence;
mod found;
mod given;
mod held_out;
mod judging;
mod log;
mod model_file;
mod notes;
mod precision;
mod saved;
mod selection;
mod sources;
mod temperatures;
mod training;
mod training_session;
mod training_traces;
mod words;

pub use doubts::{
    codes, contradictory, irregular, is_irregular, of_irregular, refuse_gaps, refuse_held, refuse_scale, refused,
};
pub use evaluation::{Evaluation, Judging, JudgingOptions};
pub use found::Findings;
pub use given::{Given, Piece, TemperatureColumn, TraceSource};
pub use held_out::{Found, HeldOut};
pub use judging::{check_rate, judge, prepare};
pub use log::{Log, Progress, Quiet, Steps};
pub use model_file::ModelFile;
pub use notes::Notes;
pub use selection::{Chosen, Groups, Selection};
pub use sources::{read_by, rust_source};
pub use training::Training;
pub use training_session::Session;
pub use words::{lines, to_json};
