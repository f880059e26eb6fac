//! Commands that train models, and judge them.

pub(crate) mod confirm;
pub(crate) mod evaluate;
pub(crate) mod fleet;
pub(crate) mod train;
