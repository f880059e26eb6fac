//! A spall whose balls slip: another order than the kinematic one, pulses of another width, pulses that grow with the
//! load.
//!
//! ```text
//! dx/dt = O (1 + s + j) ω/2π                                                     (1)
//! j(k) = p j(k−1) + σ √(1 − p²) g(k),   p = exp(−Ts/τ),   g ~ N(0, 1)            (2)
//! T = Td (d₀/d) a tanh(ω/ω₀) p(x; d) − ε Kt i [cos(ξ+θ) + cos(ξ−θ)
//!                                             + ½cos(2ξ+θ) + ½cos(2ξ−θ)],   ξ = 2πx     (3)
//! a = min(a₀ + |T_load|/T₁, a₁)                                                  (4)
//! ```
//!
//! x is the phase of the defect in periods, O the order of the outer race, s the slip of the record and j its
//! fluctuation. (3) is the spall of [`bearing`](crate::rig::bearing) with pulses of width d instead of d₀ = 0.15 and of
//! the same mean torque. Other defects do not depend on slip.

use core::f64::consts::TAU;

use crate::rig::bearing::{PULSE_DUTY, direction, pulse};
use crate::rig::{DefectTorque, NoiseSource, PlantState, RigError, not_negative, positive};

/// Ranges of the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slip {
    /// Lower and upper limit of |s| of (1); the sign is random.
    pub slip: [f64; 2],
    /// σ of (2).
    pub jitter: f64,
    /// τ of (2).
    pub correlation_s: f64,
    /// Lower and upper limit of d of (3).
    pub width: [f64; 2],
    /// a₀ of (4).
    pub load_floor: f64,
    /// T₁ of (4).
    pub load_scale_nm: f64,
    /// a₁ of (4).
    pub load_ceiling: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlipValues {
    /// s of (1).
    pub slip: f64,
    /// d of (3).
    pub width: f64,
    /// The ranges that they were drawn from.
    pub ranges: Slip,
}

impl Slip {
    /// The ranges of the field.
    pub const FIELD: Self = Self {
        slip: [0.002, 0.02],
        jitter: 0.003,
        correlation_s: 0.3,
        width: [0.05, 0.6],
        load_floor: 0.5,
        load_scale_nm: 0.15,
        load_ceiling: 2.0,
    };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        for slip in self.slip {
            super::fraction("field.slip.slip", slip)?;
        }
        super::fraction("field.slip.jitter", self.jitter)?;
        positive("field.slip.correlation_s", self.correlation_s)?;
        for width in self.width {
            positive("field.slip.width", width)?;
            super::fraction("field.slip.width", width)?;
        }
        not_negative("field.slip.load_floor", self.load_floor)?;
        positive("field.slip.load_scale_nm", self.load_scale_nm)?;
        not_negative("field.slip.load_ceiling", self.load_ceiling)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> SlipValues {
        let size = super::between(&mut source, self.slip);
        let slip = if source.uniform(-1.0, 1.0) < 0.0 { -size } else { size };
        SlipValues { slip, width: super::between(&mut source, self.width), ranges: *self }
    }
}

/// The bearing with slip, advanced once a sample.
#[derive(Debug, Clone)]
pub(super) struct SlippingBearing {
    values: SlipValues,
    source: NoiseSource,
    pole: f64,
    jitter: f64,
    order: f64,
    anchor_rad: f64,
    anchor_periods: f64,
}

impl SlippingBearing {
    /// A bearing of outer-race order `order` on a shaft at `angle_rad`; its balls start as without slip.
    pub(super) fn new(
        values: SlipValues,
        mut source: NoiseSource,
        order: f64,
        angle_rad: f64,
        sample_time_s: f64,
    ) -> Self {
        let jitter = values.ranges.jitter * source.gaussian();
        Self {
            values,
            source,
            pole: libm::exp(-sample_time_s / values.ranges.correlation_s),
            jitter,
            order,
            anchor_rad: angle_rad,
            anchor_periods: order * angle_rad / TAU,
        }
    }

    /// Draws the fluctuation of the next sampling interval; the shaft is at `angle_rad`.
    pub(super) fn advance(&mut self, angle_rad: f64) {
        (self.anchor_periods, self.anchor_rad) = (self.periods(angle_rad), angle_rad);
        let drive = self.values.ranges.jitter * (1.0 - self.pole * self.pole).sqrt();
        self.jitter = self.pole * self.jitter + drive * self.source.gaussian(); // (2)
    }

    /// x at an angle within the sampling interval: the integral of (1).
    fn periods(&self, angle_rad: f64) -> f64 {
        let order = self.order * (1.0 + self.values.slip + self.jitter);
        self.anchor_periods + order * (angle_rad - self.anchor_rad) / TAU
    }

    /// The torque of the defect that opposes positive rotation, under an external load.
    pub(super) fn torque_nm(&self, law: &DefectTorque, at: &PlantState, load_nm: f64) -> f64 {
        match *law {
            DefectTorque::Spall { pulse_nm, ripple_nm_per_a, .. } => {
                self.spall_nm(at, load_nm, pulse_nm, ripple_nm_per_a)
            }
            DefectTorque::SpallAndViscous { pulse_nm, ripple_nm_per_a, friction_nm_s_per_rad, .. } => {
                self.spall_nm(at, load_nm, pulse_nm, ripple_nm_per_a) + friction_nm_s_per_rad * at.velocity_rad_s
            }
            _ => law.at(at),
        }
    }

    /// Equation (3); the bracket is 2 cos θ (cos ξ + ½ cos 2ξ).
    fn spall_nm(&self, at: &PlantState, load_nm: f64, pulse_nm: f64, ripple_nm_per_a: f64) -> f64 {
        let Slip { load_floor, load_scale_nm, load_ceiling, .. } = self.values.ranges;
        let growth = (load_floor + load_nm.abs() / load_scale_nm).min(load_ceiling); // (4)
        let periods = self.periods(at.angle_rad);
        let height = pulse_nm * PULSE_DUTY / self.values.width * growth;
        let drag = height * direction(at.velocity_rad_s) * pulse(periods, self.values.width);
        let cos = libm::cos(TAU * periods);
        let bracket = 2.0 * libm::cos(at.angle_rad) * (cos + cos * cos - 0.5);
        drag - ripple_nm_per_a * at.current_a * bracket
    }
}
