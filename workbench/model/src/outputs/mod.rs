//! What is written: files that are complete or absent, and those of a model.

mod cells;
mod exports;
mod files;
mod staged;
#[cfg(all(test, unix))]
mod tests;

pub use cells::{cell, text_of, trimmed};
pub use exports::{Exported, Exports};
pub use files::{plan, temporary, write, write_all};
pub use staged::{Staged, folder_of};
