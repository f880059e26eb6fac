//! The measured current, and the dead time of the bridge.
//!
//! ```text
//! i_m = Q((1 + g) y + n + o + r |o| sin(6θ + φ))                   (1)
//! v_applied = v − V_d tanh(u / (V_d + R i₀)),   u = v − Ke ω       (2)
//! ```
//!
//! y is the filtered current and n its noise. Q rounds to steps of the converter and limits to its range. With u as in
//! (2), `i = (u − drop)/R` has the slope of the implicit law `R i = u − V_d tanh(i/i₀)` at zero and its value at large
//! currents. If the current is a state of the motor, the drop is `V_d tanh(i/i₀)`.

use core::f64::consts::TAU;

use crate::rig::{Electrical, MotorParameters, NoiseSource, PlantState, RigError, not_negative, positive};

/// Order of the ripple of (1), periods per turn.
const RIPPLE_ORDER: f64 = 6.0;

/// Ranges of the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentChain {
    /// Range of the converter, ± this current.
    pub full_scale_a: f64,
    /// Lower and upper limit of |o| of (1), relative to the range; the sign is random.
    pub offset: [f64; 2],
    /// Largest |g| of (1).
    pub gain: f64,
    /// Number of bits of the converter over its whole range.
    pub bits: u32,
    /// r of (1).
    pub ripple: f64,
    /// Lower and upper limit of V_d of (2).
    pub dead_time_v: [f64; 2],
    /// i₀ of (2).
    pub dead_time_current_a: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentChainValues {
    /// Range of the converter, ± this current.
    pub full_scale_a: f64,
    /// o of (1).
    pub offset_a: f64,
    /// 1 + g of (1).
    pub gain: f64,
    /// Resolution of Q.
    pub step_a: f64,
    /// r |o| of (1).
    pub ripple_a: f64,
    /// φ of (1).
    pub ripple_phase_rad: f64,
    /// V_d of (2).
    pub dead_time_v: f64,
    /// i₀ of (2).
    pub dead_time_current_a: f64,
}

impl CurrentChain {
    /// The ranges of the field.
    pub const FIELD: Self = Self {
        full_scale_a: 20.0,
        offset: [0.005, 0.02],
        gain: 0.02,
        bits: 12,
        ripple: 0.25,
        dead_time_v: [0.1, 0.4],
        dead_time_current_a: 0.2,
    };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        positive("field.current_chain.full_scale_a", self.full_scale_a)?;
        for offset in self.offset {
            not_negative("field.current_chain.offset", offset)?;
        }
        not_negative("field.current_chain.gain", self.gain)?;
        super::within("field.current_chain.bits", f64::from(self.bits), [1.0, 30.0])?;
        not_negative("field.current_chain.ripple", self.ripple)?;
        for limit in self.dead_time_v {
            not_negative("field.current_chain.dead_time_v", limit)?;
        }
        positive("field.current_chain.dead_time_current_a", self.dead_time_current_a)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> CurrentChainValues {
        let size = self.full_scale_a * super::between(&mut source, self.offset);
        let sign = if source.uniform(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
        CurrentChainValues {
            full_scale_a: self.full_scale_a,
            offset_a: sign * size,
            gain: 1.0 + source.uniform(-self.gain, self.gain),
            step_a: 2.0 * self.full_scale_a / f64::from(1_u32 << self.bits),
            ripple_a: self.ripple * size,
            ripple_phase_rad: source.uniform(0.0, TAU),
            dead_time_v: super::between(&mut source, self.dead_time_v),
            dead_time_current_a: self.dead_time_current_a,
        }
    }
}

impl CurrentChainValues {
    /// The measured current (1); `current_a` is y and `noise_a` is n.
    #[must_use]
    pub fn measured_a(&self, current_a: f64, noise_a: f64, angle_rad: f64) -> f64 {
        let ripple = self.ripple_a * libm::sin(RIPPLE_ORDER * angle_rad + self.ripple_phase_rad);
        let seen = self.gain * current_a + noise_a + self.offset_a + ripple;
        let counts = (seen / self.step_a).round();
        let most = (self.full_scale_a / self.step_a).round();
        counts.clamp(-most, most - 1.0) * self.step_a
    }

    /// The voltage (2) that the bridge applies if the controller commands `command_v`.
    #[must_use]
    pub fn applied_v(&self, command_v: f64, at: &PlantState, motor: &MotorParameters, electrical: Electrical) -> f64 {
        let (vd, i0) = (self.dead_time_v, self.dead_time_current_a);
        let part = match electrical {
            Electrical::BothStates => at.current_a / i0,
            Electrical::QuasiStatic => {
                let u = command_v - motor.ke_v_s_per_rad * at.velocity_rad_s;
                u / (vd + motor.r_ohm * i0)
            }
        };
        command_v - vd * libm::tanh(part) // (2)
    }
}
