//! One half-band filter, equation (3) of [`super::half_band`], in transposed form.

use crate::unroll::unrolled;

/// The two input samples from which a stage computes one output.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Waiting<const CH: usize> {
    pub(super) first: [f32; CH],
    pub(super) second: [f32; CH],
}

impl<const CH: usize> Waiting<CH> {
    #[inline(always)]
    pub(super) fn put(&mut self, is_first: bool, sample: [f32; CH]) {
        if is_first {
            self.first = sample;
        } else {
            self.second = sample;
        }
    }
}

/// One filter (3): the partial sums of the next 2K outputs, the next one first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Stage<const CH: usize, const PAIRS: usize> {
    pub(super) waiting: Waiting<CH>,
    pub(super) sooner: [[f32; CH]; PAIRS],
    pub(super) later: [[f32; CH]; PAIRS],
}

impl<const CH: usize, const PAIRS: usize> Stage<CH, PAIRS> {
    pub(super) const NEW: Self = Self {
        waiting: Waiting { first: [0.0; CH], second: [0.0; CH] },
        sooner: [[0.0; CH]; PAIRS],
        later: [[0.0; CH]; PAIRS],
    };

    /// The sum that moves from the later half to the sooner half.
    #[inline(always)]
    pub(super) fn carry(&self, taps: &[f32; PAIRS]) -> [f32; CH] {
        let (Some(sum), Some(tap)) = (self.later.first(), taps.last()) else { return [0.0; CH] };
        added(sum, *tap, &self.waiting.second)
    }

    /// Adds the second sample to the later K sums and shifts them by one; the sum that leaves is [`Self::carry`]. From
    /// the last sum to the first, each is replaced by `carry`; its old value plus tap · x is the next `carry`.
    #[inline(always)]
    pub(super) fn later_half(&mut self, taps: &[f32; PAIRS]) -> [f32; CH] {
        let (mut sums, mut taps, mut carry) = (&mut self.later[..], &taps[..], [0.0; CH]);
        let x = self.waiting.second;
        unrolled!(let ([earlier @ .., sum], [tap, inner @ ..]) = (sums, taps) => {
            carry = added(&core::mem::replace(sum, carry), *tap, &x);
            (sums, taps) = (earlier, inner);
        });
        carry
    }

    /// Adds both samples to the sooner K sums and shifts them by one; returns the sum that leaves, which is the output.
    #[inline(always)]
    pub(super) fn sooner_half(&mut self, taps: &[f32; PAIRS], carry: [f32; CH]) -> [f32; CH] {
        if let Some(middle) = self.sooner.last_mut() {
            *middle = added(middle, 0.5, &self.waiting.first);
        }
        let (mut sums, mut taps, mut carry) = (&mut self.sooner[..], &taps[..], carry);
        let x = self.waiting.second;
        unrolled!(let ([earlier @ .., sum], [outer @ .., tap]) = (sums, taps) => {
            carry = added(&core::mem::replace(sum, carry), *tap, &x);
            (sums, taps) = (earlier, outer);
        });
        carry
    }
}

/// sum + tap · x for each channel.
#[inline(always)]
fn added<const CH: usize>(sum: &[f32; CH], tap: f32, x: &[f32; CH]) -> [f32; CH] {
    let mut result = *sum;
    add(&mut result, tap, x); // (3)
    result
}

/// Adds tap · x to the sum of each channel.
#[inline(always)]
pub(super) fn add<const CH: usize>(sum: &mut [f32; CH], tap: f32, x: &[f32; CH]) {
    let (mut sums, mut values) = (&mut sum[..], &x[..]);
    unrolled!(let ([sum, sums_left @ ..], [x, values_left @ ..]) = (sums, values) => {
        *sum += tap * x;
        (sums, values) = (sums_left, values_left);
    });
}
