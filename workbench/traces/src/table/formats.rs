//! Formats that are not text, and the refusal of one that this program was built without.

use std::path::Path;

use model::Error;
use model::trace::{extensions, file_name};

/// Whether files with this extension are not text.
pub(super) fn is_binary(extension: &str) -> bool {
    ["mat", "h5", "hdf5", "parquet", "arrow", "arrows", "feather", "npy", "npz"].contains(&extension)
        || unread(extension).is_some()
}

/// Whether files with this extension are read, but not written.
pub(super) fn is_read_only(extension: &str) -> bool {
    ["arrows", "h5", "hdf5", "npy"].contains(&extension) || unread(extension).is_some()
}

/// Whether a file has a format that is known and not read.
#[must_use]
pub fn is_unread(file: &Path) -> bool {
    extensions(&file_name(file)).is_some_and(|(extension, _)| unread(&extension).is_some())
}

/// What is said of a format that is known and not read.
pub(super) fn unread(extension: &str) -> Option<&'static str> {
    Some(match extension {
        "tdms" => "a TDMS file of LabVIEW, which is not read: export it as CSV, or write its channels as Parquet",
        "xlsx" => "an Excel workbook, which is not read: save its sheet as CSV, the labels as labels.csv",
        _ => return None,
    })
}

/// The error of a format that this program was built without.
pub(super) fn left_out(path: &Path, extension: &str) -> Error {
    let problem = format!("this program was built without the format .{extension}; build it with all features");
    Error::content(path, "name", problem)
}
