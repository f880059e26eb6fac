//! Recorded or simulated signals in memory: traces, their channels, labels and preparation.

mod column_names;
pub mod front_end;
mod gaps;
pub mod labels;
mod median;
mod names;
pub mod prepare;
mod record;
mod recorded;
pub mod tally;
mod text_form;

pub use column_names::{is_reference, words};
pub use front_end::FrontEndFile;
pub use gaps::{BREAK, Gap, LONGEST_GAP, gaps};
pub use labels::{Condition, Labels};
pub use median::median;
pub use names::{TraceNames, composed, extensions, file_name, is_known, stem, trace_name};
pub use prepare::Preparation;
pub use record::{Channels, MotionTrace, ShaftChannels, Trace, bridged, same_interval};
pub use recorded::{Cells, Recorded, Times};
pub use tally::{Missing, Tally};
pub use text_form::{Decimal, Separator, TextForm};
