//! How settings come in and go out: by name with values as a user writes them, as a drive file, and as a schema.

mod by_name;
mod drive_file;
pub(crate) mod fields;
#[cfg(feature = "schema")]
pub mod schema;
pub(crate) mod written_values;

pub use drive_file::{DriveFile, from_here, literal};
pub use fields::{Section, keys, sections};
pub use written_values::{Problem, Refused, from_value};
