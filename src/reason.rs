//! Why a part of a segment has no result.

use core::fmt;

/// A parameter of the torque balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrictionTerm {
    /// J/Kt, A·s²/rad.
    Inertia,
    /// B/Kt, A·s/rad.
    Viscous,
    /// Tc/Kt, A.
    Coulomb,
    /// 1/Kt, A/(N·m).
    InverseTorqueConstant,
    /// The offset of current and load, A.
    Offset,
    /// μ/Kt, friction in proportion to the load, A/(N·m).
    LoadFriction,
    /// (Ts − Tc)/Kt, what break-away exceeds sliding, A.
    Stribeck,
    /// Tc/Kt + ω₀ B/Kt, the friction at the usual velocity ω₀, A.
    Drag,
}

impl FrictionTerm {
    /// All terms, in the order of the parameters p₀ … p₇ of the torque balance.
    pub const ALL: [Self; 8] = [
        Self::Inertia,
        Self::Viscous,
        Self::Coulomb,
        Self::InverseTorqueConstant,
        Self::Offset,
        Self::LoadFriction,
        Self::Stribeck,
        Self::Drag,
    ];

    /// Whether the term needs a measured load.
    #[must_use]
    pub const fn needs_load(self) -> bool {
        matches!(self, Self::InverseTorqueConstant | Self::LoadFriction)
    }

    /// The term in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Inertia => "inertia",
            Self::Viscous => "viscous friction",
            Self::Coulomb => "Coulomb friction",
            Self::InverseTorqueConstant => "torque constant",
            Self::Offset => "offset",
            Self::LoadFriction => "load friction",
            Self::Stribeck => "Stribeck friction",
            Self::Drag => "drag",
        }
    }
}

/// A part of the detector that gives a result once a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Part {
    /// The regression.
    Regression,
    /// The torque balance of the shaft.
    TorqueBalance,
    /// The bearing orders.
    Orders,
    /// The classifier.
    Classifier,
}

impl Part {
    const fn name(self) -> &'static str {
        match self {
            Self::Regression => "the regression",
            Self::TorqueBalance => "the torque balance",
            Self::Orders => "the bearing orders",
            Self::Classifier => "the classifier",
        }
    }
}

/// Why a part of a segment has no result, or a segment no verdict. A segment in which other parts have results has a
/// verdict without the features of this part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Reason {
    /// The part had too few usable rows or samples.
    TooFewRows {
        /// The part.
        part: Part,
        /// Its number of rows; of the bearing orders, of blocks.
        rows: u32,
    },
    /// Less than half of the segment was usable.
    ShortSegment {
        /// Usable rows.
        rows: u32,
    },
    /// The inputs of the regression hardly changed: see the threshold
    /// [`Regression::rest`](crate::model::Regression::rest).
    AtRest,
    /// The data do not excite this parameter of the regression: place in the δ-parameters. A signal that is constant
    /// over the whole segment ends here. With fading memory the floor hides this once the memory is full;
    /// [`Reason::AtRest`] then applies.
    ParameterNotExcited(u8),
    /// The motion does not excite this term of the torque balance.
    TermNotExcited(FrictionTerm),
    /// The instruments explain hardly more of the output than chance does (F ≤ 10), or are linearly dependent: the
    /// auxiliary model does not fit, or noise hides the output.
    WeakInstruments(Part),
    /// The sensor of this channel repeated one value for too long.
    Stuck {
        /// Place of the channel in the sample.
        channel: u8,
    },
    /// More samples of this channel were refused than used, so that it has no mean.
    LostSamples {
        /// Place of the channel in the sample.
        channel: u8,
    },
    /// A covariate is outside the range of the training records, and nothing is left without it.
    OutOfRange {
        /// Place of the covariate in [`Covariates::list`](crate::model::Covariates::list).
        covariate: u8,
    },
    /// A result of the part is not a finite number.
    NotFinite(Part),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewRows { part: Part::Orders, rows } => {
                write!(f, "the bearing orders have too few blocks ({rows})")
            }
            Self::TooFewRows { part, rows } => write!(f, "{} has too few usable rows ({rows})", part.name()),
            Self::ShortSegment { rows } => write!(f, "less than half of the segment was usable ({rows} rows)"),
            Self::AtRest => f.write_str("the inputs are at rest"),
            Self::ParameterNotExcited(place) => {
                write!(f, "the signals do not excite δ-parameter {} (t, β, γ, constant)", u16::from(*place) + 1)
            }
            Self::TermNotExcited(term) => {
                write!(f, "the motion does not excite the {} in the torque balance", term.name())
            }
            Self::WeakInstruments(part) => {
                write!(f, "the instruments of {} hardly follow the output", part.name())
            }
            Self::Stuck { channel } => write!(f, "the sensor of channel {} is stuck", u16::from(*channel) + 1),
            Self::LostSamples { channel } => {
                write!(f, "more samples of channel {} were refused than used", u16::from(*channel) + 1)
            }
            Self::OutOfRange { covariate } => {
                write!(f, "covariate {} is outside the range of the training records", u16::from(*covariate) + 1)
            }
            Self::NotFinite(part) => write!(f, "a result of {} is not a finite number", part.name()),
        }
    }
}

impl core::error::Error for Reason {}
