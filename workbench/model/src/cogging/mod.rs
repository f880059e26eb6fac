//! What turns with the rotor, from recordings: cogging, ripple of the torque constant, unbalance.
//!
//! ```text
//! recordings ─► residual: torque balance of each ─► lines: waves of the angle ─┬─► map: current at each angle
//!                                                                              └─► since: what has changed
//! ```

mod change;
mod lines;
mod map;
mod residual;
mod since;
mod usable;
mod wave;

pub use change::{RotorChange, RotorLimits, RotorLine};
pub use lines::{Line, Lines, LinesSettings, fit, fit_of};
pub use map::{MapPoint, map, odrive};
pub use residual::{Recording, Residual, residuals};
pub use since::{since, told};
pub use wave::Wave;
