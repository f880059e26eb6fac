//! The model that rows are made and judged with: the last accepted one, and its successor until the handover.
//!
//! A segment's model takes over a fixed number of samples into the next segment, whether it was solved at once or in
//! another thread: the same bits either way. Without a successor the old model stays; after [`PATIENCE`] segments
//! the nominal one returns.

use super::Regression;

/// Segments without a successor after which the nominal model returns.
const PATIENCE: u8 = 3;

/// Parameters in the form the row source computes with.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Reference<const M: usize> {
    pub(super) now: [f32; M],
    next: [f32; M],
    /// Residual beyond which a row weighs less; infinite for never.
    pub(super) threshold: f32,
    next_threshold: f32,
    /// Samples until the handover; zero once it is past.
    until: u16,
    waiting: bool,
    pub(super) refused: u8,
}

/// A model and the threshold that goes with it.
pub(super) type Candidate<const M: usize> = ([f32; M], f32);

impl<const M: usize> Reference<M> {
    pub(super) fn new((now, threshold): Candidate<M>) -> Self {
        Self { now, next: [0.0; M], threshold, next_threshold: 0.0, until: 0, waiting: false, refused: 0 }
    }

    /// The model for the next handover.
    pub(super) fn offer(&mut self, (next, threshold): Candidate<M>) {
        (self.next, self.next_threshold, self.waiting) = (next, threshold, true);
    }

    /// Whether the handover of the open segment is still ahead.
    pub(super) const fn awaits(&self) -> bool {
        self.until > 0
    }

    /// A segment has been closed; `true` if the handover is now.
    pub(super) fn next_segment(&mut self, handover: u16, nominal: impl FnOnce() -> Candidate<M>) -> bool {
        self.until = handover;
        if handover == 0 {
            self.hand_over(nominal);
        }
        handover == 0
    }

    /// Counts a sample; `true` if the handover is now.
    #[inline]
    pub(super) fn tick(&mut self, nominal: impl FnOnce() -> Candidate<M>) -> bool {
        if self.until == 0 {
            return false;
        }
        self.until -= 1;
        if self.until == 0 {
            self.hand_over(nominal);
        }
        self.until == 0
    }

    #[cold]
    fn hand_over(&mut self, nominal: impl FnOnce() -> Candidate<M>) {
        if self.waiting {
            (self.now, self.threshold, self.waiting, self.refused) = (self.next, self.next_threshold, false, 0);
            return;
        }
        self.refused = self.refused.saturating_add(1);
        if self.refused >= PATIENCE {
            (self.now, self.threshold) = nominal();
        }
    }
}

/// The residual beyond which a row weighs less, for residuals of that deviation.
pub(super) fn threshold<const M: usize>(regression: &Regression<M>, deviation: f32) -> f32 {
    let threshold = regression.guard.huber * deviation;
    // Zero for "none" or "unknown"; NaN never gets this far, but must not switch every row off.
    if threshold > 0.0 { threshold } else { f32::INFINITY }
}

/// Huber's weight of a residual.
#[inline]
pub(super) fn weight(residual: f32, threshold: f32) -> f32 {
    let size = residual.abs();
    if size > threshold { threshold / size } else { 1.0 }
}
