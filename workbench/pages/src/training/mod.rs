//! Pages of a trained model: what training chose, how good it is, and what it says of labelled traces.

mod chosen;
pub mod evaluation;
mod trained;
pub mod worth;

pub use trained::{Worth, confusion_html, distributions, over_runs, posteriors_by_trace, scatter, signals, training};
