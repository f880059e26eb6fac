//! Samples on their way from the current loop to an interrupt below it.
//!
//! One context puts, one takes: the number of samples that were put and that of those that were taken are the whole
//! state, and neither waits for the other.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::code::{BwCode, Outcome};

/// Samples that wait at most.
const PLACES: usize = 4;

/// The samples that wait.
#[derive(Debug)]
pub(crate) struct Waiting<T> {
    places: [UnsafeCell<Option<Put<T>>>; PLACES],
    put: AtomicU32,
    taken: AtomicU32,
    /// Samples that were lost since the last one that was put.
    missed: AtomicU32,
    /// Whether one of them had a fault that was found late.
    found_late: AtomicBool,
    /// Whether the arithmetic of the context that takes was tested.
    pub(crate) tested: AtomicBool,
    /// Whether it computes otherwise than the host.
    pub(crate) failed: AtomicBool,
}

#[derive(Debug)]
pub(crate) struct Put<T> {
    pub(crate) sample: T,
    pub(crate) found_late: bool,
    pub(crate) missed: u32,
}

// SAFETY: a place between the two numbers belongs to the context that takes, any other one to the context that puts.
unsafe impl<T: Send> Sync for Waiting<T> {}

impl<T> Waiting<T> {
    pub(crate) const fn new() -> Self {
        Self {
            places: [const { UnsafeCell::new(None) }; PLACES],
            put: AtomicU32::new(0),
            taken: AtomicU32::new(0),
            missed: AtomicU32::new(0),
            found_late: AtomicBool::new(false),
            tested: AtomicBool::new(false),
            failed: AtomicBool::new(false),
        }
    }

    /// Samples that were taken, with wrap-around; `None` if none was ever put.
    pub(crate) fn taken(&self) -> Option<u32> {
        (self.put.load(Ordering::Relaxed) > 0).then(|| self.taken.load(Ordering::Relaxed))
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.put.load(Ordering::Relaxed) == self.taken.load(Ordering::Relaxed)
    }

    fn place(&self, number: u32) -> Option<&UnsafeCell<Option<Put<T>>>> {
        self.places.get(number as usize % PLACES)
    }

    /// Puts a sample.
    ///
    /// # Errors
    /// [`BwCode::SampleLost`]
    ///
    /// # Safety
    /// No other call at the same time.
    pub(crate) unsafe fn put(&self, sample: T, found_late: bool) -> Outcome<()> {
        let number = self.put.load(Ordering::Relaxed);
        let found_late = found_late | self.found_late.load(Ordering::Relaxed);
        let full = number.wrapping_sub(self.taken.load(Ordering::Acquire)) as usize >= PLACES;
        self.found_late.store(full & found_late, Ordering::Relaxed);
        let missed = self.missed.load(Ordering::Relaxed);
        self.missed.store(if full { missed.saturating_add(1) } else { 0 }, Ordering::Relaxed);
        let Some(place) = self.place(number).filter(|_| !full) else { return Err(BwCode::SampleLost) };
        // SAFETY: the place is not between the two numbers.
        unsafe { *place.get() = Some(Put { sample, found_late, missed }) };
        self.put.store(number.wrapping_add(1), Ordering::Release);
        Ok(())
    }

    /// Takes the oldest sample.
    ///
    /// # Safety
    /// No other call at the same time.
    pub(crate) unsafe fn take(&self) -> Option<Put<T>> {
        let number = self.taken.load(Ordering::Relaxed);
        if number == self.put.load(Ordering::Acquire) {
            return None;
        }
        // SAFETY: the place is between the two numbers.
        let put = self.place(number).and_then(|place| unsafe { (*place.get()).take() });
        self.taken.store(number.wrapping_add(1), Ordering::Release);
        put
    }

    /// Drops all samples that wait, and the record of lost samples and of a fault before them.
    ///
    /// # Safety
    /// No call of [`Self::take`] at the same time.
    pub(crate) unsafe fn clear(&self) {
        for _ in 0..PLACES {
            // SAFETY: the same contract.
            let _dropped = unsafe { self.take() };
        }
        self.missed.store(0, Ordering::Relaxed);
        self.found_late.store(false, Ordering::Relaxed);
    }
}
