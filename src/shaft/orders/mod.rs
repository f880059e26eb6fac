//! Motion and residual → strength and slip of each order of a bearing.
//!
//! Enters: the angle, and the signals and present parameters of [`super::balance`]. Leaves: an [`OrderStrength`] for
//! each order.
//!
//! ```text
//! bearing     orders from the geometry            blocks   orders to track, cells of the angle
//! residual    the residual, whitened ─► tracking ─► line: block phasors and their products ─► slip
//!                                         └─ noise: the control orders ───────────────────────▲
//! sight       the smallest defect that a segment shows
//! ```

mod bearing;
mod blocks;
mod line;
mod noise;
mod phasor;
mod residual;
mod response;
mod sight;
mod slip;
mod tracking;

pub use bearing::Bearing;
pub use blocks::{Blocks, CONTROLS, LAGS, TrackedOrder, Tracking, q16};
pub(crate) use blocks::{MAX_BLOCKS, least_steps};
pub use slip::OrderStrength;
pub(super) use {
    noise::NoiseLine,
    phasor::phasor,
    residual::{Residual, ResidualState},
    slip::{Search, SlipRange},
    tracking::{OrderSums, OrderTracking, Taken},
};
