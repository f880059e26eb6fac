//! What the contexts of a watch share: samples, places of segments and numbers on their way.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use heapless::Deque;
use spin::mutex::SpinMutex as TryLock;

use super::places::Place;
use super::slot::Slot;
use crate::drive::{Alignment, Faults};
use crate::plan::Plan;

/// Clean samples that wait for [`Watch::collect`](super::Watch::collect) at most: it may be late by this many of their
/// intervals.
pub const QUEUE: usize = 4;

/// Clean samples on their way from the current loop.
pub(super) type Queue<P> = Deque<Queued<P>, QUEUE>;

/// A clean sample, and what happened before it.
pub(super) struct Queued<P: Plan> {
    pub(super) sample: P::Sample,
    /// A fault was found that began before this sample.
    pub(super) found_late: bool,
    /// Samples that were lost before this one.
    pub(super) missed: u16,
}

/// Between the contexts. Nothing waits for a lock.
pub(super) struct Link<P: Plan> {
    pub(super) queue: TryLock<Queue<P>>,
    /// The place of a closed segment, on its way to the main loop, and a clear one on its way back.
    pub(super) closed: TryLock<Option<Place<P>>>,
    pub(super) spare: TryLock<Option<Place<P>>>,
    /// Those of the front end, for the main loop.
    pub(super) faults: Slot<Faults>,
    pub(super) counters: Counters,
}

/// What contexts tell each other by numbers alone.
pub(super) struct Counters {
    /// Samples that the detector took.
    pub(super) rows: AtomicU32,
    /// Requests that the front end count from zero.
    pub(super) cleared: AtomicU32,
    /// Readings that a check of the wiring took, with wrap-around.
    pub(super) checked: AtomicU32,
    pub(super) lost_samples: AtomicU32,
    pub(super) lost_segments: AtomicU32,
    /// Closed segments, with wrap-around.
    pub(super) closed: AtomicU32,
    /// Number of the segment that a fault has put in doubt, plus one: 0 for none.
    pub(super) doubted: AtomicU32,
    /// Place in [`Alignment::ALL`] of what the front end knows of the wiring: not decided at first.
    pub(super) alignment: AtomicU8,
}

impl<P: Plan> Link<P> {
    pub(super) const fn new() -> Self {
        Self {
            queue: TryLock::new(Queue::new()),
            closed: TryLock::new(None),
            spare: TryLock::new(None),
            faults: Slot::new(),
            counters: Counters {
                rows: AtomicU32::new(0),
                cleared: AtomicU32::new(0),
                checked: AtomicU32::new(0),
                lost_samples: AtomicU32::new(0),
                lost_segments: AtomicU32::new(0),
                closed: AtomicU32::new(0),
                doubted: AtomicU32::new(0),
                alignment: AtomicU8::new(0),
            },
        }
    }

    /// Forgets what was before a start.
    pub(super) fn restart(&self, spare: Place<P>, alignment: Alignment) {
        if let Some(mut queue) = self.queue.try_lock() {
            queue.clear();
        }
        if let Some(mut place) = self.spare.try_lock() {
            *place = Some(spare);
        }
        let Counters { rows, cleared, checked, lost_samples, lost_segments, closed, doubted, alignment: _ } =
            &self.counters;
        for counter in [rows, cleared, checked, lost_samples, lost_segments, closed, doubted] {
            counter.store(0, Ordering::Relaxed);
        }
        self.tell_alignment(alignment);
    }

    /// Says what is known of the wiring.
    #[inline(always)]
    pub(super) fn tell_alignment(&self, alignment: Alignment) {
        self.counters.alignment.store(alignment as u8, Ordering::Relaxed);
    }

    pub(super) fn alignment(&self) -> Alignment {
        let place = self.counters.alignment.load(Ordering::Relaxed);
        Alignment::ALL.get(usize::from(place)).copied().unwrap_or_default()
    }

    /// The oldest sample of the queue. A function of its own, so that the lock is free again when it returns.
    pub(super) fn next(&self) -> Option<Queued<P>> {
        self.queue.try_lock()?.pop_front()
    }
}

impl Counters {
    /// Changes where the current loop is to tell its faults: with each closed segment, and if they are to be cleared.
    #[inline(always)]
    pub(super) fn due(&self) -> u32 {
        self.closed.load(Ordering::Relaxed).wrapping_add(self.cleared.load(Ordering::Relaxed))
    }
}

/// Adds one, with wrap-around. By load and store: one context counts.
pub(super) fn count(counter: &AtomicU32) {
    counter.store(counter.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}
