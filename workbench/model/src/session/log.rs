//! What a work says while it goes on: warnings, which are collected, and its progress.

use std::cell::RefCell;

/// Is called with the number of steps that are done; the work ends when it is dropped.
pub type Steps = Box<dyn Fn(u64) + Sync>;

/// Shows how far a work is.
pub trait Progress {
    /// A work of so many steps begins.
    fn start(&self, what: &'static str, count: usize) -> Steps;
}

/// Shows nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quiet;

impl Progress for Quiet {
    fn start(&self, _: &'static str, _: usize) -> Steps {
        Box::new(|_| {})
    }
}

/// The warnings of a work, and who shows its progress.
pub struct Log<'a> {
    progress: &'a dyn Progress,
    warnings: RefCell<Vec<String>>,
}

impl std::fmt::Debug for Log<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Log").field("warnings", &self.warnings).finish_non_exhaustive()
    }
}

impl<'a> Log<'a> {
    /// Without a warning yet.
    #[must_use]
    pub const fn new(progress: &'a dyn Progress) -> Self {
        Self { progress, warnings: RefCell::new(vec![]) }
    }

    /// Adds warnings.
    pub fn warn<T: Into<String>>(&self, texts: impl IntoIterator<Item = T>) {
        self.warnings.borrow_mut().extend(texts.into_iter().map(Into::into));
    }

    /// Begins a work of so many steps.
    #[must_use]
    pub fn steps(&self, what: &'static str, count: usize) -> Steps {
        self.progress.start(what, count)
    }

    /// Returns the warnings in the order in which they came, and forgets them.
    #[must_use]
    pub fn take(&self) -> Vec<String> {
        self.warnings.take()
    }
}
