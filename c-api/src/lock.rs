//! A value that one function at a time works on; others are refused, not made to wait.

use spin::mutex::SpinMutex;

use crate::code::{BwCode, Outcome};

/// The value.
#[derive(Debug)]
pub(crate) struct Lock<T>(SpinMutex<T>);

impl<T> Lock<T> {
    pub(crate) const fn new(value: T) -> Self {
        Self(SpinMutex::new(value))
    }

    /// Works on the value.
    ///
    /// # Errors
    /// [`BwCode::Busy`] if another function works on it.
    #[inline]
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> Outcome<R> {
        self.0.try_lock().map(|mut value| work(&mut value)).ok_or(BwCode::Busy)
    }
}
