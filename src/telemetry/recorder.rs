//! Samples → blocks.

use super::samples::{Block, sample_bytes};
use crate::plan::{Plan, Signals};

/// Gathers samples in a block of at most `BYTES` bytes; a sample has four for each channel, and four for the angle of
/// a plan that needs it.
///
/// In an interrupt, hand over what [`Recorder::take`] returns by a queue; [`Recorder::push`] takes a few instructions a
/// channel.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Recorder<P: Plan, const BYTES: usize> {
    plan: P,
    /// Number of the first sample of the block, and of the next sample.
    first: u32,
    next: u32,
    used: usize,
    /// Whether the block takes no more samples.
    closed: bool,
    bytes: [u8; BYTES],
}

impl<P: Plan, const BYTES: usize> Recorder<P, BYTES> {
    /// No sample yet.
    #[must_use]
    pub const fn new(plan: P) -> Self {
        Self { plan, first: 0, next: 0, used: 0, closed: false, bytes: [0; BYTES] }
    }

    /// Takes a sample; returns whether the block is complete. A complete block takes no sample until
    /// [`Recorder::clear`] or [`Recorder::take`]: the receiver sees a gap.
    #[inline]
    pub fn push(&mut self, sample: &P::Sample) -> bool {
        let layout = self.plan.layout();
        let bytes = sample_bytes(layout.channels, layout.needs_angle());
        let number = self.next;
        self.next = self.next.wrapping_add(1);
        let end = self.used.saturating_add(bytes);
        let cells = if self.closed { None } else { self.bytes.get_mut(self.used..end) };
        let Some(cells) = cells else {
            self.closed = true;
            return true;
        };
        let (words, _) = cells.as_chunks_mut();
        let mut words = words.iter_mut();
        for (channel, word) in (0..layout.channels as usize).zip(&mut words) {
            *word = sample.value(channel).to_le_bytes();
        }
        if let Some(word) = words.next() {
            *word = sample.angle().bits().to_le_bytes();
        }
        if self.used == 0 {
            self.first = number;
        }
        self.used = end;
        self.closed = end.saturating_add(bytes) > BYTES;
        self.closed
    }

    /// Passes over samples that were not taken, such as those of missed interrupts. What is in the block is complete.
    pub fn skip(&mut self, samples: u32) {
        self.next = self.next.wrapping_add(samples);
        self.closed |= self.used > 0;
    }

    /// The samples so far.
    #[must_use]
    pub fn block(&self) -> Block<'_> {
        let layout = self.plan.layout();
        let bytes = self.bytes.get(..self.used).unwrap_or(&[]);
        Block { first: self.first, channels: layout.channels, with_angle: layout.needs_angle(), bytes }
    }

    /// Starts the next block.
    pub const fn clear(&mut self) {
        (self.used, self.closed) = (0, false);
    }

    /// Gives the block away and starts the next one.
    #[must_use]
    pub fn take(&mut self) -> Self {
        let whole = self.clone();
        self.clear();
        whole
    }
}
