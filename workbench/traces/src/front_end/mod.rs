//! Recordings at the control rate through the front end of the drive: the same code as in firmware.

mod clean;
pub(crate) mod cleaned;
mod rows;
#[cfg(test)]
mod tests;

pub use clean::FURTHER;
#[cfg(test)]
pub(crate) use clean::raw_sample;
pub(crate) use clean::{OWN, clean};
pub use rows::raw_rows;
