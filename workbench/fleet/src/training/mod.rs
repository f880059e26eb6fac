//! Sums of parts → a model: the fit, the gate with the tails of its law, and a fingerprint.

mod errors;
mod fingerprint;
mod fit;
mod gate;
mod tails;

pub use fingerprint::fingerprint;
pub use fit::{Choice, Fit, Independent, classes};
pub use tails::{Tails, tails};
