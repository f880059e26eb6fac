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

    /// The angle (1) of a counter that counts on over turns in both directions, or is reset at each turn.
    #[inline]
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "an angle wraps at one turn")]
    pub const fn angle(self, counts: i32) -> Angle {
        let within = match counts.checked_rem_euclid(self.counts.cast_signed()) {
            Some(within) => within.cast_unsigned(),
            None => 0,
        };
        Angle::from_bits(((within as u64).wrapping_mul(self.scale) >> 16) as u32)
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
