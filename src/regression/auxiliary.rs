//! The auxiliary model of instrumental variables, which rows are made with, and its successor until the handover.
//!
//! The model of a segment takes over a fixed number of samples into the next segment, whether it was solved at once or
//! in another thread: both give the same bits. Without a successor the model stays; after [`PATIENCE`] segments the
//! nominal model returns.

use crate::plan::{Array, Cells, RegressionLengths};
use crate::unroll::unrolled;

/// Segments without a successor after which the nominal model returns.
const PATIENCE: u8 = 3;

/// The δ-parameters of the auxiliary model and of its successor.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Auxiliary<P: RegressionLengths> {
    /// The model in use.
    pub now: Array<P::Parameters, f32>,
    next: Array<P::Parameters, f32>,
    /// Samples until the handover; zero once it is past.
    until: u16,
    waiting: bool,
    /// Segments in a row without a successor.
    pub refused: u8,
}

impl<P: RegressionLengths> Auxiliary<P> {
    /// Starts with a model.
    #[must_use]
    pub fn new(now: Array<P::Parameters, f32>) -> Self {
        Self { next: now.clone(), now, until: 0, waiting: false, refused: 0 }
    }

    /// Offers the model for the next handover.
    pub fn offer(&mut self, next: Array<P::Parameters, f32>) {
        (self.next, self.waiting) = (next, true);
    }

    /// Whether the handover of the open segment is still ahead.
    #[must_use]
    pub const fn awaits(&self) -> bool {
        self.until > 0
    }

    /// Starts a segment; returns whether the handover is now.
    pub fn next_segment(&mut self, handover: u16, nominal: impl FnOnce() -> Array<P::Parameters, f32>) -> bool {
        self.until = handover;
        if handover == 0 && self.hand_over() {
            self.now = nominal();
        }
        handover == 0
    }

    /// Counts a sample; returns whether the handover is now.
    #[inline(always)]
    pub fn tick(&mut self, nominal: impl FnOnce() -> Array<P::Parameters, f32>) -> bool {
        if self.until == 0 {
            return false;
        }
        self.until = self.until.wrapping_sub(1);
        if self.until == 0 && self.hand_over() {
            self.now = nominal();
        }
        self.until == 0
    }

    /// Lets the successor take over; returns whether the nominal model must return, since there was none for too long.
    #[cold]
    #[inline(never)]
    fn hand_over(&mut self) -> bool {
        if self.waiting {
            (self.waiting, self.refused) = (false, 0);
            // Not by a loop: at `opt-level = "s"` it becomes a call of memmove, which is large.
            let (mut now, mut next) = (self.now.cells_mut(), self.next.cells());
            unrolled!(let ([to, to_rest @ ..], [from, from_rest @ ..]) = (now, next) => {
                *to = *from;
                (now, next) = (to_rest, from_rest);
            });
            return false;
        }
        self.refused = self.refused.saturating_add(1);
        self.refused >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::RunTime;
    use std::vec;

    #[test]
    fn the_handover_is_told_once_and_the_successor_takes_over_there() {
        let mut auxiliary = Auxiliary::<RunTime>::new(vec![1.0]);
        auxiliary.offer(vec![2.0]);
        assert!(!auxiliary.next_segment(2, || vec![9.0]) && auxiliary.awaits());
        let ticks = [0; 4].map(|_| (auxiliary.tick(|| vec![9.0]), auxiliary.now[0]));
        assert_eq!(ticks, [(false, 1.0), (true, 2.0), (false, 2.0), (false, 2.0)]);
        assert!(auxiliary.next_segment(0, || vec![9.0]) && !auxiliary.awaits(), "at once");
    }

    #[test]
    fn the_nominal_model_returns_after_three_segments_without_a_successor() {
        for handover in [0, 1] {
            let mut auxiliary = Auxiliary::<RunTime>::new(vec![1.0]);
            auxiliary.offer(vec![2.0]);
            let models = [0; 6].map(|_| {
                auxiliary.next_segment(handover, || vec![9.0]);
                auxiliary.tick(|| vec![9.0]);
                auxiliary.now[0]
            });
            assert_eq!(models, [2.0, 2.0, 2.0, 9.0, 9.0, 9.0], "{handover}");
            auxiliary.offer(vec![3.0]);
            auxiliary.next_segment(handover, || vec![9.0]);
            auxiliary.tick(|| vec![9.0]);
            assert_eq!((&auxiliary.now[..], auxiliary.refused), (&[3.0][..], 0), "{handover}");
        }
    }
}
