//! The half of the current loop: readings in, clean samples into the queue.

use core::fmt;

use super::link::{Link, Queue, Queued, count};
use crate::drive::{By, Factor, FrontEnd, FrontEndError};
use crate::model::ModelError;
use crate::plan::Plan;
use crate::reason::ArithmeticFault;

/// What the current loop works on.
pub(super) struct Inputs<P: Plan, F> {
    pub(super) front_end: F,
    /// A sample that the queue did not take yet.
    kept: Option<Queued<P>>,
    /// Samples that were lost since the last one of the queue, and whether one of them had a fault that was found late.
    missed: u16,
    found_late: bool,
    /// Closed segments when the main loop was told the faults; none is told at first.
    pub(super) told: Option<u32>,
}

/// Why a [`Watch`](super::Watch) did not start.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StartError {
    /// The chip computes otherwise than the host of the training.
    Arithmetic(ArithmeticFault),
    /// A constant of the front end is out of range.
    FrontEnd(FrontEndError),
    /// The model was trained with another front end.
    Model(ModelError),
    /// It runs already.
    Started,
}

impl StartError {
    /// What is wrong, in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Arithmetic(kernel) => kernel.message(),
            Self::FrontEnd(error) => error.message(),
            Self::Model(error) => error.message(),
            Self::Started => "the watch runs already",
        }
    }
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for StartError {}

impl<P: Plan, F> Inputs<P, F> {
    pub(super) const fn new(front_end: F) -> Self {
        Self { front_end, kept: None, missed: 0, found_late: false, told: None }
    }

    /// Drops the sample that was kept, and the record of those that were lost.
    pub(super) fn restart(&mut self) {
        (self.kept, self.missed, self.found_late) = (None, 0, false);
    }

    /// Puts a sample into the queue, behind the one that was kept; keeps it if the queue is full, or if the other
    /// context holds the lock. Returns whether samples wait.
    #[inline(always)]
    pub(super) fn put(&mut self, link: &Link<P>, sample: Option<(P::Sample, bool)>) -> bool {
        if self.kept.is_none() && sample.is_none() {
            return false;
        }
        let mut queue = link.queue.try_lock();
        let mut queue = queue.as_deref_mut();
        send(&mut self.kept, &mut queue);
        if let Some((sample, found_late)) = sample {
            if self.kept.is_some() {
                self.lose(link);
            }
            let found_late = core::mem::take(&mut self.found_late) || found_late;
            self.kept = Some(Queued { sample, found_late, missed: core::mem::take(&mut self.missed) });
            send(&mut self.kept, &mut queue);
        }
        queue.is_some_and(|queue| !queue.is_empty())
    }

    /// Drops the sample that was kept, and counts it for the next one.
    #[cold]
    #[inline(never)]
    fn lose(&mut self, link: &Link<P>) {
        if let Some(Queued { missed, found_late, .. }) = self.kept.take() {
            (self.missed, self.found_late) = (missed.saturating_add(1), found_late);
            count(&link.counters.lost_samples);
        }
    }
}

/// Moves a sample into the queue if there is room.
#[inline(always)]
fn send<P: Plan>(kept: &mut Option<Queued<P>>, queue: &mut Option<&mut Queue<P>>) {
    if let Some(queue) = queue
        && !queue.is_full()
        && let Some(queued) = kept.take()
    {
        let _room = queue.push_back(queued).is_ok();
    }
}

impl<P: Plan, const FURTHER: usize, const FACTOR: usize> Inputs<P, FrontEnd<FURTHER, FACTOR>>
where
    By<FACTOR>: Factor,
{
    /// Tells the main loop the faults, once a segment.
    #[cold]
    #[inline(never)]
    pub(super) fn tell(&mut self, link: &Link<P>, closed: u32) {
        link.faults.with(|faults| *faults = self.front_end.faults());
        self.told = Some(closed);
    }
}
