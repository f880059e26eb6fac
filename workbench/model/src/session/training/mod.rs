//! Training as a function: settings, labels and traces come in; a model with its report goes out.

mod chosen;
pub mod description;
pub(crate) mod evidence;
mod held_out;
mod precision;
mod report;
pub(crate) mod result;
mod saved;
mod temperatures;
mod training_session;

pub use held_out::{Found, HeldOut};
pub use report::{lines, to_json};
pub use result::{Training, read_by, rust_source};
pub use training_session::Session;
