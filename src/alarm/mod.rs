//! Decisions of many segments → [`Alarm`](crate::Alarm) with its cause, and what is kept from one segment to the next.
//!
//! Enters: a decision, or the reason why there is none, once a segment. Leaves: alarm, growth and silence.
//!
//! ```text
//! evidence        decisions of segments, runs ─► Alarm          silence    segments without a verdict
//! growth          size of a defect, and time left
//! ```

pub(crate) mod evidence;
mod growth;
mod runs;
mod silence;
mod state_error;

pub use growth::{Contribution, Growth, Interval};
pub use silence::{Silence, SilenceLimits};
pub use state_error::StateError;

pub(crate) use evidence::{Evidence, EvidenceConstants};
