//! The current that belongs to each angle of the rotor.

use crate::signal::Angle;

/// A mean-free table over one turn; entry b belongs to the angle (b + ½)/BINS of a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RotorTable<const BINS: usize> {
    /// The entries.
    pub current_a: [f32; BINS],
}

impl<const BINS: usize> RotorTable<BINS> {
    /// The table of these values less their mean.
    pub(super) fn of(mut current_a: [f32; BINS]) -> Self {
        let mean = current_a.iter().sum::<f32>() / BINS as f32;
        current_a.iter_mut().for_each(|entry| *entry -= mean);
        Self { current_a }
    }

    /// The current at an angle, on a straight line between two entries.
    #[inline]
    #[must_use]
    pub fn at(&self, angle: Angle) -> f32 {
        // Half a bin back, modulo one turn: entries belong to the middle of their bins.
        let place = u64::from(angle.bits()).wrapping_mul(BINS as u64).wrapping_add(((BINS as u64) << 32) - HALF);
        let (first, part) = split(place);
        let entry = |place: usize| self.current_a.get(place).copied().unwrap_or(0.0);
        let first = first.checked_rem(BINS).unwrap_or(0);
        let next = first.wrapping_add(1).checked_rem(BINS).unwrap_or(0);
        let (before, after) = (entry(first), entry(next));
        before + part * (after - before)
    }
}

/// Half a bin.
const HALF: u64 = 1 << 31;

/// Whole bins of a place in counts of 2⁻³² bin, and the part of a bin after them.
#[inline(always)]
pub(super) fn split(place: u64) -> (usize, f32) {
    let part = (place & 0xffff_ffff) as f32 / 4_294_967_296.0;
    (usize::try_from(place >> 32).unwrap_or(0), part)
}
