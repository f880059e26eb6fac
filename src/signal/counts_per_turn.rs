//! Counts of an encoder whose turn has any number of counts → angles.
//!
//! ```text
//! θ · 2³²/2π = ⌊(n mod N) s / 2¹⁶⌋,   s = ⌊2⁴⁸/N⌋ + 1                                       (1)
//! ```
//!
//! Of N < 2²⁴ counts, (1) is at most 2⁸ · 2⁻³² turn too large, 4·10⁻⁷ rad, and the angles of neighbouring counts differ
//! by 2³²/N within the same.

use super::Angle;

/// The number of counts of a turn.
///
/// ```
/// use bearing_watch::EncoderCounts;
/// const ENCODER: EncoderCounts = EncoderCounts::new(8000).unwrap(); // 2000 lines
/// assert_eq!(ENCODER.angle(-2000), ENCODER.angle(6000));
/// assert!((ENCODER.angle(-2000).radians() + core::f32::consts::FRAC_PI_2).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EncoderCounts {
    counts: u32,
    scale: u64,
}

impl EncoderCounts {
    /// Largest number of counts a turn.
    pub const MOST: u32 = (1 << 24) - 1;

    /// `None` for no counts and for more than [`EncoderCounts::MOST`].
    #[must_use]
    pub const fn new(counts: u32) -> Option<Self> {
        match (1_u64 << 48).checked_div(counts as u64) {
            Some(quotient) if counts <= Self::MOST => Some(Self { counts, scale: quotient.wrapping_add(1) }),
            Some(_) | None => None,
        }
    }

    /// The angle (1) of a counter that counts on over turns in both directions, or is reset at each turn. A counter
    /// that may reach its end, 2³¹ counts, passes [`TurnCounter::within`] before.
    #[inline]
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "an angle wraps at one turn")]
    pub const fn angle(self, counts: i32) -> Angle {
        let within = within(counts, self).cast_unsigned();
        Angle::from_bits(((within as u64).wrapping_mul(self.scale) >> 16) as u32)
    }
}

/// A counter of 32 bits that counts on over turns, without an end: it wraps at 2³² counts, which are no whole number of
/// turns, and [`EncoderCounts::angle`] of it would jump there. The counts within the turn are summed from differences,
/// and are those of a counter that is reset at each turn:
///
/// ```text
/// n(k) = (n(k−1) + c(k) − c(k−1)) mod N,   c(k) − c(k−1) modulo 2³², nearest to zero              (2)
/// ```
///
/// ```
/// use bearing_watch::{EncoderCounts, TurnCounter};
/// const ENCODER: EncoderCounts = EncoderCounts::new(8000).unwrap();
/// let mut counter = TurnCounter::new(ENCODER);
/// let last = counter.within(i32::MAX);
/// assert_eq!(counter.within(i32::MIN), last + 1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TurnCounter {
    turn: EncoderCounts,
    last: i32,
    within: i32,
}

impl TurnCounter {
    /// Not read yet.
    #[must_use]
    pub const fn new(turn: EncoderCounts) -> Self {
        Self { turn, last: 0, within: 0 }
    }

    /// Behind this reading, which had so many counts within the turn.
    #[must_use]
    pub const fn after(turn: EncoderCounts, last: i32, within: i32) -> Self {
        Self { turn, last, within: self::within(within, turn) }
    }

    /// Takes a reading of the counter; returns the counts within the turn, for the reading of a drive or for
    /// [`EncoderCounts::angle`]. Between two readings lie less than 2³¹ counts.
    pub const fn within(&mut self, counts: i32) -> i32 {
        // Both parts are below 2²⁴, so that their sum does not wrap, and (2) is exact.
        let step = within(counts.wrapping_sub(self.last), self.turn);
        self.within = within(self.within.wrapping_add(step), self.turn);
        self.last = counts;
        self.within
    }
}

/// Counts modulo those of a turn.
#[inline]
const fn within(counts: i32, turn: EncoderCounts) -> i32 {
    match counts.checked_rem_euclid(turn.counts.cast_signed()) {
        Some(within) => within,
        None => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_a_division_for_any_number_of_counts() {
        for turn in [1, 2, 3, 7, 1000, 4000, 4096, 8000, 16_384, 10_000_000, EncoderCounts::MOST] {
            let encoder = EncoderCounts::new(turn).unwrap();
            let step = (turn / 997).max(1) as usize;
            for within in (0..turn).step_by(step).chain([turn - 1]) {
                let exact = ((u64::from(within) << 32) / u64::from(turn)) as u32;
                let signed = within.cast_signed();
                for counts in [signed, signed.wrapping_sub_unsigned(turn), signed + 3 * turn.cast_signed()] {
                    let off = encoder.angle(counts).bits().wrapping_sub(exact);
                    assert!(off <= 256, "{counts} of {turn}: {off}");
                }
            }
        }
        assert!(EncoderCounts::new(0).is_none() && EncoderCounts::new(EncoderCounts::MOST + 1).is_none());
    }

    #[test]
    fn powers_of_two_are_those_of_bits() {
        for bits in 1..24 {
            let encoder = EncoderCounts::new(1 << bits).unwrap();
            for counts in [0, 1, 2, (1 << bits) - 1, 12_345 & ((1 << bits) - 1)] {
                let off = encoder.angle(counts).bits() - Angle::from_counts(counts.cast_unsigned(), bits).bits();
                assert!(off <= 256, "{counts} of 2^{bits}: {off}");
            }
        }
    }

    /// Both ways over both ends of the counter, in small and in large steps.
    #[test]
    fn a_counter_has_no_end() {
        for turn in [1, 3, 8000, EncoderCounts::MOST] {
            let mut counter = TurnCounter::new(EncoderCounts::new(turn).unwrap());
            let mut exact = 0_i64;
            for step in [7, 2_000_000_000, 147_483_600, 100, -250, i32::MIN + 1, -77, i32::MAX, i32::MAX, 5] {
                exact += i64::from(step);
                let within = counter.within(exact as i32);
                assert_eq!(i64::from(within), exact.rem_euclid(i64::from(turn)), "{exact} of {turn}");
            }
        }
    }

    #[test]
    fn the_ends_of_the_counter_are_angles_too() {
        let encoder = EncoderCounts::new(8000).unwrap();
        for counts in [i32::MIN, i32::MAX, -1, 0] {
            let exact = f64::from(counts).rem_euclid(8000.0) / 8000.0;
            let off = f64::from(encoder.angle(counts).bits()) / 4_294_967_296.0 - exact;
            assert!(off.abs() < 1e-9, "{counts}: {off}");
        }
    }
}
