//! What is written: files that are complete or absent, and those of a model.

mod exports;
mod files;

pub use exports::{Exported, Exports};
pub use files::{folder_of, plan, temporary, write, write_all};
