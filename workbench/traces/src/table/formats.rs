//! Formats that are not text, and the refusal of one that this program was built without.

use std::path::Path;

use model::Error;

/// Whether files with this extension are not text.
pub(super) fn is_binary(extension: &str) -> bool {
    ["mat", "parquet", "arrow", "arrows", "feather", "npy", "npz"].contains(&extension)
}

/// Whether files with this extension are read, but not written.
pub(super) fn is_read_only(extension: &str) -> bool {
    ["arrows", "npy"].contains(&extension)
}

/// The error of a format that this program was built without.
pub(super) fn left_out(path: &Path, extension: &str) -> Error {
    let problem = format!("this program was built without the format .{extension}; build it with all features");
    Error::content(path, "name", problem)
}
