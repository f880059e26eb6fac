//! The core's refusal of a trained model, as an error of training.

use bearing_watch::ModelError;

use crate::Error;

pub(super) fn refused(error: ModelError) -> Error {
    Error::Training(format!("the trained model cannot be embedded: {error}"))
}
