//! Training from tables of features, of any number of drives, in constant memory.
//!
//! ```text
//! traces ─► core ─► part (rows: segments) ─┬─► sums ─► model
//!                   part ──────────────────┘
//! ```
//!
//! Traces, or tables of their features, enter; a model of many drives leaves.
//!
//! A [`Part`] is a Parquet file with the features of segments and the [`Plan`] of the detector that computed them. Its
//! sums by drive, run and class have twice the precision, so that the bytes of the model do not depend on the order of
//! the rows or on their parts. [`steps`] are the steps, from files to files.

mod double;
mod fold;
mod group;
mod part;
mod plan;
mod plan_files;
pub mod steps;
mod sums;
mod training;
mod writer;

pub use fold::fold;
pub use group::{Closed, Group, Level};
pub use part::{Batch, Part, RESERVED, Wanted};
pub use plan::{Origin, Plan, VERSION};
pub use plan_files::plan_file;
pub use sums::{ClassSums, MOST_FEATURES, PatternSums, Sums};
pub use training::{Choice, Fit, Independent, Tails, classes, fingerprint, tails};
pub use writer::{Row, Writer};
