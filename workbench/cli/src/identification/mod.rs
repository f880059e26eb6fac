//! Commands that estimate models of single traces.

pub(crate) mod cogging;
pub(crate) mod fit;
pub(crate) mod grey_box;
pub(crate) mod identify;
pub(crate) mod structure;
pub(crate) mod validate;
