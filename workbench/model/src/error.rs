//! Errors, each as one line with file, place and remedy.

use std::path::{Path, PathBuf};

use bearing_watch::ModelError;

use crate::near;
use crate::visible::lines;

/// All errors of the workbench; `Display` returns one line for the user, in which nothing acts on a terminal.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be opened, read or written.
    #[error("{path}: {source}", path = lines(&path.to_string_lossy()))]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The content of a file is wrong at a given place.
    #[error("{}, {}: {}", lines(&path.to_string_lossy()), lines(place), lines(problem))]
    Content {
        /// The file.
        path: PathBuf,
        /// Line, column or header.
        place: String,
        /// What is wrong and how to correct it.
        problem: String,
    },
    /// A trace cannot be used.
    #[error("trace {}: {}", lines(trace), lines(problem))]
    Trace {
        /// Its id.
        trace: String,
        /// What is wrong and how to correct it.
        problem: String,
    },
    /// The training set is not usable, or not usable for the requested training.
    #[error("{}", lines(.0))]
    Training(String),
    /// An option has an invalid value.
    #[error("{}", lines(.0))]
    Usage(String),
    /// The error of another part, for example of a rig that rejects its scenario.
    #[error("{}", lines(&.0.to_string()))]
    Other(Box<dyn std::error::Error + Send + Sync>),
}

impl Error {
    /// The kind of the error as a word, for programs.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Io { .. } => "file",
            Self::Content { .. } => "content",
            Self::Trace { .. } => "trace",
            Self::Training(_) => "training",
            Self::Usage(_) => "usage",
            Self::Other(_) => "other",
        }
    }

    /// The error of another part.
    pub fn other(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Other(Box::new(error))
    }

    /// Converts an input or output error and adds the file; of a file that does not exist also the nearest name.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| {
            let is_missing = source.kind() == std::io::ErrorKind::NotFound;
            let near = if is_missing { near::of_file(&path) } else { String::new() };
            if near.is_empty() {
                return Self::Io { path, source };
            }
            let source = std::io::Error::new(source.kind(), format!("{source}{}", lines(&near)));
            Self::Io { path, source }
        }
    }

    /// An error at a given place of a file.
    #[must_use]
    pub fn content(path: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Content { path: path.to_path_buf(), place: place.into(), problem: problem.into() }
    }

    /// An error of a trace.
    #[must_use]
    pub fn trace(id: &str, problem: impl Into<String>) -> Self {
        Self::Trace { trace: id.into(), problem: problem.into() }
    }
}

/// The core's refusal of a trained model.
pub(crate) fn refused(error: ModelError) -> Error {
    Error::Training(format!("the trained model cannot be embedded: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_a_file_acts_on_a_terminal() {
        let bad = "a\u{1b}[2Jb";
        let path = Path::new(bad);
        let missing = || std::io::Error::from(std::io::ErrorKind::NotFound);
        let errors = [
            Error::io(path)(missing()),
            Error::content(path, bad, bad),
            Error::trace(bad, bad),
            Error::Training(bad.into()),
            Error::Usage(bad.into()),
            Error::other(std::io::Error::other(bad)),
        ];
        for error in errors {
            let text = error.to_string();
            assert!(text.contains("a\\u{1b}[2Jb") && !text.contains('\u{1b}'), "{text:?}");
        }
    }
}
