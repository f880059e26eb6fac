//! Angles as binary fractions of a turn.
//!
//! Input: resolver or encoder counts. Output: [`Angle`], and its [`SinCos`].
//!
//! ```text
//! Angle(u32):  θ = 2π · bits / 2³²                                     (1)
//! q = round(4 θ / 2π),  t = θ − q π/2,  |t| ≤ π/4                      (2)
//! sin t ≈ t (1 + t² (s₁ + t² (s₂ + t² s₃)))                            (3)
//! cos t ≈ 1 − t²/2 + t⁴ (c₂ + t² (c₃ + t² c₄))                         (4)
//! ```
//!
//! Integer arithmetic wraps at one turn, so sums, differences and products with a pole-pair number need no range
//! reduction and accumulate no error. Coefficients of (3), (4): Cephes `sinf`/`cosf` minimax polynomials. Absolute
//! error of either function ≤ 2e-7 over the whole circle, including the rounding of `t` to 24 bits.
//!
//! [`Angle::times`] accepts only *integer* multiples: a non-integer multiple would jump at every turn.

use core::f32::consts::PI;

/// A binary fraction of a turn: the whole `u32` range is one turn, with wrap-around.
///
/// ```
/// use bearing_watch::Angle;
/// let quarter = Angle::from_counts(1024, 12); // 12-bit resolver
/// assert_eq!(quarter.times(3), Angle::from_bits(0xC000_0000));
/// let sc = quarter.sin_cos();
/// assert!((sc.sin - 1.0).abs() < 2e-7 && sc.cos.abs() < 2e-7);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Angle(u32);

/// Sine and cosine of one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SinCos {
    /// Sine.
    pub sin: f32,
    /// Cosine.
    pub cos: f32,
}

const S1: f32 = -1.666_665_5e-1;
const S2: f32 = 8.332_161e-3;
const S3: f32 = -1.951_529_6e-4;
const C2: f32 = 4.166_664_6e-2;
const C3: f32 = -1.388_731_6e-3;
const C4: f32 = 2.443_315_7e-5;
/// Radians per count of the 32-bit angle, 2π/2³².
pub(crate) const RAD: f32 = PI / 2_147_483_648.0;

impl Angle {
    /// The zero angle.
    pub const ZERO: Self = Self(0);

    /// Creates an angle from the 32-bit fraction of a turn.
    #[inline]
    #[must_use]
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Creates an angle from the counts of a converter with `resolution_bits` bits per turn; values above 32 bits are
    /// treated as 32. Counts beyond one turn wrap.
    #[inline]
    #[must_use]
    pub const fn from_counts(counts: u32, resolution_bits: u32) -> Self {
        match 32_u32.checked_sub(resolution_bits) {
            Some(shift) if shift < 32 => Self(counts << shift),
            Some(_) => Self(0),
            None => Self(counts),
        }
    }

    /// Creates an angle from radians, of either sign and any number of turns; NaN and infinity return zero.
    ///
    /// An `f32` of many turns has lost its fraction to rounding: use counts if the drive has them.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the value is within one turn, and i64 → u32 wraps on purpose"
    )]
    pub fn from_radians(radians: f32) -> Self {
        let turns = radians * (0.5 / PI);
        if !(-1e9..=1e9).contains(&turns) {
            return Self(0);
        }
        // The cast truncates toward zero; the remainder is a fraction in (−1, 1), exact by Sterbenz' lemma or
        // trivially.
        let whole = turns as i32 as f32;
        Self(((turns - whole) * 4_294_967_296.0) as i64 as u32)
    }

    /// The 32-bit fraction of a turn.
    #[inline]
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Radians in [−π, π]; the upper end occurs only by rounding.
    #[inline]
    #[must_use]
    pub fn radians(self) -> f32 {
        self.0.cast_signed() as f32 * RAD
    }

    /// Integer multiple, for pole pairs: mechanical → electrical angle.
    #[inline]
    #[must_use]
    pub const fn times(self, pole_pairs: u32) -> Self {
        Self(self.0.wrapping_mul(pole_pairs))
    }

    /// The angle with opposite sign, for a sensor that counts against the phase sequence.
    #[inline]
    #[must_use]
    pub const fn negated(self) -> Self {
        Self(self.0.wrapping_neg())
    }

    /// Sum, modulo one turn.
    #[inline]
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }

    /// The angle `counts` of 2⁻³² turn further on.
    #[inline]
    #[must_use]
    pub(crate) const fn turned(self, counts: i32) -> Self {
        Self(self.0.wrapping_add_signed(counts))
    }

    /// The shorter rotation from `earlier` to `self`, in counts of 2⁻³² turn; negative means backward.
    #[inline]
    #[must_use]
    pub const fn since(self, earlier: Self) -> i32 {
        self.0.wrapping_sub(earlier.0).cast_signed()
    }

    /// Sine and cosine, absolute error ≤ 2e-7.
    #[inline]
    #[must_use]
    pub fn sin_cos(self) -> SinCos {
        let q = self.0.wrapping_add(0x2000_0000) >> 30; // (2)
        let t = self.0.wrapping_sub(q << 30).cast_signed() as f32 * RAD;
        let t2 = t * t;
        let s = t + t * (t2 * (S1 + t2 * (S2 + t2 * S3))); // (3)
        let c = (1.0 - 0.5 * t2) + (t2 * t2) * (C2 + t2 * (C3 + t2 * C4)); // (4)
        let (sin, cos) = if q & 1 == 0 { (s, c) } else { (c, s) };
        // Quadrants 2 and 3 have a negative sine, 1 and 2 a negative cosine; the sign bit is set without branches.
        SinCos {
            sin: f32::from_bits(sin.to_bits() ^ ((q & 2) << 30)),
            cos: f32::from_bits(cos.to_bits() ^ ((q.wrapping_add(1) & 2) << 30)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(bits: u32) -> f64 {
        let exact = core::f64::consts::TAU * f64::from(bits) / 4_294_967_296.0;
        let sc = Angle::from_bits(bits).sin_cos();
        let (s, c) = (exact.sin(), exact.cos());
        (f64::from(sc.sin) - s).abs().max((f64::from(sc.cos) - c).abs())
    }

    #[test]
    fn sin_cos_is_within_2e_7_everywhere() {
        // An odd stride distributes 2²² angles over the circle; octant edges and their neighbours are added.
        let sampled = (0..1_u32 << 22).map(|k| k.wrapping_mul(1021)).map(error);
        let edges =
            (0..8_u32).flat_map(|octant| (-64_i32..=64).map(move |k| (octant << 29).wrapping_add_signed(k))).map(error);
        let worst = sampled.chain(edges).fold(0.0, f64::max);
        assert!(worst <= 2e-7, "{worst}");
        assert!(worst > 1e-8, "an f32 result cannot be this good: {worst}");
    }

    #[test]
    fn pole_pairs_wrap_without_drift() {
        let mechanical = Angle::from_counts(3, 2); // 270°
        assert_eq!(mechanical.times(6), Angle::from_counts(2, 2)); // 1620° = 180°
    }

    #[test]
    fn difference_takes_the_short_way() {
        let before = Angle::from_counts(16_383, 14);
        let after = Angle::from_counts(1, 14);
        assert_eq!(after.since(before), 2 << 18);
        assert_eq!(before.since(after), -(2 << 18));
        assert_eq!(after.plus(after.negated()), Angle::ZERO);
    }

    #[test]
    fn radians_round_trip_and_refuse_nonsense() {
        for k in -100..=100_i16 {
            let x = f32::from(k) * 0.031;
            // An `f32` number of turns of order one has a resolution of 2⁻²⁴ of a turn = 3.7e-7 rad.
            assert!((Angle::from_radians(x).radians() - x).abs() < 1e-6, "{x}");
        }
        assert_eq!(Angle::from_radians(f32::NAN), Angle::ZERO);
        assert_eq!(Angle::from_radians(f32::INFINITY), Angle::ZERO);
        assert_eq!(Angle::from_counts(5, 0), Angle::ZERO);
        assert_eq!(Angle::from_counts(5, 40).bits(), 5);
    }

    #[test]
    fn whole_turns_cost_no_more_than_the_rounding_of_their_number() {
        for k in -200..=200_i16 {
            let radians = f32::from(k) * 0.777;
            let exact = f64::from(radians) / core::f64::consts::TAU;
            let off = f64::from(Angle::from_radians(radians).bits()) / 4_294_967_296.0 - exact;
            // Of 1/2π and of the product, half a last digit each; and half a count.
            let most = exact.abs() * 2.0_f64.powi(-23) + 2.0_f64.powi(-32);
            assert!((off - off.round()).abs() <= most, "{radians}: {off}");
        }
    }
}
