//! The check of the wiring at commissioning.

use core::ffi::{CStr, c_char, c_void};
use core::mem::offset_of;

use bearing_watch::drive::{Wiring, WiringCheck, WiringFault, WiringLimits};

use crate::code::{BwCode, code};
use crate::front_end::constants::BwFrontEndConstants;
use crate::front_end::sample::{BwRawSample, read};
use crate::memory::{Lock, Object, Tag, at, get, put, put_object, room};
use crate::state::BwState;

/// Bytes of memory that are enough for `bw_wiring_init`, aligned to `BW_STATE_ALIGN` bytes.
pub const BW_WIRING_SIZE: usize = 512;

const _: () = assert!(size_of::<BwWiringCheck>() <= BW_WIRING_SIZE);

/// What a wiring must be like.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwWiringLimits {
    /// Least root mean square of the current vector, A; several times the noise of the sensors.
    pub least_current_a: f32,
    /// Largest error of the electrical offset, rad.
    pub offset_rad: f32,
    /// Largest delay between current and angle, s.
    pub delay_s: f32,
    /// Largest relative difference of velocity and motion of the angle.
    pub velocity_tolerance: f32,
    /// Velocity below which it is not compared with the angle, rad/s.
    pub slowest_rad_s: f32,
}

/// What is wrong with the wiring, or why nothing can be said. The value is that of `BwWiring`.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BwWiringFault {
    /// Nothing is wrong.
    None = 0,
    /// The shaft has not been at all angles of a turn; value: sectors of 1/16 turn in which it was.
    TooLittleMotion = 1,
    /// The current is too small; value: its root mean square, A.
    TooLittleCurrent = 2,
    /// The current vector does not turn with the shaft: wrong phases or sensors, a slipping or multiplied angle, or no
    /// field-oriented control; value: the largest coherence.
    NotTurning = 3,
    /// The number of pole pairs is wrong; value: the one that fits, negative if the phases also run against the angle.
    PolePairs = 4,
    /// The phases run against angle and velocity: two are exchanged.
    PhaseOrder = 5,
    /// The angle runs against phases and velocity.
    AngleDirection = 6,
    /// The velocity runs against phases and angle.
    VelocityDirection = 7,
    /// Phases and angle run against each other; there is no velocity to decide which is wrong.
    PhaseOrderOrAngle = 8,
    /// The unit of the velocity or the control rate is wrong; value: integral of the velocity over motion of the angle.
    RateOrUnit = 9,
    /// The electrical offset is wrong; value: what must be added to it, rad, but for half a turn.
    Offset = 10,
    /// Current and angle are not of one instant; value: delay of the current behind the angle, s.
    Delay = 11,
    /// A fault that this interface does not know.
    Other = 12,
}

impl BwWiringFault {
    const ALL: [Self; 13] = [
        Self::None,
        Self::TooLittleMotion,
        Self::TooLittleCurrent,
        Self::NotTurning,
        Self::PolePairs,
        Self::PhaseOrder,
        Self::AngleDirection,
        Self::VelocityDirection,
        Self::PhaseOrderOrAngle,
        Self::RateOrUnit,
        Self::Offset,
        Self::Delay,
        Self::Other,
    ];

    const fn text(self) -> &'static CStr {
        match self {
            Self::None => c"the wiring is right",
            Self::TooLittleMotion => c"the shaft has not been at all angles of a turn",
            Self::TooLittleCurrent => c"the current is too small to check the wiring",
            Self::NotTurning => c"the current does not turn with the shaft",
            Self::PolePairs => c"the number of pole pairs is wrong",
            Self::PhaseOrder => c"two phases are exchanged",
            Self::AngleDirection => c"the angle has the wrong direction",
            Self::VelocityDirection => c"the velocity has the wrong sign",
            Self::PhaseOrderOrAngle => c"two phases are exchanged, or the angle has the wrong direction",
            Self::RateOrUnit => c"the control rate or the unit of the velocity is wrong",
            Self::Offset => c"the electrical offset is wrong",
            Self::Delay => c"current and angle are not sampled at the same time",
            Self::Other => c"a fault that this interface does not know",
        }
    }
}

/// The wiring.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BwWiring {
    /// The first fault. After a remedy check again.
    pub fault: BwWiringFault,
    /// The value that `BwWiringFault` names, NaN if it names none.
    pub value: f32,
    /// How well the current turns with the shaft, 1 at best. NaN, like what follows, if there is a fault.
    pub coherence: f32,
    /// Error of the electrical offset, rad.
    pub offset_rad: f32,
    /// Delay of the current behind the angle, s; NaN if the shaft turned one way only.
    pub delay_s: f32,
    /// Integral of the velocity over motion of the angle; NaN without a velocity: then its sign, its unit and the
    /// control rate are not checked.
    pub velocity_ratio: f32,
}

/// The check of one drive, in memory of the caller.
#[derive(Debug)]
pub struct BwWiringCheck {
    tag: Tag,
    pub(crate) check: Lock<WiringCheck>,
}

impl Object for BwWiringCheck {
    const MARK: u32 = 0x4257_5731;
    const PLACE_OF_TAG: usize = offset_of!(Self, tag);
}

/// Makes a check without samples in memory of the caller, and gives its address in `wiring`. Feed it by
/// `bw_check_wiring` while the drive moves under current control by a turn or more, best to and fro.
///
/// Returns `BW_CODE_OK`, or what is wrong with memory or constants.
///
/// # Safety
/// `memory` is NULL or has `size` writable bytes, which nothing else writes until the check is used no more.
/// `constants` and `limits` are NULL or readable. `wiring` is NULL or writable. No other function works on the check.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_wiring_init(
    memory: *mut c_void,
    size: usize,
    constants: *const BwFrontEndConstants,
    limits: *const BwWiringLimits,
    wiring: *mut *mut BwWiringCheck,
) -> BwCode {
    // SAFETY: the same contract; every bit pattern of constants and limits is valid.
    code(room(memory, size).and_then(|place| unsafe {
        let (constants, own) = (get(constants)?.core()?, get(limits)?);
        let limits = WiringLimits {
            least_current_a: own.least_current_a,
            offset_rad: own.offset_rad,
            delay_s: own.delay_s,
            velocity_tolerance: own.velocity_tolerance,
            slowest_rad_s: own.slowest_rad_s,
        };
        let check = Lock::new(WiringCheck::new(constants.frame, constants.control_rate_hz, limits));
        put_object(place, BwWiringCheck { tag: Tag::none(), check }, wiring)
    }))
}

/// Takes a raw sample at commissioning, for a check of the wiring instead of the detector. `velocity_rad_s` is one of
/// the drive's own, NaN if there is none. The times of `bw_clock` count anew behind it.
///
/// Returns `BW_CODE_OK`; `BW_CODE_OUT_OF_RANGE` if `phases` or `position` of the sample is, or if the state has no
/// front end; or `BW_CODE_BUSY`.
///
/// # Safety
/// `state` is NULL, or was given by `bw_start` or has as many readable bytes; likewise `wiring` by `bw_wiring_init`.
/// `raw` is NULL or readable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_check_wiring(
    state: *mut BwState,
    raw: *const BwRawSample,
    velocity_rad_s: f32,
    wiring: *mut BwWiringCheck,
) -> BwCode {
    // SAFETY: the same contract; every bit pattern of a raw sample is valid.
    let given = unsafe { at(state) }
        .and_then(|state| unsafe { Ok((state, at(wiring)?, read(raw, (core::ptr::null(), 0), 0)?)) });
    code(given.and_then(|(state, wiring, raw)| {
        state.further.ok_or(BwCode::OutOfRange)?;
        wiring.check.with(|check| state.watch.check_wiring(raw, velocity_rad_s, check))?;
        Ok(BwCode::Ok)
    }))
}

/// Gives the wiring, or what is wrong with it.
///
/// Returns `BW_CODE_OK`, also if there is a fault, or `BW_CODE_BUSY`.
///
/// # Safety
/// `wiring` is NULL, or was given by `bw_wiring_init` or has as many readable bytes. `result` is NULL or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_wiring_conclude(wiring: *mut BwWiringCheck, result: *mut BwWiring) -> BwCode {
    // SAFETY: the same contract.
    let found = unsafe { at(wiring) }.and_then(|own| own.check.with(|check| check.conclude()));
    // SAFETY: the same contract.
    code(found.and_then(|found| unsafe { put(result, found.into()) }).map(|()| BwCode::Ok))
}

impl From<Result<Wiring, WiringFault>> for BwWiring {
    fn from(found: Result<Wiring, WiringFault>) -> Self {
        let unknown = f32::NAN;
        let (fault, value) = match found {
            Ok(Wiring { coherence, offset_rad, delay_s, velocity_ratio }) => {
                let (delay_s, velocity_ratio) = (delay_s.unwrap_or(unknown), velocity_ratio.unwrap_or(unknown));
                return Self {
                    fault: BwWiringFault::None,
                    value: unknown,
                    coherence,
                    offset_rad,
                    delay_s,
                    velocity_ratio,
                };
            }
            Err(WiringFault::TooLittleMotion { sectors }) => (BwWiringFault::TooLittleMotion, sectors.into()),
            Err(WiringFault::TooLittleCurrent { rms_a }) => (BwWiringFault::TooLittleCurrent, rms_a),
            Err(WiringFault::NotTurning { coherence }) => (BwWiringFault::NotTurning, coherence),
            Err(WiringFault::PolePairs { fits }) => (BwWiringFault::PolePairs, fits.into()),
            Err(WiringFault::PhaseOrder) => (BwWiringFault::PhaseOrder, unknown),
            Err(WiringFault::AngleDirection) => (BwWiringFault::AngleDirection, unknown),
            Err(WiringFault::VelocityDirection) => (BwWiringFault::VelocityDirection, unknown),
            Err(WiringFault::PhaseOrderOrAngle) => (BwWiringFault::PhaseOrderOrAngle, unknown),
            Err(WiringFault::RateOrUnit { ratio }) => (BwWiringFault::RateOrUnit, ratio),
            Err(WiringFault::Offset { error_rad }) => (BwWiringFault::Offset, error_rad),
            Err(WiringFault::Delay { delay_s }) => (BwWiringFault::Delay, delay_s),
            // What a later version of the core adds.
            Err(_) => (BwWiringFault::Other, unknown),
        };
        Self { fault, value, coherence: unknown, offset_rad: unknown, delay_s: unknown, velocity_ratio: unknown }
    }
}

/// Returns a text for a fault of the wiring, `BW_WIRING_FAULT_…`, ending in a zero byte; "unknown fault" for other
/// numbers. Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn bw_wiring_text(fault: i32) -> *const c_char {
    let known = BwWiringFault::ALL.into_iter().find(|known| *known as i32 == fault);
    known.map_or(c"unknown fault", BwWiringFault::text).as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_has_its_value_with_its_sign() {
        let of = |fault| {
            let told = BwWiring::from(Err(fault));
            (told.fault, told.value)
        };
        // Exchanged phases of a motor with seven pole pairs.
        assert_eq!(of(WiringFault::PolePairs { fits: -7 }), (BwWiringFault::PolePairs, -7.0));
        assert_eq!(of(WiringFault::PolePairs { fits: 7 }), (BwWiringFault::PolePairs, 7.0));
        assert_eq!(of(WiringFault::RateOrUnit { ratio: -0.5 }), (BwWiringFault::RateOrUnit, -0.5));
        assert_eq!(of(WiringFault::Offset { error_rad: -0.25 }), (BwWiringFault::Offset, -0.25));
        assert_eq!(of(WiringFault::Delay { delay_s: -0.001 }), (BwWiringFault::Delay, -0.001));
        assert_eq!(of(WiringFault::NotTurning { coherence: 0.125 }), (BwWiringFault::NotTurning, 0.125));
    }
}
