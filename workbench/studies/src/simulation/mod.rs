//! Sets of simulated traces: what is simulated, as a plain struct, and the traces.

mod conditions;
mod dc;
mod ema;
mod experiment;
mod names;
mod options;
mod set;

pub use experiment::{Simulated, Table};
pub use options::{Rig, Simulation};
pub use set::Set;
