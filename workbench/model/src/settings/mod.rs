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

mod alarm;
mod bearing;
mod choices;
mod classifier;
mod columns;
mod data;
mod defaults;
mod estimation;
mod face;
mod fields;
mod file;
mod geometry;
mod lenient;
mod life;
mod merge;
mod model;
mod odds;
mod order;
mod problem;
mod reading;
mod recipe;
mod saved;
#[cfg(feature = "schema")]
pub mod schema;
mod shaft;
mod signals;
mod uses;
mod validation;
mod whole;

pub use alarm::{Alarm, HEALTHY_NAMES, healthy_class};
pub use bearing::Bearing;
pub use choices::{Discriminant, Method, Novelty, Park, Projection, VelocityFrom};
pub use data::Data;
pub use fields::{Section, keys, sections};
pub use file::DriveFile;
pub use geometry::{Dimensions, Geometry};
pub use lenient::from_value;
pub use life::WantedLife;
pub use model::Model;
pub use order::Order;
pub use problem::{Problem, Refused};
pub use reading::Reading;
pub use saved::{from_here, literal};
pub use signals::Signals;
pub use uses::{CHANNELS, Further, PREPARATION, TIMES, Use};
pub use validation::Validation;
pub use whole::Settings;
