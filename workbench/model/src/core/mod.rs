//! Interface to the core: runs traces through its detector, the code that firmware runs.
//!
//! ```text
//! columns of traces ─► wiring: channels of the model, samples
//! model: constants of any layout ─► embedded: constants, names ─► stream: detector and monitor, over traces
//!                                                                    ├─► segment: SegmentReport (words: reasons)
//!                                                                    └─► watch: the evidence after it
//! features: names of the features, and the maps between raw and δ-parameters; coordinates: those of the coordinates
//! ```

pub mod coordinates;
mod embedded;
pub mod features;
pub mod identifiers;
mod model;
mod segment;
pub mod sight;
mod stream;
mod watch;
mod wiring;
mod words;

pub use embedded::Embedded;
pub use model::{Parts, plan};
pub use segment::{Finding, SegmentReport};
pub use stream::{Judged, Stream};
pub use watch::AlarmState;
pub(crate) use watch::combined_surprise;
pub use wiring::{Field, MAX_ORDERS, Measured, ShaftSignals, Wiring, column, fields};
pub use words::{denied, stuck_channels};
