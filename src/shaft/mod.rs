//! The shaft: motion → friction and bearing orders.
//!
//! Enters: current, velocity, load and angle of each sample. Leaves: [`Friction`] and an [`OrderStrength`] for each
//! order, once a segment, in a [`ShaftEstimate`].
//!
//! ```text
//! sample ─► common delay ─► torque balance: filters, rows ─► present parameters ─────► Friction
//!    │                        └─ residual, whitened ◄─┘ ──► products of blocks ─► OrderStrength
//!    └ angle ─► common delay ──────────────────────────────▲
//! ```
//!
//! A plan takes a step at each sample, or at each second one, behind a half-band filter of the signals
//! ([`ShaftLayout::decimation`](crate::plan::ShaftLayout::decimation)): half of the work where the orders are far below
//! the sampling rate, with less of the noise of fast signals. The sample between two steps adds the orders.
//!
//! Sensors lag behind the angle: the current because of its filter and conversion, the velocity if it is the filtered
//! difference of an angle, the load because of its amplifier. [`Lags`] gives each lag in samples; all signals are
//! delayed to the slowest one. Otherwise a lag times the rate of the load would be estimated as friction. The shaft is
//! fed at every sample of the detector, whether or not the regression averages samples in blocks.
//!
//! A plan without a channel of the velocity takes it from the angle: the mean over the last interval, half a sample
//! behind the angle. The noise of a velocity channel, differentiated, is what hides small defects; the angle often has
//! less.
//!
//! A plan with a weight on an axis ([`Load::Weight`](crate::plan::Load::Weight)) turns the angle of the axis with that
//! of the motor, and its cosine and sine are the load. Until the weight is known, no order is summed.
//!
//! A sample that may not be used is replaced by the last one, and the residual pauses until only measured samples are
//! in it: one lost sample costs a few samples. After a long gap the filters start afresh; the phases of the orders
//! continue if the shaft turned less than half a turn in it.

pub(crate) mod balance;
pub(crate) mod delays;
mod estimate;
pub(crate) mod orders;
mod plausibility;
pub(crate) mod solve;
pub(crate) mod state;

pub use balance::{Friction, LoadTerms, Parameter};
pub use estimate::ShaftEstimate;
pub use orders::{Bearing, OrderStrength};

pub(crate) use balance::{LEAST_FROM_ROWS, StateVariable, TorqueBalance};
pub(crate) use delays::Lags;
pub(crate) use orders::{Blocks, MAX_BLOCKS, TrackedOrder, least_steps};
pub(crate) use solve::ShaftSolve;
pub(crate) use state::{Shaft, ShaftSums};
