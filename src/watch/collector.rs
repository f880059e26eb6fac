//! The half between current loop and main loop: clean samples in, closed segments out.

use core::sync::atomic::Ordering;

use super::link::{Link, Queued, count};
use super::places::Place;
use super::slot::take;
use crate::detector::{Detector, Exchange};
use crate::known_answers::known_answer_test;
use crate::model::Model;
use crate::plan::{MAX_CHANNELS, Plan, Signals as _};
use crate::reason::ArithmeticFault;

/// Most lost samples that are made up for at once: more than the shaft bridges, so that everything starts anew.
const MOST_MISSED: u16 = 16;

/// What the lower interrupt works on.
pub(super) struct Collector<P: Plan> {
    pub(super) detector: Detector<'static, P, Place<P>>,
    spare: Option<Place<P>>,
    /// A closed segment that the main loop could not be given yet.
    finished: Option<Place<P>>,
    tested: Option<Result<(), ArithmeticFault>>,
}

impl<P: Plan> Collector<P> {
    pub(super) fn new(model: &'static Model<P>, place: Place<P>) -> Self {
        Self { detector: Detector::with_place(model, place), spare: None, finished: None, tested: None }
    }

    /// The places that it has.
    pub(super) fn into_places(self) -> [Option<Place<P>>; 3] {
        [Some(self.detector.into_place()), self.spare, self.finished]
    }

    /// Keeps the place of a closed segment that was not handed over, without the segment.
    pub(super) fn forget_closed(&mut self) {
        if let Some(place) = self.finished.take() {
            self.spare = Some(place);
        }
    }

    /// What the context of the collector computes otherwise than the host.
    pub(super) fn failed(&self) -> Option<ArithmeticFault> {
        self.tested.and_then(Result::err)
    }

    /// Takes all samples of the queue, and shows each; returns whether a segment has closed.
    pub(super) fn run(&mut self, link: &Link<P>, mut show: impl FnMut(&P::Sample, u16)) -> bool {
        let right = *self.tested.get_or_insert_with(known_answer_test);
        let mut closed = self.hand_over(link);
        while let Some(queued) = link.next() {
            if right.is_ok() {
                show(&queued.sample, queued.missed);
                closed |= self.take(link, &queued);
            }
        }
        closed
    }

    /// Gives the detector a sample, and before it samples without values for those that were lost: without them it
    /// would take the samples before and after the gap for neighbours.
    fn take(&mut self, link: &Link<P>, queued: &Queued<P>) -> bool {
        let Queued { sample, found_late, missed } = queued;
        if *found_late && let Some(number) = self.detector.discard() {
            link.counters.doubted.store(number.wrapping_add(1), Ordering::Relaxed);
        }
        let gap = (*missed > 0).then(|| P::Sample::of(&[f32::NAN; MAX_CHANNELS], sample.angle()));
        let mut left = (*missed).min(MOST_MISSED);
        let mut closed = false;
        // One call for both kinds of samples, so that the code of a sample is here once.
        loop {
            let next = if left == 0 { sample } else { gap.as_ref().unwrap_or(sample) };
            if self.spare.is_none() {
                self.spare = take(&link.spare);
            }
            match self.detector.exchange(next, &mut self.spare) {
                Exchange::Open => {}
                Exchange::Closed(place) => {
                    count(&link.counters.closed);
                    self.finished = Some(place);
                    closed |= self.hand_over(link);
                }
                Exchange::Lost => count(&link.counters.lost_segments),
            }
            count(&link.counters.rows);
            if left == 0 {
                return closed;
            }
            left = left.wrapping_sub(1);
        }
    }

    /// Gives a closed segment to the main loop, unless that holds the lock; there is one at a time.
    fn hand_over(&mut self, link: &Link<P>) -> bool {
        let Some(place) = self.finished.take() else { return false };
        match link.closed.try_lock() {
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
