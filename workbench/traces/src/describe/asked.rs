//! What a description is asked for.

use std::path::Path;

use model::settings::Data;

/// What is described, and where the description is written.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Traces, and their time.
    pub data: &'a Data,
    /// Labels, if they are not the labels.csv beside the traces.
    pub labels: Option<&'a Path>,
    /// Where labels are written, by the names of the files.
    pub labels_from_names: Option<&'a Path>,
    /// The drive file; by default in the folder of the first trace, or here if that cannot be written.
    pub out: Option<&'a Path>,
    /// The file of the front end that is written, if the recordings are counts at the control rate.
    pub front_end: Option<&'a Path>,
    /// Whether they may be replaced.
    pub force: bool,
}
