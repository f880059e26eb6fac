//! What the phase currents may say of sensors, winding and angle.

use super::Phase;

/// Why the three currents do not fit each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Imbalance {
    /// No current in a phase, and the other two sum to zero: the winding or its lead is open.
    Open(Phase),
    /// A sensor reads no current, but the other two do not sum to zero: the sensor or its wire is broken.
    Silent(Phase),
    /// The gain of a sensor is wrong.
    Gain {
        /// The phase of the sensor.
        phase: Phase,
        /// Relative error (5) of its gain.
        error: f32,
    },
    /// The currents do not sum to zero, and no single gain explains it: several sensors, current to earth.
    Unnamed,
    /// A phase stays below a level that the other two exceed: its sensor or amplifier is clipped.
    Clipped(Phase),
    /// A phase has no current in one direction, which the other two have: a half bridge or a sensor is broken.
    HalfWave(Phase),
    /// The offset of a sensor is beyond what is removed from its currents.
    Offset {
        /// The phase with the largest offset.
        phase: Phase,
        /// Offset, A.
        offset_a: f32,
    },
    /// The current vector does not turn with the rotor: two phases are exchanged, the angle is reversed, the pole pairs
    /// are wrong, or there is no field-oriented control.
    Misaligned,
}

/// Whether the currents turn with the rotor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Alignment {
    /// No window has told yet: the shaft has not turned with a current.
    #[default]
    Undecided,
    /// They do.
    Aligned,
    /// They do not.
    Misaligned,
    /// They are not checked: currents or motion are too small, or the drive gives a quadrature current of its own.
    Unknown,
}

impl Alignment {
    /// All, in the order of their numbers in the C interface.
    pub const ALL: [Self; 4] = [Self::Undecided, Self::Aligned, Self::Misaligned, Self::Unknown];

    /// What is known, in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Undecided => "the check of the wiring has not decided yet",
            Self::Aligned => "the currents turn with the rotor",
            Self::Misaligned => "the currents do not turn with the rotor",
            Self::Unknown => "the wiring is not checked",
        }
    }
}
