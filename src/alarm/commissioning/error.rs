//! Why a segment or a whole commissioning is refused.

use core::fmt;

use crate::reason::Reason;

/// A refusal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CommissioningError {
    /// A constant is out of range, or the fewest segments are too few for the weights and the number of coordinates.
    Constants,
    /// The model has no healthy class.
    NoHealthyClass,
    /// The segment has no verdict, for this reason. It is not used.
    NoVerdict(Reason),
    /// A feature of this coordinate is missing. The segment is not used.
    Missing {
        /// Place of the coordinate.
        coordinate: u8,
    },
    /// The variance of the coordinate's error exceeds ten times its variance over the trained healthy segments. The
    /// segment is not used.
    Uncertain {
        /// Place of the coordinate.
        coordinate: u8,
    },
    /// The segment is farther from the trained healthy mean than allowed. It is not used, but counted.
    TooFar {
        /// Its distance, trained standard deviations.
        distance: f32,
    },
    /// There are as many segments as single precision can sum.
    Full,
    /// Too few segments were gathered.
    TooFew {
        /// Number of segments gathered.
        gathered: u32,
        /// Number of segments needed.
        needed: u32,
    },
    /// More than a tenth of the segments were too far.
    TooManyFar {
        /// Number of segments that were too far.
        far: u32,
        /// Number of segments gathered.
        gathered: u32,
    },
    /// The segments scatter more than allowed.
    TooWide {
        /// Their mean variance, relative to that of the trained healthy segments.
        ratio: f32,
    },
    /// A resulting number is not finite or out of range: the segments hold extreme values.
    OutOfRange,
}

impl CommissioningError {
    /// The error in words.
    #[must_use]
    pub const fn message(&self) -> &'static str {
        match self {
            Self::Constants => "a constant of the commissioning is out of range, or its segments are too few",
            Self::NoHealthyClass => "the model has no healthy class",
            Self::NoVerdict(_) => "the segment has no verdict",
            Self::Missing { .. } => "a feature of the segment is missing",
            Self::Uncertain { .. } => "the error of a feature of the segment is too large",
            Self::TooFar { .. } => "the segment is too far from the trained healthy mean",
            Self::Full => "no more segments can be summed",
            Self::TooFew { .. } => "too few segments were gathered",
            Self::TooManyFar { .. } => "too many segments are too far from the trained healthy mean",
            Self::TooWide { .. } => "the segments scatter too much",
            Self::OutOfRange => "a number of the healthy class is out of range",
        }
    }
}

impl fmt::Display for CommissioningError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoVerdict(reason) => write!(f, "the segment has no verdict: {reason}"),
            Self::Missing { coordinate } => {
                write!(f, "a feature of coordinate {} is missing", u16::from(*coordinate) + 1)
            }
            Self::Uncertain { coordinate } => {
                write!(f, "the error of coordinate {} of the segment is too large", u16::from(*coordinate) + 1)
            }
            Self::TooFew { gathered, needed } => write!(f, "{gathered} segments were gathered, {needed} are needed"),
            Self::TooManyFar { far, gathered } => {
                write!(f, "{far} segments are too far from the trained healthy mean, beside {gathered} that are not")
            }
            other => f.write_str(other.message()),
        }
    }
}

impl core::error::Error for CommissioningError {}
