//! The whole chain: raw counts at the control rate → clean samples at the rate of identification.
//!
//! ```text
//! counts ─► amperes ─► Clarke ──► Park ─► i_q ──────────────────┐
//!              └─ sum of three ─►  ▲                            ├─► decimate by F ─► current_a, velocity_rad_s
//! sin, cos or angle ─► loop ─► θ̂ ──┴─► e = θ − θ̂, velocity ─────┤                   angle = θ̂(n − D) + (h ∗ e)(n)
//! command, load, … ─────────────────────────────────────────────┘                   further
//!
//! θ̄(n) = θ̂(n − D) + Σ h(j) e(n − j)                                      (1)
//!      = Σ h(j) θ(n − j) + [θ̂(n − D) − Σ h(j) θ̂(n − j)]                  (2)
//! v(n) = (θ(n + 1) − θ(n − 1)) / 2T                                      (3)
//! ```
//!
//! An angle that wraps cannot be filtered. (1) filters its deviation from the tracking loop, which is small, and adds
//! the angle of the loop at the centre of the taps h, D samples ago. The bracket of (2) is the part of θ̂ that the
//! filter stops: in the pass band, to 0.4 of the output rate, it is below 3·10⁻⁴ of θ̂, so the result is the filtered
//! angle as measured, without the lag and the overshoot of the loop. (3) takes the measured angle, too, wraps in
//! integers, and has the same delay as the other channels; its gain is sin(x)/x with x = 2π f T, 0.984 at 500 Hz and
//! T = 100 µs.
//!
//! All channels pass the same filters ([`By`]) and have the same delay, [`FrontEnd::DELAY`] samples: a sample of the
//! detector is one instant.
//!
//! **Faults.** A channel without a true value is NaN. The filters make those outputs NaN whose taps met it, 32 samples
//! of the detector at most, and the detector refuses these. Four faults are found only after a window of samples that
//! were used already: [`CleanSample::found_late`] is then set. Without an angle there is no Park transform: current,
//! velocity and angle are missing. While the currents do not fit each other or do not turn with the rotor, the current
//! is missing. A quadrature current of the drive's own ([`PhaseCounts::Quadrature`]) passes the filters as it is. Offsets
//! of the current sensors are removed as far as they are small. A gap in the numbers of the samples
//! makes every output NaN that has taps on both sides.
//!
//! **Cost.** `cargo xtask measure` prints the instructions of a sample and the state, by 8 and by 10, with a converter
//! and with a resolver.

mod constants;
mod delay;

pub use constants::{FrontEndConstants, FrontEndError};

use super::decimate::Decimate;
use crate::drive::{
    Alignment, By, CurrentBalance, CurrentSensors, Factor, Imbalance, Lock, PhaseCounts, PhaseFaults, Position,
    PositionFaults, PositionTracker, RotorFrame, Tracked, WiringCheck,
};
use crate::signal::{Angle, RAD};
use delay::{CELLS, Centres};

/// The filters of one or more channels.
type Filters<const CH: usize, const FACTOR: usize> = <By<FACTOR> as Factor>::Chain<CH>;

/// What the drive reads at one instant of its control loop.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RawSample<const FURTHER: usize> {
    /// Number of the sampling instant: one more each time, with wrap-around. A missed interrupt shows as a gap.
    pub number: u32,
    /// Counts of the phase currents.
    pub currents: PhaseCounts,
    /// The reading of the position sensor.
    pub position: Position,
    /// Command, load and other channels in their units; NaN if missing.
    pub further: [f32; FURTHER],
}

/// All signals at one instant, [`FrontEnd::DELAY`] raw samples ago.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CleanSample<const FURTHER: usize> {
    /// Quadrature current, A; NaN if missing.
    pub current_a: f32,
    /// Mechanical velocity, rad/s; NaN if missing.
    pub velocity_rad_s: f32,
    /// Mechanical angle; without meaning if the velocity is NaN.
    pub angle: Angle,
    /// The further channels, NaN if missing.
    pub further: [f32; FURTHER],
    /// A converter or a bit of the angle was found stuck, the currents were found not to fit each other, or the gains
    /// of the resolver were found to differ, after the clean sample before this one. The fault began up to two windows
    /// or half a turn earlier, so that earlier samples were wrong: call
    /// [`Detector::discard`](crate::Detector::discard).
    pub found_late: bool,
    /// Whether the currents turn with the rotor: pass it to
    /// [`Monitor::tell_alignment`](crate::Monitor::tell_alignment), which gives no verdict before that is known.
    pub alignment: Alignment,
}

/// What was refused since the start or [`FrontEnd::clear_faults`], and what is wrong now.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Faults {
    /// Refused counts of phases a, b, c.
    pub currents: [PhaseFaults; 3],
    /// Why the currents are missing now: they do not fit each other, or the rotor.
    pub imbalance: Option<Imbalance>,
    /// Number of windows in which the currents did not fit.
    pub unbalanced_windows: u32,
    /// Why the currents did not fit in the last of these windows.
    pub last_imbalance: Option<Imbalance>,
    /// Offsets of phases a, b, c that were found while the shaft turned and are removed, A; not a refusal. Three equal
    /// ones are a third each of the offset of one sensor, which the current loop follows: the true currents have it.
    pub offsets_a: [f32; 3],
    /// Refused readings of the position sensor.
    pub position: PositionFaults,
    /// Whether the angle is known now.
    pub lock: Lock,
    /// Number of gaps in the numbers of the samples.
    pub gaps: u32,
    /// Whether the currents turn with the rotor.
    pub alignment: Alignment,
}

impl Faults {
    /// Whether the angle is known, and nothing was refused.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        let windows = self.imbalance.is_none() && self.unbalanced_windows == 0;
        let refused = self.currents != [PhaseFaults::default(); 3] || self.position != PositionFaults::default();
        windows && !refused && self.lock == Lock::Locked && self.gaps == 0
    }
}

/// The sample before the newest one: a velocity (3) needs the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Held<const FURTHER: usize> {
    current_a: f32,
    /// θ̂, and e; NaN if missing.
    angle: Angle,
    error_rad: f32,
    /// The measured angle.
    measured: Angle,
    further: [f32; FURTHER],
}

impl<const FURTHER: usize> Held<FURTHER> {
    const MISSING: Self = Self {
        current_a: f32::NAN,
        angle: Angle::ZERO,
        error_rad: f32::NAN,
        measured: Angle::ZERO,
        further: [f32::NAN; FURTHER],
    };
}

/// Raw samples at the control rate → clean samples, one of `FACTOR`, with `FURTHER` channels besides current, velocity
/// and angle. There are filters for the factors 1, 2, 4, 8, 16, 32, 6, 12, 24, 48, 10, 20 and 40.
///
/// ```
/// # mod model { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/support/standard_rig/model.rs")); }
/// use bearing_watch::drive::*;
/// use bearing_watch::*;
/// use model::{MODEL, Sample};
///
/// // 4 kHz → 500 Hz, with two further channels: command and load.
/// const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 2048.0, gain_a: 0.01, usable: [16, 4079] };
/// let mut front_end = FrontEnd::<2, 8>::new(&FrontEndConstants {
///     control_rate_hz: 4000.0,
///     sensors: [SENSOR; 3],
///     stuck_samples: 0,
///     balance: BalanceLimits { noise_a: 0.05, offset_a: 0.1, gain_tolerance: 0.02, window: 320 },
///     tracking: TrackingConstants {
///         bandwidth_hz: 200.0,
///         damping: 0.7,
///         error_limit_rad: 0.1,
///         lost_samples: 20,
///         settle_samples: 20,
///         resolver: ResolverLimits { low: 0.8, high: 1.2, mismatch: 0.05 },
///     },
///     frame: RotorFrame { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard },
/// })?;
/// let mut detector = Detector::new(&MODEL);
/// for number in 0..4000 {
///     // In the interrupt of the control loop, here with the shaft at rest and 1 A in phase b:
///     let currents = PhaseCounts::Three([2048, 2148, 1948]);
///     let raw = RawSample { number, currents, position: Position::Absolute(Angle::ZERO), further: [40.0, 0.1] };
///     if let Some(CleanSample { current_a, further, .. }) = front_end.push(&raw) {
///         let [velocity_ref_rad_s, load_torque_nm] = further;
///         // From where the loop has locked.
///         assert!((current_a - 1.154_7).abs() < 1e-4); // 2/√3 A
///         let _report = detector.step(&Sample { current_a, velocity_ref_rad_s, load_torque_nm });
///     }
/// }
/// assert!(front_end.faults().is_clear());
/// # Ok::<(), FrontEndError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrontEnd<const FURTHER: usize, const FACTOR: usize>
where
    By<FACTOR>: Factor,
{
    sensors: CurrentSensors,
    balance: CurrentBalance,
    tracker: PositionTracker,
    frame: RotorFrame,
    /// rad/s of a count of 2⁻³² turn in two samples.
    velocity_scale: f32,
    held: Held<FURTHER>,
    /// The measured angle before that which is held.
    before: Angle,
    /// Angles measured in a row, at most three: as many as (3) needs.
    measured: u8,
    /// Decimates current, velocity and error of the angle.
    filters: Filters<3, FACTOR>,
    /// Decimates the further channels.
    further: Filters<FURTHER, FACTOR>,
    centres: Centres,
    /// Samples until the next centre of an output.
    to_centre: u16,
    /// The number that the next sample must have.
    next: Option<u32>,
    /// Samples to spoil after a gap.
    spoilt: u8,
    gaps: u32,
    /// Whether there was a fault at the last output that shows only after a window of samples.
    late: bool,
    /// Outputs that may still be held back before the first complete one.
    held_back: u16,
}

/// Longest time before the first complete sample in which none is returned, s. Then a drive whose angle or current is
/// missing from the start gives incomplete ones, so that its detector says why there is no verdict.
const LONGEST_START_S: f32 = 2.0;

/// Every other tap of a half-band filter is zero: of two spoilt samples in a row, each filter multiplies one by a tap
/// that is not zero. A low-pass before it turns them into two or more spoilt outputs.
const SPOILT: u8 = 2;

impl<const FURTHER: usize, const FACTOR: usize> FrontEnd<FURTHER, FACTOR>
where
    By<FACTOR>: Factor,
{
    /// Number of raw samples per clean sample.
    pub const FACTOR: usize = FACTOR;
    /// Samples between the centre of the taps of an output and the call that returns it.
    const LAG: usize = Filters::<3, FACTOR>::DELAY + Filters::<3, FACTOR>::LATENCY;
    /// Raw samples between the instant of a clean sample and the call that returns it.
    pub const DELAY: usize = Self::LAG + 1;
    /// Samples to the next centre before a call that returns an output.
    #[expect(clippy::cast_possible_truncation, reason = "below the factor, at most 48")]
    const OUTPUT: u16 = ((FACTOR - Self::LAG % FACTOR) % FACTOR) as u16;
    /// Samples before the first centre of an output.
    #[expect(clippy::cast_possible_truncation, reason = "below the factor, at most 48")]
    const FIRST_CENTRE: u16 =
        ((Filters::<3, FACTOR>::NEWEST + FACTOR * CELLS as usize - Filters::<3, FACTOR>::DELAY) % FACTOR) as u16;
    /// Centres kept since that of an output.
    #[expect(clippy::cast_possible_truncation, reason = "checked")]
    const BACK: u8 = {
        assert!(Self::LAG / FACTOR < CELLS as usize, "cells for the delay");
        (Self::LAG / FACTOR) as u8
    };

    /// Checks the constants and creates a chain without samples.
    ///
    /// # Errors
    /// The first constant that is out of range.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive, and `as` saturates")]
    pub fn new(constants: &FrontEndConstants) -> Result<Self, FrontEndError> {
        constants.check()?;
        Ok(Self {
            sensors: CurrentSensors::new(constants.sensors, constants.stuck_samples),
            balance: CurrentBalance::new(constants.balance),
            tracker: PositionTracker::new(&constants.tracking, constants.control_rate_hz),
            frame: constants.frame,
            velocity_scale: 0.5 * RAD * constants.control_rate_hz,
            held: Held::MISSING,
            before: Angle::ZERO,
            measured: 0,
            filters: Filters::<3, FACTOR>::NEW,
            further: Filters::<FURTHER, FACTOR>::NEW,
            centres: Centres::NEW,
            to_centre: Self::FIRST_CENTRE,
            next: None,
            spoilt: 0,
            gaps: 0,
            late: false,
            held_back: (LONGEST_START_S * constants.control_rate_hz / FACTOR as f32) as u16,
        })
    }

    /// Takes a raw sample; every [`Self::FACTOR`]-th call returns a clean one once the angle is known and the filters
    /// are filled: segments start with the first complete sample, in the drive as in training.
    #[inline]
    pub fn push(&mut self, raw: &RawSample<FURTHER>) -> Option<CleanSample<FURTHER>> {
        if self.next != Some(raw.number) {
            self.resume(raw.number);
        }
        self.next = Some(raw.number.wrapping_add(1));
        if let PhaseCounts::Quadrature(current_a) = raw.currents {
            return self.push_quadrature(current_a, raw);
        }
        let currents = self.sensors.convert(&raw.currents);
        let mut now = Held { further: raw.further, ..Held::MISSING };
        let tracked = self.tracker.push(&raw.position);
        if let Some(Tracked { angle, .. }) = tracked {
            let electrical = self.frame.electrical(angle);
            let turn = electrical.sin_cos();
            self.balance.gather(currents, electrical, turn);
            // In a sample that gives no output, so that an interrupt has one of the two at a time.
            if self.balance.is_full() && (FACTOR == 1 || self.to_centre != Self::OUTPUT) {
                self.balance.close();
                self.sensors.shift(self.balance.remove_offsets());
            }
            if self.balance.imbalance().is_none() {
                now.current_a = self.frame.park.forward(currents.clarke(), turn).q;
            }
        }
        self.advance(now, tracked)
    }

    /// The same of a quadrature current that the drive makes itself.
    // Out of line, so that drives with counts have no code for it in their interrupt.
    #[inline(never)]
    fn push_quadrature(&mut self, current_a: f32, raw: &RawSample<FURTHER>) -> Option<CleanSample<FURTHER>> {
        self.balance.is_not_checked();
        let current_a = if current_a.is_finite() { current_a } else { f32::NAN };
        let now = Held { current_a, further: raw.further, ..Held::MISSING };
        let tracked = self.tracker.push(&raw.position);
        self.advance(now, tracked)
    }

    /// Holds this sample, and decimates the one that was held.
    #[inline(always)]
    fn advance(&mut self, mut now: Held<FURTHER>, tracked: Option<Tracked>) -> Option<CleanSample<FURTHER>> {
        let mut velocity_rad_s = f32::NAN;
        if let Some(tracked @ Tracked { angle, error_rad }) = tracked {
            (now.angle, now.error_rad, now.measured) = (angle, error_rad, tracked.measured());
            if self.measured < 2 {
                self.measured = self.measured.wrapping_add(1);
            } else {
                velocity_rad_s = now.measured.since(self.before) as f32 * self.velocity_scale; // (3)
            }
        } else {
            self.measured = 0;
        }
        let mut held = core::mem::replace(&mut self.held, now);
        self.before = held.measured;
        if self.spoilt > 0 {
            self.spoilt = self.spoilt.wrapping_sub(1);
            (held, velocity_rad_s) = (Held::MISSING, f32::NAN);
        }
        self.filter(held, velocity_rad_s)
    }

    /// Takes a raw sample at commissioning, for a check of the wiring instead of the filters; the velocity is one of
    /// the drive's own, rad/s, NaN if there is none.
    pub fn check_wiring(&mut self, raw: &RawSample<FURTHER>, velocity_rad_s: f32, check: &mut WiringCheck) {
        if self.next != Some(raw.number) {
            self.resume(raw.number);
            check.skip();
        }
        self.next = Some(raw.number.wrapping_add(1));
        // The filters do not get this sample: they contain earlier ones.
        (self.measured, self.spoilt) = (0, SPOILT + 1);
        let currents = self.sensors.convert(&raw.currents).clarke();
        match self.tracker.push(&raw.position) {
            Some(tracked) => check.push(currents, tracked.measured(), velocity_rad_s),
            None => check.skip(),
        }
    }

    /// Decimates the sample that was held.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "an error of the angle below π; `as` saturates")]
    fn filter(&mut self, held: Held<FURTHER>, velocity_rad_s: f32) -> Option<CleanSample<FURTHER>> {
        let (signals, further) = ([held.current_a, velocity_rad_s, held.error_rad], held.further);
        if self.to_centre == 0 {
            self.centres.put(held.angle);
            self.to_centre = const { FACTOR as u16 };
        }
        self.to_centre = self.to_centre.wrapping_sub(1);
        let further = self.further.push(further);
        let [current_a, velocity_rad_s, error_rad] = self.filters.push(signals)?;
        let angle = self.centres.get(Self::BACK).turned((error_rad * (1.0 / RAD)) as i32); // (1)
        let further = further.unwrap_or([f32::NAN; FURTHER]);
        if self.held_back > 0 {
            self.held_back = self.held_back.wrapping_sub(1);
            if !(current_a + velocity_rad_s).is_finite() {
                return None;
            }
            self.held_back = 0;
        }
        let (found_late, alignment) = (self.found_late(), self.balance.alignment());
        Some(CleanSample { current_a, velocity_rad_s, angle, further, found_late, alignment })
    }

    /// Whether a fault that shows only after a window of samples is there now, and was not at the last output.
    #[inline(always)]
    fn found_late(&mut self) -> bool {
        let position = self.tracker.mismatched() || self.tracker.has_stuck_bit();
        let late = self.sensors.any_stuck() || self.balance.imbalance().is_some() || position;
        let before = core::mem::replace(&mut self.late, late);
        late && !before
    }

    /// The first sample, or the first one after a gap.
    #[cold]
    #[inline(never)]
    fn resume(&mut self, number: u32) {
        let Some(next) = self.next else { return };
        self.gaps = self.gaps.saturating_add(1);
        self.tracker.skip(number.wrapping_sub(next));
        self.measured = 0;
        // The sample that is held is the last one before the gap; then come two behind it.
        self.spoilt = SPOILT + 1;
    }

    /// What was refused, and what is wrong now.
    #[must_use]
    pub const fn faults(&self) -> Faults {
        Faults {
            currents: self.sensors.faults(),
            imbalance: self.balance.imbalance(),
            unbalanced_windows: self.balance.unbalanced_windows(),
            last_imbalance: self.balance.last_imbalance(),
            offsets_a: self.balance.removed_a(),
            position: self.tracker.faults(),
            lock: self.tracker.lock(),
            gaps: self.gaps,
            alignment: self.balance.alignment(),
        }
    }

    /// Counts from zero; what is wrong now stays.
    pub fn clear_faults(&mut self) {
        self.sensors.clear_faults();
        self.balance.clear_faults();
        self.tracker.clear_faults();
        self.gaps = 0;
    }

    /// The rotor frame, for [`Model::check_rotor_frame`](crate::Model::check_rotor_frame).
    #[must_use]
    pub const fn frame(&self) -> &RotorFrame {
        &self.frame
    }
}

#[cfg(test)]
mod tests;
