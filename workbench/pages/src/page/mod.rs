//! A page in one file: sections, tables, colours of the classes, and text inside HTML.

pub mod escape;
mod layout;
pub mod palette;
pub mod table;
#[cfg(test)]
pub(crate) mod well_formed;

pub use layout::{POLICY, Page, counted, linked, or_reason, paragraph};
