//! What enters a front end.

use bearing_watch::Angle;
use bearing_watch::drive::{PhaseCounts, Position, RawSample};

use super::FURTHER;
use crate::code::{BwCode, Outcome};
use crate::memory::{elements, get};

/// Whether counts of phases are taken, and whether a quadrature current is: a front end of the library's plan was
/// trained for one of them, and needs no code for the other.
const TAKES_COUNTS: bool = !cfg!(bearing_watch_quadrature);
const TAKES_CURRENT: bool = !cfg!(bearing_watch_front_end) || cfg!(bearing_watch_quadrature);

/// What a raw sample has of the position sensor.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwPosition {
    /// No reading, or one that the sensor says is wrong.
    Missing = 0,
    /// The angle from a converter or an absolute encoder.
    Absolute = 1,
    /// Demodulated sine and cosine of a resolver, or of a sine/cosine encoder.
    Resolver = 2,
}

/// What the drive reads at one instant of its control loop.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwRawSample {
    /// Number of the sampling instant: one more each time, with wrap-around. A missed interrupt shows as a gap.
    pub number: u32,
    /// Converter counts of the currents of phases a, b, c; c is not used with two phases.
    pub counts: [u16; 3],
    /// Number of measured phases, 2 or 3. With two, the third current is minus the sum, and nothing checks the sensors
    /// against each other. 1 stands for `current_a` in the place of counts. A library for one plan takes only what that
    /// was trained with: counts, or a current.
    pub phases: u8,
    /// What there is of the position, `BW_POSITION_…`.
    pub position: u8,
    /// Mechanical angle of the shaft as `bw_angle` returns it, for `BW_POSITION_ABSOLUTE`.
    pub angle: u32,
    /// Amplitude times sine, for `BW_POSITION_RESOLVER`, in the unit of `resolver_lowest_amplitude`.
    pub sin: f32,
    /// Amplitude times cosine.
    pub cos: f32,
    /// With `phases` of 1, the quadrature current that the control of the drive makes itself, A; NaN if it is missing.
    pub current_a: f32,
}

impl BwRawSample {
    /// The sample of the core.
    ///
    /// # Errors
    /// [`BwCode::OutOfRange`]
    #[inline]
    pub(crate) fn core(&self, further: &[f32]) -> Outcome<RawSample<FURTHER>> {
        let position = match self.position {
            0 => Position::Missing,
            1 => Position::Absolute(Angle::from_bits(self.angle)),
            2 => Position::Resolver { sin: self.sin, cos: self.cos },
            _ => return Err(BwCode::OutOfRange),
        };
        let currents = match self.phases {
            1 if TAKES_CURRENT => PhaseCounts::Quadrature(self.current_a),
            phases if TAKES_COUNTS => phase_counts(&self.counts, phases)?,
            _ => return Err(BwCode::OutOfRange),
        };
        let mut all = [0.0; FURTHER];
        all.iter_mut().zip(further).for_each(|(cell, value)| *cell = *value);
        Ok(RawSample { number: self.number, currents, position, further: all })
    }
}

/// The sample of the core from one of the caller's with `count` further channels, of which `used` are in use.
///
/// # Errors
/// [`BwCode::WrongChannelCount`], [`BwCode::Null`], [`BwCode::Misaligned`] or [`BwCode::OutOfRange`].
///
/// # Safety
/// `raw` is NULL or readable. `further` is NULL or has `count` readable values.
#[inline]
pub(crate) unsafe fn read(
    raw: *const BwRawSample,
    (further, count): (*const f32, usize),
    used: u16,
) -> Outcome<RawSample<FURTHER>> {
    if count != usize::from(used) {
        return Err(BwCode::WrongChannelCount);
    }
    // SAFETY: the contract of the caller; every bit pattern of a raw sample is valid.
    unsafe {
        let further = if count == 0 { &[] } else { elements(further, count)? };
        get(raw)?.core(further)
    }
}

/// The counts of two or three phases.
///
/// # Errors
/// [`BwCode::OutOfRange`] for another number of phases.
#[inline]
pub(crate) fn phase_counts(counts: &[u16], phases: u8) -> Outcome<PhaseCounts> {
    match (phases, counts) {
        (2, [a, b, ..]) => Ok(PhaseCounts::Two([*a, *b])),
        (3, [a, b, c, ..]) => Ok(PhaseCounts::Three([*a, *b, *c])),
        _ => Err(BwCode::OutOfRange),
    }
}
