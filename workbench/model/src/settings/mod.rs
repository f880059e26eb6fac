//! Settings: what is trained and judged, and how, as plain structs.
//!
//! ```text
//! drive.toml ──── file ──┐
//! command line ─ words ──┼─► Settings ─► channels, plan of the shaft, recipe of the training
//! Python ─────── values ─┘
//! ```
//!
//! A face sets the fields that a user gives, by name, with the value as he writes it ([`Settings::set`]); none of the
//! three passes another one. [`Settings::over`] puts one face over another one. Defaults are those of the conversions.
//!
//! The text of a field is its help on the command line and its description in the schema of a drive file.

pub(crate) mod conversions;
pub(crate) mod faces;
pub(crate) mod sections;
mod uses;

pub use conversions::{Reading, WantedLife};
#[cfg(feature = "schema")]
pub use faces::schema;
pub use faces::{DriveFile, Problem, Refused, Section, from_here, from_value, keys, literal, sections};
pub use sections::{
    Alarm, Bearing, Data, Dimensions, Discriminant, Geometry, HEALTHY_NAMES, Method, Model, Novelty, Order, Park,
    Projection, Settings, Signals, Validation, VelocityFrom, healthy_class,
};
pub use uses::{CHANNELS, Further, PREPARATION, TIMES, Use};
