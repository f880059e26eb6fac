//! Why a model is refused, and the field that is concerned.

use crate::plan::LayoutError;
use crate::signal::Park;

/// A field of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[expect(missing_docs, reason = "each variant is named as its field; `name` has the words")]
pub enum Field {
    SamplingInterval,
    BlockMean,
    SegmentLength,
    ChannelName,
    ChannelLimit,
    Saturation,
    StuckSamples,
    ColumnScale,
    LimitTimesScale,
    NominalModel,
    NominalStability,
    RestThreshold,
    Settling,
    Handover,
    ForgettingFactor,
    ForgettingFloor,
    SignalLag,
    BalanceInterval,
    BalanceFilter,
    RowInterval,
    BalanceVelocity,
    BalanceScale,
    BalanceNominal,
    BalancePrior,
    LargestChange,
    BearingOrder,
    OrderBlock,
    Feature,
    Covariate,
    Projection,
    ClassDensity,
    Prior,
    Cost,
    HealthyClass,
    HealthyDensity,
    SurpriseCurve,
    NoveltyLimit,
    /// At most all coordinates rise, and only with a shaft.
    RisingCoordinates,
    /// At most 8, and only with a healthy class.
    Direction,
    Evidence,
    Label,
    Layout,
    Notes,
    Flags,
}

impl Field {
    /// The field in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SamplingInterval => "sampling interval",
            Self::BlockMean => "block mean",
            Self::SegmentLength => "segment length",
            Self::ChannelName => "channel name or unit",
            Self::ChannelLimit => "channel limit",
            Self::Saturation => "saturation",
            Self::StuckSamples => "number of stuck samples",
            Self::ColumnScale => "column scale",
            Self::LimitTimesScale => "channel limit times column scale",
            Self::NominalModel => "nominal model",
            Self::NominalStability => "nominal model (it must be stable)",
            Self::RestThreshold => "rest threshold",
            Self::Settling => "settling time in relation to the segment length",
            Self::Handover => "handover",
            Self::ForgettingFactor => "forgetting factor",
            Self::ForgettingFloor => "forgetting floor",
            Self::SignalLag => "lag of a signal of the shaft",
            Self::BalanceInterval => "sampling interval of the torque balance",
            Self::BalanceFilter => "filter of the torque balance",
            Self::RowInterval => "row interval of the torque balance",
            Self::BalanceVelocity => "velocity of the Coulomb sign, of the Stribeck friction or of the drag",
            Self::BalanceScale => "scale of the torque balance",
            Self::BalanceNominal => "nominal torque balance",
            Self::BalancePrior => "prior deviation of the torque balance",
            Self::LargestChange => "largest change of the motion",
            Self::BearingOrder => "bearing order or its weights",
            Self::OrderBlock => "cells, slip, controls or filter of the order tracking",
            Self::Feature => "feature",
            Self::Covariate => "range or coefficients of a covariate",
            Self::Projection => "projection",
            Self::ClassDensity => "class density",
            Self::Prior => "class prior",
            Self::Cost => "cost",
            Self::HealthyClass => "healthy class",
            Self::HealthyDensity => "healthy density",
            Self::SurpriseCurve => "surprise curve",
            Self::NoveltyLimit => "novelty limit",
            Self::RisingCoordinates => "rising coordinates",
            Self::Direction => "direction that the alarm watches",
            Self::Evidence => "evidence constants",
            Self::Label => "class label",
            Self::Layout => "layout",
            Self::Notes => "notes",
            Self::Flags => "header flags",
        }
    }
}

/// Why a model is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ModelError {
    /// The parts of the layout do not fit each other.
    Layout(LayoutError),
    /// The model is for another plan.
    OtherPlan,
    /// A channel of the model has another name or unit than that of the plan.
    Channel {
        /// Index of the channel in the sample.
        index: u8,
    },
    /// The front end has another sign convention than the recordings on which the model was trained.
    Park {
        /// Convention of the recordings.
        trained: Park,
        /// Convention of the front end.
        given: Park,
    },
    /// The sampling interval differs from that of the recordings on which the model was trained.
    Interval {
        /// Interval of the recordings, s.
        trained_s: f32,
        /// The other interval, s.
        given_s: f32,
    },
    /// A list has not the length that the layout requires.
    Length(Field),
    /// A value is out of range or not finite.
    OutOfRange(Field),
    /// The bytes are not a model.
    NotAModel,
    /// The bytes are a model of another format version.
    Version {
        /// Version of the bytes.
        given: u16,
        /// Version that this build reads.
        supported: u16,
    },
    /// There are fewer or more bytes than the header says.
    Truncated,
    /// The checksum does not match the content.
    Checksum,
    /// The buffer is too small for the model.
    BufferTooSmall,
}

impl ModelError {
    /// The kind of error in words; for a field, the name of the field.
    #[must_use]
    pub const fn message(&self) -> &'static str {
        match self {
            Self::Layout(error) => error.message(),
            Self::OtherPlan => "the model is for another plan",
            Self::Channel { .. } => "a channel of the model has another name or unit than in the plan",
            Self::Park { .. } => "the front end has another Park convention than the model",
            Self::Interval { .. } => "the sampling interval differs from that of the model",
            Self::Length(field) | Self::OutOfRange(field) => field.name(),
            Self::NotAModel => "these bytes are not a bearing-watch model",
            Self::Version { .. } => "the model has another format version; train it again",
            Self::Truncated => "the model is truncated or has trailing bytes",
            Self::Checksum => "the checksum does not match: the model is corrupted",
            Self::BufferTooSmall => "the buffer is too small for the model",
        }
    }
}

impl core::fmt::Display for ModelError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Channel { index } => {
                write!(f, "channel {} of the model has another name or unit than in the plan", u16::from(*index) + 1)
            }
            Self::Park { trained, given } => {
                write!(f, "the model was trained with the Park convention {trained:?}, the front end has {given:?}")
            }
            Self::Interval { trained_s, given_s } => {
                let [trained, given] = [trained_s, given_s].map(|interval_s| microseconds(*interval_s));
                write!(f, "the model was trained on samples every {trained} µs, not every {given} µs")
            }
            Self::Length(field) => write!(f, "the model's {} has the wrong length", field.name()),
            Self::OutOfRange(field) => write!(f, "the model's {} is out of range", field.name()),
            Self::Version { given, supported } => {
                write!(
                    f,
                    "model format version {given}, but this build reads version {supported}; train the model again"
                )
            }
            other => f.write_str(other.message()),
        }
    }
}

impl core::error::Error for ModelError {}

/// Whole microseconds: the code that prints a number with a fraction is large, and can panic.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
fn microseconds(interval_s: f32) -> u32 {
    (interval_s * 1e6 + 0.5) as u32
}
