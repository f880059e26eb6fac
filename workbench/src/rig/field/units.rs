//! Differences between drives of one type, and from day to day.
//!
//! Each constant c of the drive is multiplied by
//!
//! ```text
//! (1 + a x_c)(1 + b y_c),   x_c, y_c uniform from −1 to 1      (1)
//! ```
//!
//! x belongs to the drive and y to the session (the day); a session also adds an offset to the measured current. If a
//! scenario names its [`Drive`], all records of this drive have the same x, and all of one session the same y; the other
//! effects that are built into a drive (cogging, sensors, transmission) are then also drawn once for the drive. If not,
//! each record is a drive of its own.

use crate::rig::{NoiseSource, RigError, Stream, not_negative};

/// One drive on one day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Drive {
    /// Number of the set of drives; drives of different sets differ.
    pub set: u32,
    /// Number of the drive in its set.
    pub unit: u32,
    /// Number of the session of this drive.
    pub session: u32,
}

/// Ranges of the differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// a of (1).
    pub unit: f64,
    /// b of (1).
    pub session: f64,
    /// Largest offset of the measured current in a session.
    pub session_current_a: f64,
}

/// Factors of the constants of one drive in one session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
    /// Factor of R.
    pub resistance: f64,
    /// Factor of Kt and Ke.
    pub flux: f64,
    /// Factor of J.
    pub inertia: f64,
    /// Factor of B.
    pub viscous: f64,
    /// Factor of Coulomb and Stribeck friction.
    pub coulomb: f64,
    /// Factor of the measured load.
    pub load_gain: f64,
    /// Factor of the measured current.
    pub current_gain: f64,
    /// Offset of the measured current.
    pub current_offset_a: f64,
}

impl Units {
    /// The ranges of the field.
    pub const FIELD: Self = Self { unit: 0.05, session: 0.02, session_current_a: 0.05 };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        super::fraction("field.units.unit", self.unit)?;
        super::fraction("field.units.session", self.session)?;
        not_negative("field.units.session_current_a", self.session_current_a)?;
        Ok(())
    }

    pub(super) fn draw(&self, draws: Draws) -> Constants {
        let (mut unit, mut session) = (draws.of_drive(Stream::Unit), draws.of_session(Stream::Session));
        let mut factor =
            || (1.0 + unit.uniform(-self.unit, self.unit)) * (1.0 + session.uniform(-self.session, self.session)); // (1)
        Constants {
            resistance: factor(),
            flux: factor(),
            inertia: factor(),
            viscous: factor(),
            coulomb: factor(),
            load_gain: factor(),
            current_gain: factor(),
            current_offset_a: session.uniform(-self.session_current_a, self.session_current_a),
        }
    }
}

impl Constants {
    /// The nominal drive.
    pub const NOMINAL: Self = Self {
        resistance: 1.0,
        flux: 1.0,
        inertia: 1.0,
        viscous: 1.0,
        coulomb: 1.0,
        load_gain: 1.0,
        current_gain: 1.0,
        current_offset_a: 0.0,
    };
}

/// Sources of the draws of one record.
#[derive(Debug, Clone, Copy)]
pub(super) struct Draws {
    pub(super) seed: u64,
    pub(super) drive: Option<Drive>,
}

impl Draws {
    /// Draws that differ between records.
    pub(super) fn of_record(self, stream: Stream) -> NoiseSource {
        NoiseSource::new(self.seed, stream)
    }

    /// Draws that all records of a drive share.
    pub(super) fn of_drive(self, stream: Stream) -> NoiseSource {
        match self.drive {
            Some(Drive { set, unit, .. }) => NoiseSource::keyed([set, unit, 0], stream),
            None => self.of_record(stream),
        }
    }

    /// Draws that all records of a session share.
    pub(super) fn of_session(self, stream: Stream) -> NoiseSource {
        match self.drive {
            Some(Drive { set, unit, session }) => NoiseSource::keyed([set, unit, session], stream),
            None => self.of_record(stream),
        }
    }
}
