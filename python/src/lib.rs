//! The extension module `bearing_watch._core`: the workbench on arrays and tables. The package around it, in Python,
//! checks arguments and gives results their form.
//!
//! ```text
//! tables      mappings of arrays, Arrow streams ─► tables in memory, and arrays ─► Arrow streams
//! options     keyword arguments ─► settings and further options of a job
//! recordings  read, audit, init
//! recursive   RecursiveEstimator: the estimator of the core on pieces
//! signals     identify, structure, validate
//! model       train, Model, evaluate, simulate
//! detector    Detector: the core on whole traces and on pieces
//! fleet       features, sums and models, from files to files
//! learning    classifier and novelty gate on matrices of features
//! ```
//!
//! Long work releases the interpreter's lock, and runs on threads of its process, also of a forked one (`pool`).
//! Errors are exceptions with the text of the command line.

mod arrow;
mod detector;
mod errors;
mod fleet;
mod learning;
mod model;
mod options;
mod pool;
mod recordings;
mod recursive;
mod signals;
mod tables;

use pyo3::prelude::*;

// With the lock: the objects of the package are not made to be used by several threads at once. A free-threaded
// interpreter turns its lock on for this module, and warns of it.
#[pymodule(gil_used = true)]
mod _core {
    /// Version of the package.
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name in Python")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    use super::arrow::arrow_stream;
    #[pymodule_export]
    use super::detector::Detector;
    #[pymodule_export]
    use super::errors::BearingWatchError;
    #[pymodule_export]
    use super::fleet::fleet;
    #[pymodule_export]
    use super::learning::{RowClassifier, RowGate};
    #[pymodule_export]
    use super::model::{Model, simulate, train};
    #[pymodule_export]
    use super::options::settings;
    #[pymodule_export]
    use super::recordings::{audit, init, read};
    #[pymodule_export]
    use super::recursive::RecursiveEstimator;
    #[pymodule_export]
    use super::signals::{identify, structure, validate};
    #[pymodule_export]
    use super::tables::is_time;
}
