//! Arrays of a file → columns: those of one recording, or the records of several.

pub(super) mod columns;
pub(super) mod groups;
pub(super) mod numbers;
pub(super) mod records;

pub(super) use columns::rising_time;
