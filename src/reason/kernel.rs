//! The parts of the arithmetic that a processor may compute in another way than the host.

/// A part of the core's arithmetic, in the order of the test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ArithmeticFault {
    /// Sums and products are not rounded to nearest, ties to even.
    Rounding,
    /// Numbers below 1.2e-38 are flushed to zero (FPSCR.FZ on Arm).
    Subnormals,
    /// Square root, exponential and logarithm of `libm`.
    Functions,
    /// Sine and cosine of binary angles, Clarke and Park transforms.
    Transforms,
    /// Half-band decimation.
    Decimation,
    /// The triangular factor of a least-squares problem.
    Factor,
    /// Its solution.
    Solution,
}

impl ArithmeticFault {
    /// All parts, in the order of the test.
    pub const ALL: [Self; 7] = [
        Self::Rounding,
        Self::Subnormals,
        Self::Functions,
        Self::Transforms,
        Self::Decimation,
        Self::Factor,
        Self::Solution,
    ];

    /// What is wrong, in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Rounding => "numbers are not rounded to nearest, ties to even",
            Self::Subnormals => "subnormal numbers are flushed to zero",
            Self::Functions => "square root, exponential or logarithm differ from those of the host",
            Self::Transforms => "sine, cosine, Clarke or Park transform differ from those of the host",
            Self::Decimation => "decimation differs from that of the host",
            Self::Factor => "the triangular factor differs from that of the host",
            Self::Solution => "the solution of a least-squares problem differs from that of the host",
        }
    }
}
