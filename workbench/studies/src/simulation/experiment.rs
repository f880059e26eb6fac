//! What an experiment on a rig is.

use std::fmt::Write as _;

use model::Error;
use model::trace::FrontEndFile;
use rig::DefectKind;

/// Columns with their names.
pub type Table = Vec<(&'static str, Vec<f64>)>;

/// Returns columns with nine significant digits, which are far finer than the noise and keep files small.
pub fn table<C: AsRef<[f64]>>(columns: Vec<(&'static str, C)>) -> Table {
    // One text for all: a new one for each number takes longer than the number.
    let mut text = String::new();
    let mut rounded = |x: &f64| {
        text.clear();
        let _string_grows = write!(text, "{x:.8e}");
        text.parse().unwrap_or(*x)
    };
    columns.into_iter().map(|(name, column)| (name, column.as_ref().iter().map(&mut rounded).collect())).collect()
}

/// A simulated trace.
#[derive(Debug)]
pub struct Simulated {
    /// Columns.
    pub table: Table,
    /// Shape of the reference.
    pub shape: &'static str,
}

/// The experiment that the options choose on one rig.
pub(super) trait Experiment: Sync {
    /// Returns an error if traces of this class cannot be simulated.
    fn validate(&self, kind: DefectKind) -> Result<(), Error>;
    /// Name of the condition.
    fn condition(&self) -> &str;
    /// First part of the file names of a class, before its name.
    fn prefix(&self, kind: DefectKind) -> Option<&'static str>;
    /// Last part of the file names of a class.
    fn suffix(&self) -> Option<&'static str>;
    /// The front end of the traces, if they are raw samples.
    fn front_end(&self) -> Option<FrontEndFile>;
    /// Simulates one trace.
    fn simulate(&self, kind: DefectKind, seed: u64) -> Result<Simulated, Error>;
}
