//! Decisions of many segments → [`Alarm`](crate::Alarm) with its cause, and what is kept from one segment to the next.
//!
//! Enters: a decision, or the reason why there is none, once a segment. Leaves: alarm, trend, growth and silence; on
//! request, a healthy class that follows the drive.
//!
//! ```text
//! evidence        decisions of segments, runs ─► Alarm          trend, silence   growth; segments without a verdict
//! baseline        follows slow changes of a healthy drive       commissioning    learns the healthy class on the drive
//! growth          size of a defect, and time left
//! ```

pub(crate) mod baseline;
pub(crate) mod commissioning;
pub(crate) mod evidence;
mod growth;
mod runs;
mod silence;
mod state_error;
pub(crate) mod trend;

pub use baseline::Baseline;
pub use commissioning::CommissioningError;
pub use growth::{Growth, Interval};
pub use runs::Contribution;
pub use silence::{Silence, SilenceLimits};
pub use state_error::StateError;
pub use trend::Trend;

pub(crate) use commissioning::{CommissioningConstants, HealthyClass};
pub(crate) use evidence::{Evidence, EvidenceConstants};
