//! Is a segment one of a class at all? The density of a class, and the gates about it.
//!
//! Enters: projected coordinates with the variances of their errors. Leaves: log-density, distance and surprise.

pub(crate) mod density;
mod direction;
mod law;
mod novelty;
pub(crate) mod rising;

pub use direction::{Background, Direction, Directions, MAX_BACKGROUND};
pub use law::{KNOTS, Law, MAX_SURPRISE};
pub use novelty::{Departure, Novelty};
pub use rising::{Fall, Most, Rise};
