//! What a front end has refused.

use bearing_watch::drive::{Alignment, Faults, Imbalance, Lock, Phase};

/// Why the three currents do not fit each other.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwImbalance {
    /// They do.
    None = 0,
    /// No current in a phase, and the other two sum to zero: the winding or its lead is open.
    Open = 1,
    /// A sensor reads no current, but the other two do not sum to zero: the sensor or its wire is broken.
    Silent = 2,
    /// The gain of a sensor is wrong.
    Gain = 3,
    /// The currents do not sum to zero, and no single gain explains it: several sensors, current to earth.
    Unnamed = 4,
    /// The offset of a sensor is beyond what is removed from its currents.
    Offset = 5,
    /// The current vector does not turn with the rotor: two phases are exchanged, the angle is reversed, the pole pairs
    /// are wrong, or there is no field-oriented control.
    Misaligned = 6,
    /// A phase stays below a level that the other two exceed: its sensor or amplifier is clipped.
    Clipped = 7,
    /// A phase has no current in one direction, which the other two have: a half bridge or a sensor is broken.
    HalfWave = 8,
}

/// Whether the currents turn with the rotor.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwAlignment {
    /// No window has told yet: the shaft has not turned with a current. No segment has a verdict.
    Undecided = 0,
    /// They do.
    Aligned = 1,
    /// They do not: no segment has a verdict.
    Misaligned = 2,
    /// They are not checked: currents or motion are too small, the drive gives a quadrature current of its own, or it
    /// has no front end. Segments have verdicts.
    Unknown = 3,
}

impl From<Alignment> for BwAlignment {
    fn from(alignment: Alignment) -> Self {
        match alignment {
            Alignment::Undecided => Self::Undecided,
            Alignment::Aligned => Self::Aligned,
            Alignment::Misaligned => Self::Misaligned,
            Alignment::Unknown => Self::Unknown,
        }
    }
}

/// How far the loop has found the angle of the shaft.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwLock {
    /// No reading yet, or lost.
    Searching = 0,
    /// One reading: the next one gives the velocity.
    Found = 1,
    /// The loop follows, but its errors have not been small for long enough.
    Settling = 2,
    /// The loop follows.
    Locked = 3,
}

/// What a front end has refused since the start or `bw_clear_faults`, in samples where nothing else is said, and what
/// is wrong now.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwFrontEndFaults {
    /// Whether the angle is known, and nothing was refused.
    pub clear: bool,
    /// The phase of the imbalance: 0, 1, 2 for a, b, c.
    pub imbalance_phase: u8,
    /// Why the currents are missing now.
    pub imbalance: BwImbalance,
    /// Relative error of the gain, for `BW_IMBALANCE_GAIN`; for `BW_IMBALANCE_OFFSET` the offset, A.
    pub gain_error: f32,
    /// Number of windows in which the currents did not fit.
    pub unbalanced_windows: u32,
    /// Offsets of phases a, b, c that were found while the shaft turned and are removed, A; not a refusal.
    pub offsets_a: [f32; 3],
    /// Counts of phases a, b, c outside the usable range.
    pub saturated: [u32; 3],
    /// Counts of phases a, b, c that repeated too often.
    pub stuck: [u32; 3],
    /// `BW_POSITION_MISSING`.
    pub position_missing: u32,
    /// Errors of the locked loop beyond its limit.
    pub position_strayed: u32,
    /// Number of times that the lock was lost.
    pub lock_losses: u32,
    /// Readings of the angle that repeat the one before although the shaft turns; they are missing.
    pub position_stale: u32,
    /// Steps of the angle that are no motion: the sensor has slipped on the shaft, or lost or gained counts.
    pub position_slipped: u32,
    /// Windows in which angle and sample were not of one instant, by more than a tenth of an interval.
    pub position_unsteady: u32,
    /// Bits of the converter's reading, of 2⁻³² turn, that do not change while those beside them do.
    pub position_stuck_bits: u32,
    /// Resolver signals with too low an amplitude, or not a number.
    pub resolver_lost: u32,
    /// Resolver signals with too high an amplitude.
    pub resolver_too_high: u32,
    /// Resolver signals while the gains of sine and cosine differed too much.
    pub resolver_mismatched: u32,
    /// Whether the angle is known now.
    pub lock: BwLock,
    /// Number of gaps in the numbers of the samples.
    pub gaps: u32,
    /// Whether the currents turn with the rotor.
    pub alignment: BwAlignment,
}

impl From<Faults> for BwFrontEndFaults {
    fn from(faults: Faults) -> Self {
        let (imbalance, phase, gain_error) = match faults.imbalance {
            None => (BwImbalance::None, Phase::A, 0.0),
            Some(Imbalance::Open(phase)) => (BwImbalance::Open, phase, 0.0),
            Some(Imbalance::Silent(phase)) => (BwImbalance::Silent, phase, 0.0),
            Some(Imbalance::Gain { phase, error }) => (BwImbalance::Gain, phase, error),
            Some(Imbalance::Unnamed) => (BwImbalance::Unnamed, Phase::A, 0.0),
            Some(Imbalance::Offset { phase, offset_a }) => (BwImbalance::Offset, phase, offset_a),
            Some(Imbalance::Misaligned) => (BwImbalance::Misaligned, Phase::A, 0.0),
            Some(Imbalance::Clipped(phase)) => (BwImbalance::Clipped, phase, 0.0),
            Some(Imbalance::HalfWave(phase)) => (BwImbalance::HalfWave, phase, 0.0),
        };
        let position = faults.position;
        Self {
            clear: faults.is_clear(),
            imbalance_phase: place_of(phase),
            imbalance,
            gain_error,
            unbalanced_windows: faults.unbalanced_windows,
            offsets_a: faults.offsets_a,
            saturated: faults.currents.map(|own| own.saturated),
            stuck: faults.currents.map(|own| own.stuck),
            position_missing: position.missing,
            position_strayed: position.strayed,
            lock_losses: position.losses,
            position_stale: position.stale,
            position_slipped: position.slipped,
            position_unsteady: position.unsteady_windows,
            position_stuck_bits: position.stuck_bits,
            resolver_lost: position.resolver.lost,
            resolver_too_high: position.resolver.too_high,
            resolver_mismatched: position.resolver.mismatched,
            lock: match faults.lock {
                Lock::Searching => BwLock::Searching,
                Lock::Found(_) => BwLock::Found,
                Lock::Settling(_) => BwLock::Settling,
                Lock::Locked => BwLock::Locked,
            },
            gaps: faults.gaps,
            alignment: faults.alignment.into(),
        }
    }
}

/// 0, 1, 2 for the phases a, b, c.
pub(crate) const fn place_of(phase: Phase) -> u8 {
    match phase {
        Phase::A => 0,
        Phase::B => 1,
        Phase::C => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bearing_watch::drive::{PhaseFaults, PositionFaults, ResolverFaults};

    const CLEAR: Faults = Faults {
        currents: [PhaseFaults { saturated: 0, stuck: 0 }; 3],
        imbalance: None,
        unbalanced_windows: 0,
        last_imbalance: None,
        offsets_a: [0.0; 3],
        position: PositionFaults {
            missing: 0,
            strayed: 0,
            losses: 0,
            stale: 0,
            slipped: 0,
            unsteady_windows: 0,
            stuck_bits: 0,
            resolver: ResolverFaults { lost: 0, too_high: 0, mismatched: 0 },
        },
        lock: Lock::Locked,
        gaps: 0,
        alignment: Alignment::Aligned,
    };

    #[test]
    fn each_number_has_a_place_of_its_own() {
        let resolver = ResolverFaults { lost: 8, too_high: 9, mismatched: 10 };
        let position = PositionFaults {
            missing: 1,
            strayed: 2,
            losses: 3,
            stale: 4,
            slipped: 5,
            unsteady_windows: 6,
            stuck_bits: 7,
            resolver,
        };
        let currents = [(11, 14), (12, 15), (13, 16)].map(|(saturated, stuck)| PhaseFaults { saturated, stuck });
        let faults = Faults { currents, position, unbalanced_windows: 17, gaps: 18, ..CLEAR };
        let told = BwFrontEndFaults::from(faults);
        let of_position = [told.position_missing, told.position_strayed, told.lock_losses, told.position_stale];
        let of_readings = [told.position_slipped, told.position_unsteady, told.position_stuck_bits];
        let of_resolver = [told.resolver_lost, told.resolver_too_high, told.resolver_mismatched];
        assert_eq!((of_position, of_readings, of_resolver), ([1, 2, 3, 4], [5, 6, 7], [8, 9, 10]));
        assert_eq!((told.saturated, told.stuck), ([11, 12, 13], [14, 15, 16]));
        assert_eq!((told.unbalanced_windows, told.gaps, told.clear), (17, 18, false));
        assert!(BwFrontEndFaults::from(CLEAR).clear);
    }

    #[test]
    fn an_imbalance_names_its_phase() {
        let of = |imbalance| {
            let told = BwFrontEndFaults::from(Faults { imbalance: Some(imbalance), ..CLEAR });
            (told.imbalance, told.imbalance_phase, told.gain_error)
        };
        for (place, phase) in (0..).zip(Phase::ALL) {
            assert_eq!(of(Imbalance::Open(phase)), (BwImbalance::Open, place, 0.0));
            assert_eq!(of(Imbalance::Silent(phase)), (BwImbalance::Silent, place, 0.0));
            assert_eq!(of(Imbalance::Clipped(phase)), (BwImbalance::Clipped, place, 0.0));
            assert_eq!(of(Imbalance::HalfWave(phase)), (BwImbalance::HalfWave, place, 0.0));
            assert_eq!(of(Imbalance::Gain { phase, error: 0.25 }), (BwImbalance::Gain, place, 0.25));
            assert_eq!(of(Imbalance::Offset { phase, offset_a: -2.0 }), (BwImbalance::Offset, place, -2.0));
        }
        assert_eq!(
            [of(Imbalance::Unnamed).0, of(Imbalance::Misaligned).0],
            [BwImbalance::Unnamed, BwImbalance::Misaligned]
        );
    }
}
