//! Reference frames: three phases, stator (αβ), rotor (dq).
//!
//! Input: [`Abc`] and a [`SinCos`] of the *electrical* angle. Output: [`AlphaBeta`], [`Dq0`], and the inverse
//! transforms.
//!
//! ```text
//! α = (2a − b − c)/3,   β = (b − c)/√3,   0 = (a + b + c)/3              (1) Clarke, amplitude-invariant
//! d =  α cos θ + β sin θ                                                 (2)
//! q = −α sin θ + β cos θ      Park::Standard: q > 0 drives, θ on the magnet axis   (3)
//! q =  α sin θ − β cos θ      Park::Thesis: the +sin row of thesis Eq. 5.1         (4)
//! ```
//!
//! Amplitude-invariant: a balanced system of amplitude I has |αβ| = |dq| = I. The types state the frame, not the unit:
//! currents (A) and voltages (V) are transformed in the same way. The transforms compute no trigonometric functions:
//! the caller passes the [`SinCos`], from [`Angle::sin_cos`](super::Angle::sin_cos), a table or a CORDIC unit.

use super::angle::SinCos;

const THIRD: f32 = 1.0 / 3.0;
/// 1/√3
const INV_SQRT_3: f32 = 0.577_350_26;
/// √3/2
const HALF_SQRT_3: f32 = 0.866_025_4;

/// Three phase quantities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Abc {
    /// Phase a.
    pub a: f32,
    /// Phase b.
    pub b: f32,
    /// Phase c.
    pub c: f32,
}

/// The stator frame, with the zero sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AlphaBeta {
    /// Along phase a.
    pub alpha: f32,
    /// 90° ahead of phase a.
    pub beta: f32,
    /// Zero sequence, (a + b + c)/3.
    pub zero: f32,
}

/// The rotor frame, with the zero sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Dq0 {
    /// Direct axis.
    pub d: f32,
    /// Quadrature axis.
    pub q: f32,
    /// Zero sequence.
    pub zero: f32,
}

/// Sign convention of the quadrature axis; there is no default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Park {
    /// Equation (3), used by most drives. With θ on the magnet axis a positive q current drives forward.
    Standard,
    /// Equation (4), thesis Eq. 5.1: `ia = I sin θ` gives `q = I`.
    Thesis,
}

impl Abc {
    /// Clarke transform (1).
    #[inline]
    #[must_use]
    pub fn clarke(self) -> AlphaBeta {
        let zero = (self.a + self.b + self.c) * THIRD;
        AlphaBeta { alpha: self.a - zero, beta: (self.b - self.c) * INV_SQRT_3, zero }
    }
}

impl AlphaBeta {
    /// Clarke transform of two phase quantities if the sum of all three is zero: `α = a, β = (a + 2b)/√3`.
    #[inline]
    #[must_use]
    pub fn from_two(a: f32, b: f32) -> Self {
        Self { alpha: a, beta: (a + 2.0 * b) * INV_SQRT_3, zero: 0.0 }
    }

    /// Inverse Clarke transform.
    #[inline]
    #[must_use]
    pub fn inverse_clarke(self) -> Abc {
        let half = self.zero - 0.5 * self.alpha;
        let side = HALF_SQRT_3 * self.beta;
        Abc { a: self.alpha + self.zero, b: half + side, c: half - side }
    }
}

impl Park {
    /// Park transform (2) with (3) or (4).
    #[inline]
    #[must_use]
    pub fn forward(self, v: AlphaBeta, electrical: SinCos) -> Dq0 {
        let SinCos { sin, cos } = electrical;
        let d = v.alpha * cos + v.beta * sin; // (2)
        let q = v.beta * cos - v.alpha * sin; // (3)
        Dq0 { d, q: self.sign(q), zero: v.zero }
    }

    /// Inverse Park transform.
    #[inline]
    #[must_use]
    pub fn inverse(self, v: Dq0, electrical: SinCos) -> AlphaBeta {
        let SinCos { sin, cos } = electrical;
        let q = self.sign(v.q);
        AlphaBeta { alpha: v.d * cos - q * sin, beta: v.d * sin + q * cos, zero: v.zero }
    }

    /// (4) is (3) with the opposite sign of q.
    #[inline]
    fn sign(self, q: f32) -> f32 {
        match self {
            Self::Standard => q,
            Self::Thesis => -q,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::Angle;

    /// One rounding of values up to 10 is 1e-6; these computations have fewer than five.
    const TOLERANCE: f32 = 5e-6;

    fn close(x: f32, y: f32) -> bool {
        (x - y).abs() < TOLERANCE
    }

    #[test]
    fn thesis_convention_by_hand() {
        // ia = I sin θ, balanced: Id = 0, Iq = I in Eq. 5.1's convention, −I in the standard one.
        let theta = 0.7_f64;
        let phase = |k: f64| (4.0 * (theta - k * core::f64::consts::TAU / 3.0).sin()) as f32;
        let v = Abc { a: phase(0.0), b: phase(1.0), c: phase(2.0) }.clarke();
        let sc = Angle::from_radians(0.7).sin_cos();
        let thesis = Park::Thesis.forward(v, sc);
        let standard = Park::Standard.forward(v, sc);
        assert!(close(thesis.d, 0.0) && close(thesis.q, 4.0), "{thesis:?}");
        assert!(close(standard.d, 0.0) && close(standard.q, -4.0), "{standard:?}");
    }

    #[test]
    fn matrix_of_equation_5_1() {
        let (currents, theta) = ([1.5_f64, -0.25, 3.0], 2.1_f64);
        let third = core::f64::consts::TAU / 3.0;
        let row = |f: fn(f64) -> f64| {
            let angles = [theta, theta - third, theta + third];
            2.0 / 3.0 * angles.iter().zip(currents).map(|(&x, i)| f(x) * i).sum::<f64>()
        };
        let [a, b, c] = currents.map(|x| x as f32);
        let out = Park::Thesis.forward(Abc { a, b, c }.clarke(), Angle::from_radians(2.1).sin_cos());
        assert!(close(out.d, row(f64::cos) as f32) && close(out.q, row(f64::sin) as f32));
        assert!(close(out.zero, 4.25 / 3.0));
    }

    #[test]
    fn round_trip_and_two_sensors() {
        for k in 0..64_u32 {
            let sc = Angle::from_counts(k, 6).sin_cos();
            let x = Abc { a: 3.0, b: -7.5, c: 1.25 };
            for park in [Park::Standard, Park::Thesis] {
                let back = park.inverse(park.forward(x.clarke(), sc), sc).inverse_clarke();
                assert!(close(back.a, x.a) && close(back.b, x.b) && close(back.c, x.c));
            }
        }
        let two = AlphaBeta::from_two(2.0, -5.0);
        let three = Abc { a: 2.0, b: -5.0, c: 3.0 }.clarke();
        assert!(close(two.alpha, three.alpha) && close(two.beta, three.beta) && close(three.zero, 0.0));
    }
}
