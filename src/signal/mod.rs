//! What the rest of the core takes from samples: angles and frames, the gate, and means.
//!
//! Enters: samples of any source, or the vectors and angles of [`crate::drive`]. Leaves: usable channels, means of
//! channels over a segment, means of blocks, and the check of velocity against angle.
//!
//! ```text
//! angle, frame   binary angles; Clarke and Park with its sign convention
//! counts_per_turn
//!                counts of an encoder with any number a turn
//! channel, gate  names and plausible values; which channels of a sample may be used
//! average        mean and root mean square of channels over a segment
//! block_mean     means of successive samples
//! rate           rows against a clock
//! travel         the velocity against the angle
//! ```

mod angle;
pub mod average;
mod block_mean;
mod channel;
mod counts_per_turn;
mod frame;
mod gate;
mod liveness;
mod rate;
mod travel;

pub(crate) use angle::RAD;
pub use angle::{Angle, SinCos};
pub use average::Average;
pub use block_mean::BlockMean;
pub use channel::{Channel, Label, Name, limit, read};
pub use counts_per_turn::EncoderCounts;
pub use frame::{Abc, AlphaBeta, Dq0, Park};
pub use gate::{ChannelSet, Counts, Gate};
pub use liveness::{Liveness, LivenessLimits, Stage};
pub use rate::RateCheck;
pub use travel::{Travel, TravelSums};
