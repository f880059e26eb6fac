//! Differences between drives of one type, and from day to day.
//!
//! Each constant c of the drive is multiplied by
//!
//! ```text
//! (1 + a x_c)(1 + b y_c),   x_c, y_c uniform from −1 to 1      (1)
//! ```
//!
//! x belongs to the drive and y to the session (the day); a session also adds an offset to the measured current. If a
//! scenario names its [`Drive`], all records of this drive have the same x, and all of one session the same y. The
//! other effects that are built into a drive (Stribeck and load friction, cogging, sensors, transmission) are then also
//! drawn once for the drive. If not, each record is a drive of its own.

use crate::{NoiseSource, RigError, Stream, fraction, not_negative};

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
        fraction("field.units.unit", self.unit)?;
        fraction("field.units.session", self.session)?;
        not_negative("field.units.session_current_a", self.session_current_a)?;
        Ok(())
    }

    pub(super) fn draw(&self, draws: Draws) -> Constants {
        let (mut unit, mut session) = (draws.of_drive(Stream::Unit), draws.of_session(Stream::Session));
        // (1)
        let mut factor =
            || (1.0 + unit.uniform(-self.unit, self.unit)) * (1.0 + session.uniform(-self.session, self.session));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Field, FieldValues, Scenario};

    const FIELD: Scenario = Scenario { field: Field::ALL, ..Scenario::STANDARD };

    fn drive(set: u32, unit: u32, session: u32) -> Scenario {
        Scenario { drive: Some(Drive { set, unit, session }), ..FIELD }
    }

    fn factors(values: &FieldValues) -> [f64; 7] {
        let c = values.constants();
        [c.resistance, c.flux, c.inertia, c.viscous, c.coulomb, c.load_gain, c.current_gain]
    }

    #[test]
    fn records_of_a_drive_share_what_is_built_into_it() {
        let (one, other) = (FieldValues::draw(&drive(1, 2, 3), 10), FieldValues::draw(&drive(1, 2, 3), 11));
        assert_eq!(one.constants, other.constants);
        assert_eq!(
            (one.magnetics, one.resolver, one.load_sensor),
            (other.magnetics, other.resolver, other.load_sensor)
        );
        assert_eq!((one.stribeck, one.load_friction), (other.stribeck, other.load_friction));
        assert_eq!(one.current_chain, other.current_chain);
        let built = |values: &FieldValues| values.mechanics.map(|m| (m.resonance_hz, m.backlash_rad));
        assert_eq!(built(&one), built(&other));
        // The record's own: temperature, slip, payload.
        assert!(one.temperature != other.temperature && one.slip != other.slip);
        assert_ne!(one.mechanics.map(|m| m.payload), other.mechanics.map(|m| m.payload));
    }

    #[test]
    fn other_units_sets_and_sessions_differ() {
        let base = FieldValues::draw(&drive(1, 2, 3), 10);
        for (set, unit) in [(1, 3), (2, 2), (2, 1)] {
            let other = FieldValues::draw(&drive(set, unit, 3), 10);
            assert!(factors(&base).iter().zip(factors(&other)).all(|(a, b)| *a != b));
            assert!(base.magnetics != other.magnetics && base.resolver != other.resolver);
            assert_eq!(base.temperature, other.temperature);
        }
        let tomorrow = FieldValues::draw(&drive(1, 2, 4), 10);
        assert_eq!((base.magnetics, base.current_chain), (tomorrow.magnetics, tomorrow.current_chain));
        assert_ne!(base.constants().current_offset_a, tomorrow.constants().current_offset_a);
        for (a, b) in factors(&base).iter().zip(factors(&tomorrow)) {
            // Two sessions differ by at most 1.02/0.98.
            assert!(*a != b && (a / b - 1.0).abs() < 0.041, "{a} {b}");
        }
    }

    #[test]
    fn constants_stay_in_their_ranges() {
        let mut extremes = [1.0_f64; 2];
        for seed in 0..2000 {
            let values = FieldValues::draw(&FIELD, seed);
            for factor in factors(&values) {
                assert!((0.95 * 0.98..1.05 * 1.02).contains(&factor), "{factor}");
                extremes = [extremes[0].min(factor), extremes[1].max(factor)];
            }
            assert!(values.constants().current_offset_a.abs() < 0.05);
        }
        // Of 14 000 products, both factors lie within 5 % of an end of their ranges in 35 on average.
        assert!(extremes[0] < 0.94 && extremes[1] > 1.06, "{extremes:?}");
        let session_only = Units { unit: 0.0, ..Units::FIELD };
        let fixed = Scenario { field: Field { units: Some(session_only), ..Field::NONE }, ..FIELD };
        assert!((0..100).all(|seed| (FieldValues::draw(&fixed, seed).constants().flux - 1.0).abs() < 0.02));
    }
}
