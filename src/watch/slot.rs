//! A value in static memory that one context at a time works on.

use spin::mutex::SpinMutex as TryLock;
use spin::mutex::SpinMutexGuard as Guard;

/// Empty until it is filled. All bytes of an empty one are zero.
pub(super) struct Slot<T>(TryLock<Content<T>>);

/// What a slot contains. Its first byte says which it is, and is zero at first: an `Option` may choose another byte and
/// another value, by which a static would take flash.
#[repr(u8)]
pub(super) enum Content<T> {
    Empty = 0,
    Full(T) = 1,
}

impl<T> Slot<T> {
    pub(super) const fn new() -> Self {
        Self(TryLock::new(Content::Empty))
    }

    /// Holds the slot; `None` if another context does.
    #[inline(always)]
    pub(super) fn hold(&self) -> Option<Guard<'_, Content<T>>> {
        self.0.try_lock()
    }

    /// Works on the value; `None` if it is not there, or if another context works on it.
    #[inline(always)]
    pub(super) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> Option<R> {
        match &mut *self.hold()? {
            Content::Full(value) => Some(work(value)),
            Content::Empty => None,
        }
    }
}

impl<T> Content<T> {
    /// Makes the value in its place.
    // Out of line, so that none of the values takes stack while another is made.
    #[inline(never)]
    pub(super) fn fill(&mut self, make: impl FnOnce() -> T) {
        *self = Self::Full(make());
    }

    /// Takes the value out.
    pub(super) fn take(&mut self) -> Option<T> {
        match core::mem::replace(self, Self::Empty) {
            Self::Full(value) => Some(value),
            Self::Empty => None,
        }
    }
}

/// Takes what a lock holds; `None` if it is empty or taken.
pub(super) fn take<T>(lock: &TryLock<Option<T>>) -> Option<T> {
    lock.try_lock()?.take()
}
