//! The kernels on numbers whose results are known, bit by bit: for the boot of a drive.
//!
//! Leaves: nothing, or the first [`ArithmeticFault`] whose results differ from those of the host that trained the
//! model. The causes are outside the core: another rounding mode, subnormal numbers flushed to zero, a compiler
//! option that reorders or contracts operations, a `libm` replaced by the linker, flash or registers that changed.
//!
//! Rounding mode and flushing belong to the context of the processor, not to the program: an Arm core takes those of
//! an interrupt from FPDSCR, whatever `main` has set. [`arithmetic_test`] tests them where it is called; the detector
//! does so with the sample that closes a segment, and the solver where it runs.

use core::fmt;
use core::hint::black_box;

use crate::drive::{HalfBandDecimator, HalfBandTaps};
use crate::reason::ArithmeticFault;
use crate::regression::factor::{EffectiveRows, Problem, Solution, Solved, Triangle};
use crate::signal::{AlphaBeta, Angle, Park};

impl ArithmeticFault {
    /// Hash of the results; the first two parts return 1 if all comparisons hold.
    const fn answer(self) -> u32 {
        match self {
            Self::Rounding | Self::Subnormals => 1,
            Self::Functions => 0x6c4a_f7e5,
            Self::Transforms => 0x14ac_fe63,
            Self::Decimation => 0xf340_1200,
            Self::Factor => 0xdd3e_b6a0,
            Self::Solution => 0xcd08_b4be,
        }
    }

    #[inline(never)]
    fn result(self) -> u32 {
        match self {
            Self::Rounding => u32::from(rounds_to_nearest()),
            Self::Subnormals => u32::from(keeps_subnormals()),
            Self::Functions => functions(),
            Self::Transforms => transforms(),
            Self::Decimation => decimation(),
            Self::Factor => LeastSquares::factor(),
            Self::Solution => LeastSquares::solution(),
        }
    }
}

impl fmt::Display for ArithmeticFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for ArithmeticFault {}

/// Runs every kernel on known numbers and compares each bit of the results. For the boot, before the first sample: with
/// a difference, verdicts are not those that were validated. Call it at boot, and once from the interrupt in which the
/// detector runs, before the power stage is on: the settings of the processor there may be others than in `main`.
///
/// ```
/// bearing_watch::known_answer_test()?;
/// # Ok::<(), bearing_watch::ArithmeticFault>(())
/// ```
///
/// # Errors
/// The first kernel whose results differ.
pub fn known_answer_test() -> Result<(), ArithmeticFault> {
    ArithmeticFault::ALL.into_iter().find(|kernel| kernel.result() != kernel.answer()).map_or(Ok(()), Err)
}

/// The part of [`known_answer_test`] that depends on the settings of the processor where it is called, rounding and
/// subnormal numbers, in a few dozen instructions. A detector does it with the sample that closes a segment, and such a
/// segment has no verdict: [`Reason::Arithmetic`](crate::Reason::Arithmetic).
///
/// # Errors
/// [`ArithmeticFault::Rounding`] or [`ArithmeticFault::Subnormals`].
// Not by `ArithmeticFault::result`, which would bring the code of every kernel into each detector.
#[inline(never)]
pub fn arithmetic_test() -> Result<(), ArithmeticFault> {
    if !rounds_to_nearest() {
        Err(ArithmeticFault::Rounding)
    } else if keeps_subnormals() {
        Ok(())
    } else {
        Err(ArithmeticFault::Subnormals)
    }
}

/// FNV-1a over the bits of results.
struct Hash(u32);

impl Hash {
    const NEW: Self = Self(0x811c_9dc5);

    fn add(&mut self, values: &[f32]) {
        for byte in values.iter().flat_map(|x| x.to_bits().to_le_bytes()) {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }
}

/// Numbers in −1 … 1 by a linear congruential generator (Numerical Recipes).
struct Numbers(u32);

impl Numbers {
    #[expect(clippy::cast_possible_wrap, reason = "takes the sign from the highest bit")]
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (black_box(self.0) as i32) as f32 / 2_147_483_648.0
    }

    fn array<const N: usize>(&mut self) -> [f32; N] {
        [0; N].map(|_| self.next())
    }
}

#[expect(clippy::float_cmp, reason = "exact results are what is tested")]
fn rounds_to_nearest() -> bool {
    let (one, half_unit) = (black_box(1.0_f32), black_box(f32::EPSILON / 2.0));
    let tie_down = one + half_unit == one;
    let tie_up = one + 3.0 * half_unit == 1.0 + 2.0 * f32::EPSILON;
    let negative = -one - half_unit == -1.0;
    // A fused multiply-add would leave the rounding error of the product.
    let root = black_box(1.0 + f32::EPSILON);
    let plain = root * root - (1.0 + 2.0 * f32::EPSILON) == 0.0;
    tie_down && tie_up && negative && plain
}

#[expect(clippy::float_cmp, reason = "exact results are what is tested")]
fn keeps_subnormals() -> bool {
    let least = black_box(f32::MIN_POSITIVE);
    let half = black_box(least * 0.5);
    half.to_bits() == 0x0040_0000 && half + half == least
}

fn functions() -> u32 {
    let (mut hash, mut numbers) = (Hash::NEW, Numbers(1));
    for _ in 0..20 {
        let x = numbers.next();
        hash.add(&[libm::sqrtf(x * x), libm::expf(20.0 * x), libm::logf(x * x + 1e-20), libm::expm1f(x)]);
    }
    hash.0
}

fn transforms() -> u32 {
    let (mut hash, mut numbers) = (Hash::NEW, Numbers(2));
    for k in 0..20_u32 {
        let electrical = Angle::from_bits(black_box(k.wrapping_mul(0x9E37_79B9))).times(6).sin_cos();
        let [a, b] = numbers.array();
        let rotor = Park::Standard.forward(AlphaBeta::from_two(a, b), electrical);
        let back = Park::Thesis.inverse(rotor, electrical).inverse_clarke();
        hash.add(&[electrical.sin, electrical.cos, rotor.d, rotor.q, back.a, back.b, back.c]);
    }
    hash.0
}

fn decimation() -> u32 {
    let (mut hash, mut numbers) = (Hash::NEW, Numbers(3));
    let mut filter = HalfBandDecimator::<1, 1, 4, 13>::new();
    for _ in 0..160 {
        if let Some(output) = filter.push(&HalfBandTaps::SHARP, numbers.array()) {
            hash.add(&output);
        }
    }
    hash.0
}

/// The factor of 30 rows of three columns and a target, and its solution.
#[derive(Debug, Default)]
struct LeastSquares {
    factor: [f32; 10],
    delta: [f32; 3],
    covariance: [f32; 6],
    variance: f32,
}

impl LeastSquares {
    /// Scales of the columns and of the target.
    const SCALE: [f32; 4] = [1.0, 2.0, 0.5, 1.0];

    fn row(numbers: &mut Numbers) -> [f32; 4] {
        let [a, b, c, e] = numbers.array();
        [a, b, c, 0.5 * a - 2.0 * b + 0.25 * c + 0.1 * e]
    }

    fn solve() -> Self {
        let (mut result, mut numbers) = (Self::default(), Numbers(4));
        let mut triangle = Triangle::<[f32; 4], [f32; 6]>::new(4);
        for _ in 0..30 {
            triangle.update(&Self::row(&mut numbers));
        }
        let (d, r) = triangle.parts_mut();
        for (cell, part) in result.factor.iter_mut().zip(d.iter().chain(r.iter())) {
            *cell = *part;
        }
        let mass = EffectiveRows { rows: 30.0, spread: 1.0 };
        let problem = &mut Problem { d, r, inputs: 3, outputs: 0, scale: &Self::SCALE, base: &[], mass, gain: 1.0 };
        let (delta, covariance, variance) = (&mut result.delta, &mut result.covariance, &mut result.variance);
        let solved = &mut Solved { delta, covariance, variance, work: &mut [0.0; 3] };
        // The rows are independent; a refusal leaves zeros, whose hash is another one.
        if let Ok(mut solution) = Solution::new::<false>(problem, solved) {
            while !solution.add_column::<false>(problem, solved) {}
        }
        result
    }

    fn factor() -> u32 {
        let mut hash = Hash::NEW;
        hash.add(&Self::solve().factor);
        hash.0
    }

    fn solution() -> u32 {
        let (result, mut hash) = (Self::solve(), Hash::NEW);
        hash.add(&result.delta);
        hash.add(&result.covariance);
        hash.add(&[result.variance]);
        hash.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answers_are_those_of_this_machine() {
        let wrong = ArithmeticFault::ALL.into_iter().filter(|kernel| kernel.result() != kernel.answer());
        let wrong: std::vec::Vec<_> =
            wrong.map(|kernel| std::format!("{kernel:?} {:#010x}", kernel.result())).collect();
        assert_eq!(wrong, [""; 0]);
        assert_eq!(known_answer_test(), Ok(()));
    }

    /// The numbers whose hash is known are right, by double precision.
    #[test]
    fn the_solution_is_that_of_the_rows() {
        let mut numbers = Numbers(4);
        let (mut gram, mut right) = ([[0.0_f64; 3]; 3], [0.0_f64; 3]);
        for _ in 0..30 {
            let [a, b, c, y] = LeastSquares::row(&mut numbers).map(f64::from);
            let x = [a, b, c];
            for i in 0..3 {
                right[i] += x[i] * y;
                (0..3).for_each(|j| gram[i][j] += x[i] * x[j]);
            }
        }
        // Elimination without exchange: the matrix is positive definite.
        for i in 0..3 {
            for k in i + 1..3 {
                let factor = gram[k][i] / gram[i][i];
                (0..3).for_each(|j| gram[k][j] -= factor * gram[i][j]);
                right[k] -= factor * right[i];
            }
        }
        let mut exact = [0.0_f64; 3];
        for i in (0..3).rev() {
            let rest: f64 = (i + 1..3).map(|j| gram[i][j] * exact[j]).sum();
            exact[i] = (right[i] - rest) / gram[i][i];
        }
        let result = LeastSquares::solve();
        for ((parameter, scale), exact) in result.delta.iter().zip(LeastSquares::SCALE).zip(exact) {
            // A parameter is scaled as its column. Rounding of 30 rows; a row has a part of 3 % in each sum.
            assert!((f64::from(parameter / scale) - exact).abs() < 1e-5, "{result:?} {exact}");
        }
        // σ² of e, uniform in ±1/10: a third of a hundredth; 27 degrees of freedom scatter it by up to 60 %.
        assert!((result.variance / (0.01 / 3.0) - 1.0).abs() < 0.6, "{result:?}");
    }
}
