//! Names in the files of parts: keys of their metadata, and their columns.

/// Key of the plan in the metadata.
pub(super) const PLAN: &str = "bearing_watch_plan";
/// Key that tells whether the units ascend.
pub(super) const SORTED: &str = "bearing_watch_sorted";
/// Columns of text that every part has, in their order.
pub(super) const TEXTS: [&str; 4] = ["trace", "class_name", "unit", "run"];
/// Names that no column of the labels can have.
pub const RESERVED: [&str; 6] = ["trace", "segment", "class_name", "unit", "run", "usable"];

/// Name of the column with the variances of a feature's errors.
pub(super) fn variance_of(name: &str) -> String {
    format!("{name}_variance")
}
