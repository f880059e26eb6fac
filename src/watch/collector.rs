//! The half between current loop and main loop: clean samples in, closed segments out.

use core::sync::atomic::{AtomicU32, Ordering};

use heapless::Deque;

use super::slot::take;
use super::{QUEUE, Watch};
use crate::detector::{Detector, Exchange, Segment};
use crate::known_answers::known_answer_test;
use crate::model::Model;
use crate::plan::{MAX_CHANNELS, Plan, Signals as _};
use crate::reason::Kernel;

/// Room for a segment.
pub(super) type Place<P> = &'static mut Segment<P>;

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

/// Most lost samples that are made up for at once: more than the shaft bridges, so that everything starts anew.
const MOST_MISSED: u16 = 16;

/// What the lower interrupt works on.
pub(super) struct Collector<P: Plan> {
    pub(super) detector: Detector<'static, P, Place<P>>,
    spare: Option<Place<P>>,
    /// A closed segment that the main loop could not be given yet.
    finished: Option<Place<P>>,
    tested: Option<Result<(), Kernel>>,
}

impl<P: Plan> Collector<P> {
    pub(super) fn new(model: &'static Model<P>, place: Place<P>) -> Self {
        Self { detector: Detector::with_place(model, place), spare: None, finished: None, tested: None }
    }

    /// What the context of the collector computes otherwise than the host.
    pub(super) fn failed(&self) -> Option<Kernel> {
        self.tested.and_then(Result::err)
    }

    /// Takes all samples of the queue; returns whether a segment has closed.
    pub(super) fn run<F>(&mut self, watch: &Watch<P, F>) -> bool {
        let right = *self.tested.get_or_insert_with(known_answer_test);
        let mut closed = self.hand_over(watch);
        while let Some(queued) = next(watch) {
            if right.is_ok() {
                closed |= self.take(watch, &queued);
            }
        }
        closed
    }

    /// Gives the detector a sample, and before it samples without values for those that were lost: without them it
    /// would take the samples before and after the gap for neighbours.
    fn take<F>(&mut self, watch: &Watch<P, F>, queued: &Queued<P>) -> bool {
        let Queued { sample, found_late, missed } = queued;
        if *found_late && let Some(number) = self.detector.discard() {
            watch.counters.doubted.store(number.wrapping_add(1), Ordering::Relaxed);
        }
        let gap = (*missed > 0).then(|| P::Sample::of(&[f32::NAN; MAX_CHANNELS], sample.angle()));
        let mut left = (*missed).min(MOST_MISSED);
        let mut closed = false;
        // One call for both kinds of samples, so that the code of a sample is here once.
        loop {
            let next = if left == 0 { sample } else { gap.as_ref().unwrap_or(sample) };
            if self.spare.is_none() {
                self.spare = take(&watch.spare);
            }
            match self.detector.exchange(next, &mut self.spare) {
                Exchange::Open => {}
                Exchange::Closed(place) => {
                    count(&watch.counters.closed);
                    self.finished = Some(place);
                    closed |= self.hand_over(watch);
                }
                Exchange::Lost => count(&watch.counters.lost_segments),
            }
            count(&watch.counters.rows);
            if left == 0 {
                return closed;
            }
            left = left.wrapping_sub(1);
        }
    }

    /// Gives a closed segment to the main loop, unless that holds the lock; there is one at a time.
    fn hand_over<F>(&mut self, watch: &Watch<P, F>) -> bool {
        let Some(place) = self.finished.take() else { return false };
        match watch.closed.try_lock() {
            Some(mut closed) => {
                *closed = Some(place);
                true
            }
            None => {
                self.finished = Some(place);
                false
            }
        }
    }
}

/// The oldest sample of the queue. A function of its own, so that the lock is free again when it returns.
fn next<P: Plan, F>(watch: &Watch<P, F>) -> Option<Queued<P>> {
    watch.queue.try_lock()?.pop_front()
}

/// Adds one, with wrap-around. By load and store: one context counts.
pub(super) fn count(counter: &AtomicU32) {
    counter.store(counter.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}
