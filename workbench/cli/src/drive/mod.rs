//! Commands on what a drive does: recordings through its detector, what it sends, and what it accepts.

pub(crate) mod can_id;
pub(crate) mod dbc;
pub(crate) mod demo;
pub(crate) mod life;
pub(crate) mod listen;
pub(crate) mod replay;
pub(crate) mod signing;
