//! A value in static memory that one context at a time works on.

use spin::mutex::SpinMutex as TryLock;
use static_cell::StaticCell;

/// Empty until it is filled. All bytes of an empty one are zero.
pub(super) struct Slot<T: 'static> {
    memory: StaticCell<T>,
    value: TryLock<Option<&'static mut T>>,
}

impl<T> Slot<T> {
    pub(super) const fn new() -> Self {
        Self { memory: StaticCell::new(), value: TryLock::new(None) }
    }

    /// Makes the value in its place, without a lock around it; `None` if it was made before.
    pub(super) fn place(&'static self, make: impl FnOnce() -> T) -> Option<&'static mut T> {
        self.memory.try_init_with(make)
    }

    /// Makes the value in its place; `false` if it was made before.
    pub(super) fn fill(&'static self, make: impl FnOnce() -> T) -> bool {
        let Some(mut value) = self.value.try_lock() else { return false };
        *value = self.place(make);
        value.is_some()
    }

    /// Works on the value; `None` if it is not there, or if another context works on it.
    #[inline(always)]
    pub(super) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> Option<R> {
        let mut value = self.value.try_lock()?;
        value.as_deref_mut().map(work)
    }
}

/// Takes what a lock holds; `None` if it is empty or taken.
pub(super) fn take<T>(lock: &TryLock<Option<T>>) -> Option<T> {
    lock.try_lock()?.take()
}
