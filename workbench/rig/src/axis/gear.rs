//! A gear: friction by direction and load, and torques of its wheels.
//!
//! ```text
//! T = tanh(ω/ω₀) (c± + μ± |T_load|)                friction; + forward, − backward            (1)
//!   + Σ a_k cos(o_k θ + ψ_k)                       ripple                                     (2)
//! o = z₁, z₂/r, 1/r                                teeth of the first and of the last wheel, its run-out
//! o = 2, 4, z₂/r, 1/r                              strain-wave gear, from a ratio of 30 on
//! ```
//!
//! θ is the angle of the motor, measured at the load side of a belt. The ripple (2) is a function of the angle, so that
//! it takes no energy over a period. The teeth belong to the type of axis; amplitudes, phases and friction are drawn.

use super::RATIOS;
use crate::bearing::direction;
use crate::{NoiseSource, RigError, fraction, not_negative, within};

/// Smallest ratio of a strain-wave gear.
pub const STRAIN_WAVE: f64 = 30.0;

/// Number of orders of (2).
const ORDERS: usize = 4;

/// Constants of a gear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gear {
    /// Nominal c±.
    pub friction_nm: f64,
    /// Nominal μ±.
    pub load_friction: f64,
    /// Nominal amplitude of (2).
    pub ripple_nm: f64,
    /// z₁, of the pinion on the motor.
    pub pinion_teeth: u32,
    /// z₂, of the last wheel.
    pub wheel_teeth: u32,
    /// Relative variation of friction and amplitudes, each for itself.
    pub spread: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearValues {
    /// c₊ and c₋.
    pub friction_nm: [f64; 2],
    /// μ₊ and μ₋.
    pub load_friction: [f64; 2],
    /// o_k of (2), per turn of the motor.
    pub orders: [f64; ORDERS],
    /// a_k of (2).
    pub ripple_nm: [f64; ORDERS],
    /// ψ_k of (2).
    pub phases_rad: [f64; ORDERS],
}

impl Gear {
    /// The gear of the conditions on the DC-motor rig.
    pub const ROTARY: Self = Self {
        friction_nm: 0.006,
        load_friction: 0.06,
        ripple_nm: 0.003,
        pinion_teeth: 17,
        wheel_teeth: 83,
        spread: 0.3,
    };

    /// The gear of the conditions on the actuator, for about ten times the torque.
    pub const LINEAR: Self = Self { friction_nm: 0.06, ripple_nm: 0.02, ..Self::ROTARY };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        not_negative("axis.gear.friction_nm", self.friction_nm)?;
        within("axis.gear.load_friction", self.load_friction, [0.0, 0.5])?;
        not_negative("axis.gear.ripple_nm", self.ripple_nm)?;
        within("axis.gear.pinion_teeth", f64::from(self.pinion_teeth), [5.0, 200.0])?;
        within("axis.gear.wheel_teeth", f64::from(self.wheel_teeth), [5.0, 1000.0])?;
        fraction("axis.gear.spread", self.spread)?;
        Ok(())
    }

    /// The gear of a record with this ratio, from 1 to 160.
    #[must_use]
    pub fn draw(&self, ratio: f64, mut source: NoiseSource) -> GearValues {
        let ratio = ratio.clamp(RATIOS[0], RATIOS[1]);
        let [pinion, wheel] = [self.pinion_teeth, self.wheel_teeth].map(f64::from);
        let mut vary = |nominal: f64| nominal * source.uniform(1.0 - self.spread, 1.0 + self.spread);
        let friction_nm = [0; 2].map(|_| vary(self.friction_nm));
        let load_friction = [0; 2].map(|_| vary(self.load_friction));
        let ripple = [0; ORDERS].map(|_| vary(self.ripple_nm));
        let phases_rad = [0; ORDERS].map(|_| source.uniform(-core::f64::consts::PI, core::f64::consts::PI));
        let (orders, [a, b, c, d]) = if ratio < STRAIN_WAVE {
            ([pinion, 2.0 * pinion, wheel / ratio, 1.0 / ratio], [1.0, 0.3, 1.0, 0.5])
        } else {
            ([2.0, 4.0, wheel / ratio, 1.0 / ratio], [1.5, 0.5, 0.5, 0.5])
        };
        let [ra, rb, rc, rd] = ripple;
        GearValues { friction_nm, load_friction, orders, ripple_nm: [a * ra, b * rb, c * rc, d * rd], phases_rad }
    }
}

impl GearValues {
    /// The torque that opposes positive motion, under a load of `load_nm`.
    pub(super) fn torque_nm(&self, angle_rad: f64, velocity_rad_s: f64, load_nm: f64) -> f64 {
        let back = usize::from(velocity_rad_s < 0.0);
        let dry = self.friction_nm[back] + self.load_friction[back] * load_nm.abs();
        direction(velocity_rad_s) * dry + self.ripple(angle_rad) // (1), (2)
    }

    fn ripple(&self, angle_rad: f64) -> f64 {
        let waves = self.orders.iter().zip(&self.ripple_nm).zip(&self.phases_rad);
        waves.map(|((order, amplitude), phase)| amplitude * libm::cos(order * angle_rad + phase)).sum() // (2)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::*;
    use crate::Stream;

    fn drawn(ratio: f64, seed: u64) -> GearValues {
        Gear::ROTARY.draw(ratio, NoiseSource::new(seed, Stream::Gear))
    }

    #[test]
    fn friction_depends_on_direction_and_load_and_opposes_motion() {
        let gear = GearValues {
            friction_nm: [0.01, 0.02],
            load_friction: [0.1, 0.05],
            ripple_nm: [0.0; ORDERS],
            ..drawn(50.0, 1)
        };
        // tanh 50 is 1; rounding only.
        for (velocity, load, torque) in
            [(50.0, 0.0, 0.01), (-50.0, 0.0, -0.02), (50.0, -0.4, 0.05), (-50.0, 0.4, -0.04), (0.0, 0.4, 0.0)]
        {
            assert!((gear.torque_nm(0.3, velocity, load) - torque).abs() < 1e-16, "{velocity} {load}");
        }
    }

    #[test]
    fn orders_are_those_of_the_wheels_and_two_of_a_strain_wave() {
        assert_eq!(drawn(5.0, 1).orders, [17.0, 34.0, 16.6, 0.2]);
        assert_eq!(drawn(50.0, 1).orders, [2.0, 4.0, 1.66, 0.02]);
        for ratio in [5.0, 50.0] {
            let gear = drawn(ratio, 3);
            // Over one turn of the last wheel each order is a whole number of periods: its phasor is its amplitude.
            let samples = 20_000;
            for ((order, amplitude), phase) in gear.orders.into_iter().zip(gear.ripple_nm).zip(gear.phases_rad) {
                let (mut x, mut y) = (0.0, 0.0);
                for k in 0..samples {
                    let theta = ratio * TAU * f64::from(k) / f64::from(samples);
                    let torque = gear.torque_nm(theta, 0.0, 0.0);
                    x += 2.0 * torque * (order * theta).cos() / f64::from(samples);
                    y -= 2.0 * torque * (order * theta).sin() / f64::from(samples);
                }
                // Rounding of 2e4 terms.
                assert!((x.hypot(y) - amplitude).abs() < 1e-12 && (y.atan2(x) - phase).abs() < 1e-9, "{order}");
            }
        }
    }
}
