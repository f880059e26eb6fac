//! The bridge to the core: traces run through its detector, the code that firmware runs.
//!
//! ```text
//! bytes of a model ─► embedded ─► smallest capacity that holds it (choice: rows and sums)
//! trace ─► motion: samples ─► detector ─► segment: SegmentReport (words: reasons) ─► watch: evidence, alarm
//! features: names of the features, and the maps between raw and δ-parameters
//! ```

mod choice;
mod embedded;
pub mod features;
mod motion;
mod segment;
mod watch;
mod words;

pub(crate) use embedded::with_room;
pub use embedded::{Embedded, MAX_COLUMNS};
pub use motion::MAX_ORDERS;
pub use segment::{Finding, SegmentReport};
pub use watch::Watched;
pub use words::{denied, stuck_signals};
