//! The controller of the drive: position, velocity and current loop, one after the other at every control interval.
//!
//! ```text
//! ω_ref = Kx (x_ref − x_m)/N,            limited to ± the velocity limit                     (1)
//! i = Kp e + ξ,   ξ ← ξ + Ki T e,   e = ω_ref − ω_m,   i_q,ref = i limited                   (2)
//! v = Kc (e_c + (1 − a) ζ),   ζ ← ζ + e_c,   e_c = i_ref − i_m   for each axis, i_d,ref = 0  (3)
//! v_d ← v_d − pω_m L i_q,m,   v_q ← v_q + pω_m (L i_d,m + λ)     decoupling                   (4)
//! |v| ≤ U/√3                  magnitude limited, direction kept                               (5)
//! ```
//!
//! (3): the zero of the controller cancels the pole a = exp(−RT/L) of a winding with held voltage, and
//! `Kc = R (1 − exp(−w T))/(1 − a)` makes the closed loop exactly exp(−w t) at the samples, w being the bandwidth.
//!
//! Anti-windup: if (2) or (5) limits the output, the integrator is set as if the error had been the one that leads to
//! the limited output, `e − (unlimited − limited)/gain`.
//!
//! (5) is the largest vector of a bridge with bus voltage U without overmodulation. The voltage is held in the rotor
//! frame over the interval: a modulator that turns its vector with the rotor, and that has no delay.

use super::super::{RigError, not_negative, positive};
use super::{Actuator, DqVoltage};

/// Gains and limits of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveSettings {
    /// T, the interval of control.
    pub interval_s: f64,
    /// Kx of (1).
    pub position_gain_per_s: f64,
    /// Kp of (2).
    pub velocity_gain_a_s_per_rad: f64,
    /// Ki of (2).
    pub velocity_integral_a_per_rad: f64,
    /// w of (3).
    pub current_bandwidth_rad_s: f64,
    /// Limit of the q current.
    pub current_limit_a: f64,
    /// Limit of the velocity command.
    pub velocity_limit_rad_s: f64,
    /// Bus voltage U.
    pub bus_v: f64,
}

impl DriveSettings {
    /// The drive of the standard rig. The velocity limit is the 4572 rpm of thesis Table 5.1.
    pub const MAXFORCE: Self = Self {
        interval_s: 1.0 / 12_000.0,
        position_gain_per_s: 25.0,
        velocity_gain_a_s_per_rad: 0.45,
        velocity_integral_a_per_rad: 9.0,
        current_bandwidth_rad_s: 2000.0,
        current_limit_a: 40.0,
        velocity_limit_rad_s: 4572.0 * core::f64::consts::PI / 30.0,
        bus_v: 311.0,
    };

    /// Largest magnitude of the voltage vector (5).
    pub(crate) fn voltage_limit_v(&self) -> f64 {
        self.bus_v / 3.0_f64.sqrt() // (5)
    }

    /// Returns an error with the name of a setting that cannot be simulated.
    pub fn validate(&self) -> Result<(), RigError> {
        positive("drive.interval_s", self.interval_s)?;
        not_negative("drive.position_gain_per_s", self.position_gain_per_s)?;
        positive("drive.velocity_gain_a_s_per_rad", self.velocity_gain_a_s_per_rad)?;
        not_negative("drive.velocity_integral_a_per_rad", self.velocity_integral_a_per_rad)?;
        positive("drive.current_bandwidth_rad_s", self.current_bandwidth_rad_s)?;
        positive("drive.current_limit_a", self.current_limit_a)?;
        positive("drive.velocity_limit_rad_s", self.velocity_limit_rad_s)?;
        positive("drive.bus_v", self.bus_v)?;
        Ok(())
    }
}

/// What the controller measures at the start of an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feedback {
    /// Position.
    pub position_m: f64,
    /// Shaft velocity.
    pub velocity_rad_s: f64,
    /// Direct current.
    pub direct_a: f64,
    /// Quadrature current.
    pub quadrature_a: f64,
}

/// The commands of one interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Commands {
    /// ω_ref.
    pub velocity_ref_rad_s: f64,
    /// i_q,ref.
    pub current_ref_a: f64,
    /// Voltage in the measured rotor frame.
    pub voltage: DqVoltage,
}

/// The three loops. The controller knows the constants of the sound, cold actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    settings: DriveSettings,
    metres_per_rad: f64,
    pole_pairs: f64,
    l_h: f64,
    flux_wb: f64,
    limit_v: f64,
    /// Kc of (3).
    current_gain: f64,
    /// 1 − a of (3).
    current_zero: f64,
    /// ξ of (2).
    velocity_a: f64,
    /// ζ of (3), direct and quadrature.
    current_sums: [f64; 2],
}

impl Controller {
    /// A controller at rest, all integrators zero.
    #[must_use]
    pub fn new(settings: &DriveSettings, nominal: &Actuator) -> Self {
        let current_zero = -libm::expm1(-nominal.r_ohm * settings.interval_s / nominal.l_h);
        let closed = -libm::expm1(-settings.current_bandwidth_rad_s * settings.interval_s);
        Self {
            settings: *settings,
            metres_per_rad: nominal.metres_per_rad(),
            pole_pairs: f64::from(nominal.pole_pairs),
            l_h: nominal.l_h,
            flux_wb: nominal.flux_wb,
            limit_v: settings.voltage_limit_v(),
            current_gain: nominal.r_ohm * closed / current_zero, // (3)
            current_zero,
            velocity_a: 0.0,
            current_sums: [0.0; 2],
        }
    }

    /// Sets the integrators as if this q current had been held at standstill for a long time against resistance
    /// `r_ohm`.
    pub fn hold(&mut self, quadrature_a: f64, r_ohm: f64) {
        self.velocity_a = quadrature_a;
        self.current_sums = [0.0, r_ohm * quadrature_a / (self.current_gain * self.current_zero)];
    }

    /// All three loops for a position command.
    pub fn update(&mut self, position_ref_m: f64, feedback: &Feedback) -> Commands {
        let velocity_ref_rad_s = self.position_loop(position_ref_m, feedback.position_m);
        let current_ref_a = self.velocity_loop(velocity_ref_rad_s, feedback.velocity_rad_s);
        let voltage = self.current_loop(current_ref_a, feedback);
        Commands { velocity_ref_rad_s, current_ref_a, voltage }
    }

    /// The velocity command (1).
    pub(crate) fn position_loop(&self, position_ref_m: f64, position_m: f64) -> f64 {
        let limit = self.settings.velocity_limit_rad_s;
        let command = self.settings.position_gain_per_s * (position_ref_m - position_m) / self.metres_per_rad; // (1)
        command.clamp(-limit, limit)
    }

    /// The command of the q current (2).
    pub(crate) fn velocity_loop(&mut self, velocity_ref_rad_s: f64, velocity_rad_s: f64) -> f64 {
        let DriveSettings { velocity_gain_a_s_per_rad: kp, velocity_integral_a_per_rad: ki, .. } = self.settings;
        let error = velocity_ref_rad_s - velocity_rad_s;
        let free = kp * error + self.velocity_a;
        let limit = self.settings.current_limit_a;
        let command = free.clamp(-limit, limit);
        self.velocity_a += ki * self.settings.interval_s * (error - (free - command) / kp); // (2)
        command
    }

    /// The voltage (3)–(5).
    pub fn current_loop(&mut self, current_ref_a: f64, feedback: &Feedback) -> DqVoltage {
        let errors = [-feedback.direct_a, current_ref_a - feedback.quadrature_a];
        let electrical = self.pole_pairs * feedback.velocity_rad_s;
        let coupling = [
            -electrical * self.l_h * feedback.quadrature_a, // (4)
            electrical * (self.l_h * feedback.direct_a + self.flux_wb),
        ];
        let (gain, zero) = (self.current_gain, self.current_zero);
        let free = |axis: usize| gain * (errors[axis] + zero * self.current_sums[axis]) + coupling[axis]; // (3)
        let [d_v, q_v] = [free(0), free(1)];
        let scale = (self.limit_v / libm::hypot(d_v, q_v)).min(1.0); // (5)
        for (axis, free_v) in [d_v, q_v].into_iter().enumerate() {
            self.current_sums[axis] += errors[axis] - (free_v - scale * free_v) / gain;
        }
        DqVoltage { d_v: scale * d_v, q_v: scale * q_v }
    }
}

#[cfg(test)]
mod tests;
