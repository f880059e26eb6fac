//! What goes wrong, in one line: file, place, remedy.

use std::path::{Path, PathBuf};

/// Every error of the workbench; its `Display` is the one line a user reads.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be opened, read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The content of a file is wrong at some place.
    #[error("{path}, {place}: {problem}", path = path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Line, column or header.
        place: String,
        /// What is wrong and what to do.
        problem: String,
    },
    /// A trace cannot be used.
    #[error("trace {trace}: {problem}")]
    Trace {
        /// Its id.
        trace: String,
        /// What is wrong and what to do.
        problem: String,
    },
    /// The training set, or what was asked of it, does not work.
    #[error("{0}")]
    Training(String),
    /// An option has a value that means nothing.
    #[error("{0}")]
    Usage(String),
    /// A rig refuses its scenario.
    #[error(transparent)]
    Rig(#[from] crate::rig::RigError),
}

impl Error {
    /// Wraps an input or output error with its file.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { path, source }
    }

    /// Something wrong at a place of a file.
    #[must_use]
    pub fn content(path: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Content { path: path.to_path_buf(), place: place.into(), problem: problem.into() }
    }

    /// Something wrong with a trace.
    #[must_use]
    pub fn trace(id: &str, problem: impl Into<String>) -> Self {
        Self::Trace { trace: id.into(), problem: problem.into() }
    }
}
