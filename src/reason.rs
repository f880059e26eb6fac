//! Why a part of a segment has no result.

mod codes;
mod kernel;

pub use codes::ReasonCode;
pub use kernel::ArithmeticFault;

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
    /// (Ts − Tc)/Kt, the excess of break-away friction over sliding friction, A.
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

/// What is wrong with the signals of a segment: its torque balance contradicts the healthy one of the model, or its
/// velocity the angle.
///
/// Signs and scales are relative to the signals of training. The signal is named whose error explains both inertia J/Kt
/// and torque constant 1/Kt: an error of the current changes both, one of the load 1/Kt alone, and one of velocity,
/// angle or sampling rate J/Kt alone. Errors of two signals may look like one of the third.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Implausible {
    /// The current has the opposite sign.
    CurrentSign,
    /// The load has the opposite sign.
    LoadSign,
    /// Velocity and angle, or the angle alone in a plan that differentiates it, have the opposite sign.
    MotionSign,
    /// A signal has the opposite sign; which one is not known, as inertia or torque constant is not determined.
    Sign,
    /// The current follows neither motion nor load: it is transformed at a wrong angle (pole pairs, phase order,
    /// electrical offset), or that of another motor.
    Current,
    /// The gain or unit of the current is wrong.
    CurrentScale,
    /// The gain or unit of the load is wrong.
    LoadScale,
    /// The sampling rate or the unit of the velocity is wrong, or the shaft drives another inertia.
    MotionScale,
    /// The gain of a signal or the sampling rate is wrong; which one is not known, as inertia or torque constant is not
    /// determined.
    Scale,
    /// The velocity has the sign opposite to the motion of the angle.
    VelocitySign,
    /// The integral of the velocity is not the motion of the angle: the sampling rate or the unit of the velocity is
    /// wrong.
    VelocityScale,
    /// The torque constant is far from that of training, by less than a factor of √2: the gain of all currents or of
    /// the load has changed, or the magnet; a bearing does not change it.
    TorqueConstant,
    /// The rows do not come at the rate of the model, by a clock ([`RateCheck`](crate::RateCheck)): each comes twice,
    /// or the timer of the samples is wrong.
    Rate,
    /// The angle stands while the velocity turns or the current changes: its sensor is stuck, or, without a velocity of
    /// its own, the shaft is held.
    StuckAngle,
    /// The angle makes steps that no motor makes: rows are lost without a number that tells it, or its sensor slips.
    AngleSteps,
    /// The front end has not seen yet that the currents turn with the rotor ([`Alignment`](crate::drive::Alignment)).
    WiringUndecided,
    /// The currents do not turn with the rotor: phase order, direction of the angle or pole pairs.
    Wiring,
}

impl Implausible {
    /// All errors, in the order of their numbers in the C interface and in frames.
    pub const ALL: [Self; 17] = [
        Self::CurrentSign,
        Self::LoadSign,
        Self::MotionSign,
        Self::Sign,
        Self::CurrentScale,
        Self::LoadScale,
        Self::MotionScale,
        Self::Scale,
        Self::VelocitySign,
        Self::VelocityScale,
        Self::Current,
        Self::TorqueConstant,
        Self::Rate,
        Self::StuckAngle,
        Self::AngleSteps,
        Self::WiringUndecided,
        Self::Wiring,
    ];

    /// The error in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::CurrentSign => "the current has the wrong sign",
            Self::LoadSign => "the load has the wrong sign",
            Self::MotionSign => "velocity and angle have the wrong sign",
            Self::Sign => "current, load or velocity has the wrong sign",
            Self::Current => {
                "the current follows neither motion nor load: pole pairs, phase order or electrical offset"
            }
            Self::CurrentScale => "gain or unit of the current is wrong",
            Self::LoadScale => "gain or unit of the load is wrong",
            Self::MotionScale => "sampling rate, unit of the velocity or inertia is wrong",
            Self::Scale => "gain of current or load, unit of the velocity or sampling rate is wrong",
            Self::VelocitySign => "velocity and angle have opposite signs",
            Self::VelocityScale => "the velocity is not that of the angle: sampling rate or unit is wrong",
            Self::TorqueConstant => "gain of all currents or of the load differs from that of training, or the magnet",
            Self::Rate => "the rows do not come at the rate of the model",
            Self::StuckAngle => {
                "the angle stands while velocity or current change: its sensor is stuck, or the shaft held"
            }
            Self::AngleSteps => "the angle makes steps that no motor makes: rows are lost, or its sensor slips",
            Self::WiringUndecided => "the check of the wiring has not decided yet",
            Self::Wiring => {
                "the currents do not turn with the rotor: phase order, direction of the angle or pole pairs"
            }
        }
    }
}

impl fmt::Display for Implausible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

/// Why a segment would not have shown a defect of an acceptable size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Obstacle {
    /// The shaft turned too little for the bearing orders.
    TooLittleMotion,
    /// The noise at the bearing orders is too large.
    TooNoisy,
}

impl Obstacle {
    /// All obstacles, in the order of their numbers in the C interface and in frames.
    pub const ALL: [Self; 2] = [Self::TooLittleMotion, Self::TooNoisy];

    /// The obstacle in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::TooLittleMotion => "the shaft turned too little for the bearing orders",
            Self::TooNoisy => "the bearing orders are too noisy",
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
    /// The shaft hardly moved, or the inputs of the regression hardly changed: see the threshold
    /// [`Regression::rest`](crate::model::Regression::rest).
    AtRest,
    /// The data do not excite this parameter of the regression: index among the δ-parameters. A signal that is constant
    /// over the whole segment ends here. A full fading memory keeps what it knows of a parameter that is excited no
    /// longer ([`Reason::AtRest`] then applies); one that was not excited while it filled ends here too.
    ParameterNotExcited(u8),
    /// The motion does not excite this term of the torque balance.
    TermNotExcited(FrictionTerm),
    /// The instruments explain hardly more of the output than chance does (F ≤ 10), or are linearly dependent: the
    /// auxiliary model does not fit, or noise hides the output.
    WeakInstruments(Part),
    /// The sensor of this channel repeated one value for too long.
    Stuck {
        /// Index of the channel in the sample.
        channel: u8,
    },
    /// More samples of this channel were refused than used, so that it has no mean.
    LostSamples {
        /// Index of the channel in the sample.
        channel: u8,
    },
    /// A covariate is outside the range of the training records, and nothing is left without it.
    OutOfRange {
        /// Place of the covariate in [`Covariates::list`](crate::model::Covariates::list).
        covariate: u8,
    },
    /// A result of the part is not a finite number.
    NotFinite(Part),
    /// The signals contradict the model or each other: wrong wiring, unit or sampling rate.
    Implausible(Implausible),
    /// The processor does not compute as the host does where the detector runs
    /// ([`arithmetic_test`](crate::arithmetic_test)): an interrupt may have settings of its own.
    Arithmetic(ArithmeticFault),
    /// The segment or its decision is that of another model.
    OtherModel,
    /// A fault that shows only after a window of samples was found in the first half of the next segment, and may have
    /// begun in this one ([`Detector::discard`](crate::Detector::discard)).
    FoundLate,
    /// Healthy is the most plausible class, but the segment would not have shown an acceptable defect, for the sizes
    /// in [`Report::smallest`](crate::Report::smallest).
    Unseen(Obstacle),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewRows { part: Part::Orders, rows } => {
                write!(f, "the bearing orders have too few blocks ({rows})")
            }
            Self::TooFewRows { part, rows } => write!(f, "{} has too few usable rows ({rows})", part.name()),
            Self::ShortSegment { rows } => write!(f, "less than half of the segment was usable ({rows} rows)"),
            Self::AtRest => f.write_str("the shaft or the inputs are at rest"),
            Self::ParameterNotExcited(index) => {
                write!(f, "the signals do not excite δ-parameter {} (t, β, γ, constant)", u16::from(*index) + 1)
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
            Self::Implausible(error) => f.write_str(error.message()),
            Self::Arithmetic(kernel) => write!(f, "{} where the detector runs", kernel.message()),
            Self::OtherModel => f.write_str("the segment is that of another model"),
            Self::Unseen(obstacle) => f.write_str(obstacle.message()),
            Self::FoundLate => f.write_str("a fault that was found after the segment may have begun in it"),
        }
    }
}

impl core::error::Error for Reason {}
