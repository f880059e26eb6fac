//! The wiring of a drive at commissioning: phase order, pole pairs, electrical offset, delay, direction and rate, from
//! a motion under current control.
//!
//! ```text
//! i = j i_q exp(j (p θ + φ)),   i_d = 0                                          field-oriented control (1)
//! S_k = Σ i² exp(−2 j k θ),   R_k = |S_k| / Σ |i|²,   k = ±1 … ±16, ±p           (2)
//! D± = Σ i² exp(−2 j (p θ + φ₀)) over forward and backward motion
//! ½ arg(−D±) = φ − φ₀ ∓ p |ω| τ                                                  (3)
//! ```
//!
//! The current vector turns with the rotor, to and fro along its q axis. Its square does not depend on the sign of
//! `i_q`: R is 1 for the true number of pole pairs, negative if the phases or the angle run backward, and less for
//! every other k once the shaft has been at all angles. (3) gives the error of the offset φ₀ and, if the shaft turned
//! both ways, the delay τ of the current behind the angle. A sample is taken when the shaft has moved by 1/128 turn.
//! The velocity, if there is one, is compared with the angle by [`Travel`].
//!
//! Directions are relative: of phase order, angle and velocity the one that differs from the other two is named. Not
//! found are an offset that is wrong by half a turn and a wrong sign of all currents, which the torque balance of the
//! first segment contradicts ([`Implausible`](crate::Implausible)), and a common error of all gains. Field weakening is
//! a current along the d axis: stay below it.
//!
//! Cost: a comparison of angles a sample; the sums (2) and (3) 128 times a turn.

use core::fmt;

use super::RotorFrame;
use crate::signal::{AlphaBeta, Angle, RAD, SinCos, Travel, TravelSums};

/// Largest number of pole pairs that is tried besides that of the frame.
pub const MAX_POLE_PAIRS: usize = 16;
/// Motion between two samples that are taken, counts of 2⁻³² turn.
const STEP: u32 = 1 << 25;
/// Samples taken at most: sums of more would lose digits.
const MOST: u32 = 1 << 16;
/// Least R of a current that turns with the rotor: with noise of half the current, R is 0.7.
const COHERENT: f32 = 0.6;
/// Another k must fit better by this much.
const BETTER: f32 = 0.1;
/// Part of the current that each direction must have for a delay.
const BOTH_WAYS: f32 = 0.2;

/// A complex sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Complex {
    re: f32,
    im: f32,
}

impl Complex {
    #[inline(always)]
    fn add(&mut self, re: f32, im: f32) {
        self.re += re;
        self.im += im;
    }

    fn magnitude(self) -> f32 {
        libm::sqrtf(self.re * self.re + self.im * self.im)
    }

    /// Half the angle of −z, −π/2 … π/2.
    fn half_angle(self) -> f32 {
        0.5 * libm::atan2f(-self.im, -self.re)
    }
}

/// What a wiring must be like.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WiringLimits {
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

/// What is wrong with the wiring, or why nothing can be said.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum WiringFault {
    /// The shaft has not been at all angles of a turn.
    TooLittleMotion {
        /// Sectors of 1/16 turn in which it was.
        sectors: u8,
    },
    /// The current is too small.
    TooLittleCurrent {
        /// Its root mean square, A.
        rms_a: f32,
    },
    /// The current vector does not turn with the shaft: wrong phases or sensors, a slipping or multiplied angle, or no
    /// field-oriented control.
    NotTurning {
        /// Largest R of (2).
        coherence: f32,
    },
    /// The number of pole pairs is wrong.
    PolePairs {
        /// The number that fits; negative if the phases run against the angle, too.
        fits: i8,
    },
    /// The phases run against angle and velocity: two are exchanged.
    PhaseOrder,
    /// The angle runs against phases and velocity.
    AngleDirection,
    /// The velocity runs against phases and angle.
    VelocityDirection,
    /// Phases and angle run against each other; there is no velocity to tell which is wrong.
    PhaseOrderOrAngle,
    /// The velocity is not that of the angle: its unit or the control rate is wrong.
    RateOrUnit {
        /// Integral of the velocity over motion of the angle.
        ratio: f32,
    },
    /// The electrical offset is wrong.
    Offset {
        /// What must be added to it, rad, but for half a turn.
        error_rad: f32,
    },
    /// Current and angle are not of one instant.
    Delay {
        /// Delay of the current behind the angle, s.
        delay_s: f32,
    },
}

impl WiringFault {
    /// The fault in words.
    #[must_use]
    pub const fn message(&self) -> &'static str {
        match self {
            Self::TooLittleMotion { .. } => "the shaft has not been at all angles of a turn",
            Self::TooLittleCurrent { .. } => "the current is too small to check the wiring",
            Self::NotTurning { .. } => "the current does not turn with the shaft",
            Self::PolePairs { .. } => "the number of pole pairs is wrong",
            Self::PhaseOrder => "two phases are exchanged",
            Self::AngleDirection => "the angle has the wrong direction",
            Self::VelocityDirection => "the velocity has the wrong sign",
            Self::PhaseOrderOrAngle => "two phases are exchanged, or the angle has the wrong direction",
            Self::RateOrUnit { .. } => "the control rate or the unit of the velocity is wrong",
            Self::Offset { .. } => "the electrical offset is wrong",
            Self::Delay { .. } => "current and angle are not sampled at the same time",
        }
    }
}

impl fmt::Display for WiringFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for WiringFault {}

/// A wiring without fault.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wiring {
    /// R of (2) for the pole pairs of the frame.
    pub coherence: f32,
    /// Error of the electrical offset, rad.
    pub offset_rad: f32,
    /// Delay of the current behind the angle, s; `None` if the shaft turned one way only.
    pub delay_s: Option<f32>,
    /// Integral of the velocity over motion of the angle; `None` without a velocity: then its sign, its unit and the
    /// control rate are not checked.
    pub velocity_ratio: Option<f32>,
}

/// Checks the wiring while the drive moves. [`FrontEnd::check_wiring`](super::FrontEnd::check_wiring) feeds it from
/// raw counts.
///
/// ```
/// use bearing_watch::drive::{AlphaBeta, RotorFrame, WiringCheck, WiringFault, WiringLimits};
/// use bearing_watch::{Angle, Park};
/// let frame = RotorFrame { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard };
/// let limits = WiringLimits {
///     least_current_a: 0.5, offset_rad: 0.1, delay_s: 1e-4, velocity_tolerance: 0.05, slowest_rad_s: 5.0,
/// };
/// let mut check = WiringCheck::new(frame, 10_000.0, limits);
/// for k in 0..2000_u32 {
///     let shaft = Angle::from_counts(k, 10); // 61 rad/s
///     let electrical = shaft.times(4).sin_cos(); // a motor of four pole pairs
///     let currents = AlphaBeta { alpha: -3.0 * electrical.sin, beta: 3.0 * electrical.cos, zero: 0.0 };
///     check.push(currents, shaft, f32::NAN);
/// }
/// assert_eq!(check.conclude(), Err(WiringFault::PolePairs { fits: 4 }));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WiringCheck {
    frame: RotorFrame,
    interval_s: f32,
    limits: WiringLimits,
    /// S of (2) for k and −k.
    sums: [[Complex; 2]; MAX_POLE_PAIRS],
    /// D of (3), forward and backward.
    directions: [Complex; 2],
    /// Σ |i|², forward and backward.
    power: [f32; 2],
    /// Σ |i|² |ω|, in rad a sample.
    speed: f32,
    taken: u32,
    /// The shaft angle of the last sample that was taken, and that of the last one.
    at: Angle,
    last: Option<Angle>,
    sectors: u16,
    travel: Travel,
    travel_sums: TravelSums,
}

impl WiringCheck {
    /// No samples yet.
    #[must_use]
    pub fn new(frame: RotorFrame, control_rate_hz: f32, limits: WiringLimits) -> Self {
        Self {
            frame,
            interval_s: 1.0 / control_rate_hz,
            limits,
            sums: [[Complex::default(); 2]; MAX_POLE_PAIRS],
            directions: [Complex::default(); 2],
            power: [0.0; 2],
            speed: 0.0,
            taken: 0,
            at: Angle::ZERO,
            last: None,
            sectors: 0,
            travel: Travel::default(),
            travel_sums: TravelSums::default(),
        }
    }

    /// Takes the currents, A, the shaft angle and the velocity, rad/s, NaN if there is none, of one control interval.
    pub fn push(&mut self, currents: AlphaBeta, shaft: Angle, velocity_rad_s: f32) {
        let Some(last) = self.last.replace(shaft) else {
            self.at = shaft;
            return;
        };
        let turned = shaft.since(last);
        if !velocity_rad_s.is_finite() {
            self.travel.restart();
        } else if self.travel.step(turned, velocity_rad_s) {
            self.travel.close(&mut self.travel_sums, self.limits.slowest_rad_s * self.interval_s);
        }
        let power = currents.alpha * currents.alpha + currents.beta * currents.beta;
        if shaft.since(self.at).unsigned_abs() >= STEP && power.is_finite() && self.taken < MOST {
            self.at = shaft;
            self.take(currents, power, shaft, turned);
        }
    }

    /// A sample is missing.
    pub const fn skip(&mut self) {
        self.last = None;
        self.travel.restart();
    }

    fn take(&mut self, AlphaBeta { alpha, beta, .. }: AlphaBeta, power: f32, shaft: Angle, turned: i32) {
        self.taken = self.taken.saturating_add(1);
        self.sectors |= 1 << ((shaft.bits() >> 28) as u16);
        let (re, im) = (alpha * alpha - beta * beta, 2.0 * alpha * beta);
        let step = shaft.times(2).sin_cos();
        let mut turn = step;
        for [forward, backward] in &mut self.sums {
            let SinCos { sin, cos } = turn;
            forward.add(re * cos + im * sin, im * cos - re * sin); // (2)
            backward.add(re * cos - im * sin, im * cos + re * sin);
            turn = SinCos { sin: sin * step.cos + cos * step.sin, cos: cos * step.cos - sin * step.sin };
        }
        let SinCos { sin, cos } = self.frame.electrical(shaft).times(2).sin_cos();
        let ([ahead, back], [power_ahead, power_back]) = (&mut self.directions, &mut self.power);
        let (direction, directed_power) = if turned < 0 { (back, power_back) } else { (ahead, power_ahead) };
        direction.add(re * cos + im * sin, im * cos - re * sin);
        *directed_power += power;
        self.speed += power * (turned.unsigned_abs() as f32 * RAD);
    }

    /// The wiring.
    ///
    /// # Errors
    /// The first fault: motion and current, pole pairs and phase order, directions, rate, offset, delay. After a remedy
    /// check again.
    pub fn conclude(&self) -> Result<Wiring, WiringFault> {
        let sectors = self.sectors.count_ones();
        if sectors < u16::BITS {
            return Err(WiringFault::TooLittleMotion { sectors: u8::try_from(sectors).unwrap_or(0) });
        }
        let power: f32 = self.power.iter().sum();
        let rms_a = libm::sqrtf(power / self.taken as f32);
        let is_enough = rms_a >= self.limits.least_current_a;
        if !is_enough {
            return Err(WiringFault::TooLittleCurrent { rms_a });
        }
        let velocity_ratio = self.travel_sums.ratio(self.interval_s);
        let coherence = self.turning(power, velocity_ratio)?;
        if let Some(ratio) = velocity_ratio {
            if ratio < 0.0 {
                return Err(WiringFault::VelocityDirection);
            }
            let agrees = (ratio - 1.0).abs() <= self.limits.velocity_tolerance;
            if !agrees {
                return Err(WiringFault::RateOrUnit { ratio });
            }
        }
        let (offset_rad, delay_s) = self.offset_and_delay(power);
        // Compared so that a limit that is no number admits nothing.
        let is_prompt = |delay_s: f32| delay_s.abs() <= self.limits.delay_s;
        let is_within = offset_rad.abs() <= self.limits.offset_rad;
        if !is_within {
            return Err(WiringFault::Offset { error_rad: offset_rad });
        }
        match delay_s {
            Some(delay_s) if !is_prompt(delay_s) => Err(WiringFault::Delay { delay_s }),
            _ => Ok(Wiring { coherence, offset_rad, delay_s, velocity_ratio }),
        }
    }

    /// R of the frame's pole pairs, or what fits better.
    fn turning(&self, power: f32, velocity_ratio: Option<f32>) -> Result<f32, WiringFault> {
        let [ahead, back] = self.directions;
        let sum = Complex { re: ahead.re + back.re, im: ahead.im + back.im };
        let coherence = sum.magnitude() / power;
        let (mut fits, mut best) = (0_i8, 0.0);
        for (k, [forward, backward]) in (1_i8..).zip(&self.sums) {
            for (k, sum) in [(k, forward), (k.saturating_neg(), backward)] {
                let fit = sum.magnitude() / power;
                if fit > best {
                    (fits, best) = (k, fit);
                }
            }
        }
        if coherence.max(best) < COHERENT {
            return Err(WiringFault::NotTurning { coherence: coherence.max(best) });
        }
        if best < coherence + BETTER {
            return Ok(coherence);
        }
        if u32::from(fits.unsigned_abs()) != self.frame.pole_pairs {
            return Err(WiringFault::PolePairs { fits });
        }
        Err(match velocity_ratio {
            None => WiringFault::PhaseOrderOrAngle,
            Some(ratio) if ratio < 0.0 => WiringFault::AngleDirection,
            Some(_) => WiringFault::PhaseOrder,
        })
    }

    /// (3)
    fn offset_and_delay(&self, power: f32) -> (f32, Option<f32>) {
        let ([ahead, back], [power_ahead, power_back]) = (self.directions, self.power);
        if power_ahead.min(power_back) < BOTH_WAYS * power {
            return (Complex { re: ahead.re + back.re, im: ahead.im + back.im }.half_angle(), None);
        }
        // D− D+* has the angle 4 p |ω| τ, from −π to π.
        let twice =
            Complex { re: back.re * ahead.re + back.im * ahead.im, im: back.im * ahead.re - back.re * ahead.im };
        let apart = 0.25 * libm::atan2f(twice.im, twice.re);
        let SinCos { sin, cos } = Angle::from_radians(2.0 * apart).sin_cos();
        let middle = Complex { re: ahead.re * cos - ahead.im * sin, im: ahead.im * cos + ahead.re * sin };
        let omega = self.speed / (power * self.interval_s);
        (middle.half_angle(), Some(apart / (self.frame.pole_pairs as f32 * omega)))
    }
}

#[cfg(test)]
mod tests;
