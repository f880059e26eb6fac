//! Training as a function: settings, labels and traces come in; a model with its report goes out.

mod chosen;
pub mod description;
pub(crate) mod evidence;
mod held_out;
mod precision;
mod report;
mod saved;
mod temperatures;
pub(crate) mod training;
mod training_session;

pub use held_out::{Found, HeldOut};
pub use report::{lines, to_json};
pub use training::{Training, read_by, rust_source};
pub use training_session::Session;
