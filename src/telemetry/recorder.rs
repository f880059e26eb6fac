//! Samples → blocks.

use super::filling::Filling;
use super::samples::{Block, sample_bytes};
use crate::plan::{Plan, Signals};

/// Gathers samples in a block of at most `BYTES` bytes; a sample has four for each channel, and four for the angle of
/// a plan that needs it.
///
/// In an interrupt, hand over what [`Recorder::take`] returns by a queue. `cargo xtask firmware measure_telemetry`
/// prints the instructions of a push.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Recorder<P: Plan, const BYTES: usize> {
    plan: P,
    /// Number of the first sample of the block, and of the next sample.
    first: u32,
    next: u32,
    samples: Filling<BYTES>,
}

impl<P: Plan, const BYTES: usize> Recorder<P, BYTES> {
    /// No sample yet.
    #[must_use]
    pub const fn new(plan: P) -> Self {
        Self { plan, first: 0, next: 0, samples: Filling::new() }
    }

    /// Takes a sample; returns whether the block is complete. A complete block takes no sample until
    /// [`Recorder::clear`] or [`Recorder::take`]: the receiver sees a gap.
    #[inline]
    pub fn push(&mut self, sample: &P::Sample) -> bool {
        let layout = self.plan.layout();
        let bytes = sample_bytes(layout.channels, layout.needs_angle());
        let number = self.next;
        self.next = self.next.wrapping_add(1);
        if self.samples.is_empty() {
            self.first = number;
        }
        self.samples.add(bytes, |words| {
            let mut words = words.iter_mut();
            for (channel, word) in (0..layout.channels as usize).zip(&mut words) {
                *word = sample.value(channel).to_le_bytes();
            }
            if let Some(word) = words.next() {
                *word = sample.angle().bits().to_le_bytes();
            }
        });
        self.samples.is_complete()
    }

    /// Passes over samples that were not taken, such as those of missed interrupts. What is in the block is complete.
    pub fn skip(&mut self, samples: u32) {
        self.next = self.next.wrapping_add(samples);
        if !self.samples.is_empty() {
            self.samples.complete();
        }
    }

    /// Whether the block is complete: it takes no more samples.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        self.samples.is_complete()
    }

    /// The samples so far.
    #[must_use]
    pub fn block(&self) -> Block<'_> {
        let layout = self.plan.layout();
        let bytes = self.samples.bytes();
        Block { first: self.first, channels: layout.channels, with_angle: layout.needs_angle(), bytes }
    }

    /// Starts the next block.
    pub const fn clear(&mut self) {
        self.samples.clear();
    }

    /// Gives the block away and starts the next one.
    #[must_use]
    pub fn take(&mut self) -> Self {
        let whole = self.clone();
        self.clear();
        whole
    }
}
