//! The measured current, and the dead time of the bridge.
//!
//! ```text
//! i_m = Q((1 + g) y + n + o + r |o| sin(6θ + φ))                   (1)
//! v_applied = v − V_d tanh(i/i₀)                                   (2)
//! ```
//!
//! y is the filtered current and n its noise. Q rounds to steps of the converter and limits to its range. (2) is
//! evaluated once an integration step. A quasi-static current depends on the applied voltage, so that (2) becomes the
//! equation `R i + V_d tanh(i/i₀) = v − Ke ω`, which has one solution.

use core::f64::consts::TAU;

use super::draws::between;
use crate::{Electrical, MotorParameters, NoiseSource, PlantState, RigError, not_negative, positive, within};

/// Order of the ripple of (1), periods per turn.
const RIPPLE_ORDER: f64 = 6.0;
/// Largest error of the equation of a quasi-static current.
const NEWTON_V: f64 = 1e-9;
/// Largest number of Newton's steps.
const NEWTON_STEPS: u32 = 50;

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
        within("field.current_chain.bits", f64::from(self.bits), [1.0, 30.0])?;
        not_negative("field.current_chain.ripple", self.ripple)?;
        for limit in self.dead_time_v {
            not_negative("field.current_chain.dead_time_v", limit)?;
        }
        positive("field.current_chain.dead_time_current_a", self.dead_time_current_a)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> CurrentChainValues {
        let size = self.full_scale_a * between(&mut source, self.offset);
        let sign = if source.uniform(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
        CurrentChainValues {
            full_scale_a: self.full_scale_a,
            offset_a: sign * size,
            gain: 1.0 + source.uniform(-self.gain, self.gain),
            step_a: 2.0 * self.full_scale_a / f64::from(1_u32 << self.bits),
            ripple_a: self.ripple * size,
            ripple_phase_rad: source.uniform(0.0, TAU),
            dead_time_v: between(&mut source, self.dead_time_v),
            dead_time_current_a: self.dead_time_current_a,
        }
    }
}

impl CurrentChainValues {
    /// The measured current (1); `current_a` is y and `noise_a` is n.
    pub(crate) fn measured_a(&self, current_a: f64, noise_a: f64, angle_rad: f64) -> f64 {
        let ripple = self.ripple_a * libm::sin(RIPPLE_ORDER * angle_rad + self.ripple_phase_rad);
        let seen = self.gain * current_a + noise_a + self.offset_a + ripple;
        let counts = (seen / self.step_a).round();
        let most = (self.full_scale_a / self.step_a).round();
        counts.clamp(-most, most - 1.0) * self.step_a
    }

    /// The voltage (2) that the bridge applies if the controller commands `command_v`.
    pub(crate) fn applied_v(
        &self,
        command_v: f64,
        at: &PlantState,
        motor: &MotorParameters,
        electrical: Electrical,
    ) -> f64 {
        let current_a = match electrical {
            Electrical::BothStates => at.current_a,
            Electrical::QuasiStatic => {
                self.current_a(command_v - motor.ke_v_s_per_rad * at.velocity_rad_s, motor.r_ohm)
            }
        };
        command_v - self.drop_v(current_a) // (2)
    }

    fn drop_v(&self, current_a: f64) -> f64 {
        self.dead_time_v * libm::tanh(current_a / self.dead_time_current_a)
    }

    /// The current i of `R i + V_d tanh(i/i₀) = u`.
    fn current_a(&self, u: f64, r_ohm: f64) -> f64 {
        let (size, steepest) = (u.abs(), self.dead_time_v / self.dead_time_current_a);
        // Both bounds lie below the solution for |u|, where the left side is concave: Newton's steps only ascend to it.
        let mut i = (size / (r_ohm + steepest)).max((size - self.dead_time_v) / r_ohm);
        for _ in 0..NEWTON_STEPS {
            let part = libm::tanh(i / self.dead_time_current_a);
            let missing = size - r_ohm * i - self.dead_time_v * part;
            if missing <= NEWTON_V {
                break;
            }
            i += missing / (r_ohm + steepest * (1.0 - part * part));
        }
        i.copysign(u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::{QUIET, run};
    use crate::{Field, FieldValues, Scenario, Stream, TABLE_2_3};

    fn drawn(seed: u64) -> CurrentChainValues {
        CurrentChain::FIELD.draw(NoiseSource::new(seed, Stream::CurrentChain))
    }

    #[test]
    fn gain_and_offset_are_those_of_the_field_and_steps_are_whole() {
        let mut signs = [0_u32; 2];
        for seed in 0..300 {
            let chain = drawn(seed);
            signs[usize::from(chain.offset_a > 0.0)] += 1;
            assert!((0.1..0.4).contains(&chain.offset_a.abs()) && (0.98..1.02).contains(&chain.gain));
            assert!((0.1..0.4).contains(&chain.dead_time_v));
            for k in -15..=15 {
                let current = f64::from(k);
                // At this angle the ripple is zero.
                let measured = chain.measured_a(current, 0.0, -chain.ripple_phase_rad / 6.0);
                let counts = measured / (40.0 / 4096.0);
                assert_eq!(counts, counts.round());
                // Half a step, and rounding.
                assert!((measured - chain.gain * current - chain.offset_a).abs() < 0.5 * 40.0 / 4096.0 + 1e-12);
            }
            assert_eq!(
                (chain.measured_a(50.0, 0.0, 0.0), chain.measured_a(-50.0, 0.0, 0.0)),
                (20.0 - 40.0 / 4096.0, -20.0)
            );
        }
        // Four standard deviations of 300 coins: 2√300.
        assert!(signs[0].abs_diff(150) < 35, "{signs:?}");
    }

    #[test]
    fn ripple_has_six_periods_and_a_quarter_of_the_offset() {
        let chain = CurrentChainValues { step_a: 1e-9, ..drawn(3) };
        let (mut re, mut im) = (0.0, 0.0);
        for k in 0..360 {
            let theta = f64::from(k).to_radians();
            let ripple = chain.measured_a(0.0, 0.0, theta) - chain.offset_a;
            (re, im) = (re + ripple * (6.0 * theta).cos() / 180.0, im + ripple * (6.0 * theta).sin() / 180.0);
        }
        // Steps of 1e-9 A.
        assert!((re.hypot(im) - 0.25 * chain.offset_a.abs()).abs() < 1e-9);
    }

    #[test]
    fn dead_time_takes_its_voltage_off_in_the_direction_of_the_current() {
        for seed in 0..20 {
            let chain = drawn(seed);
            let at = PlantState { velocity_rad_s: 20.0, ..PlantState::default() };
            for k in -200..=200 {
                let u = 0.01 * f64::from(k);
                let applied = chain.applied_v(1.0 + u, &at, &TABLE_2_3, Electrical::QuasiStatic);
                let current = (applied - 1.0) / 0.5;
                // Newton's error of 1e-9 V moves the current by 2e-9 A at most, and the drop by V_d/i₀ times as much.
                assert!((1.0 + u - applied - chain.dead_time_v * (current / 0.2).tanh()).abs() < 6e-9, "{u}");
                assert!(current * u >= 0.0);
            }
            let both = PlantState { current_a: -3.0, ..at };
            let applied = chain.applied_v(1.0, &both, &TABLE_2_3, Electrical::BothStates);
            // tanh 15 is 1 − 2e-13.
            assert!((applied - 1.0 - chain.dead_time_v).abs() < 1e-12);
        }
    }

    #[test]
    fn at_constant_speed_the_controller_adds_the_dead_voltage() {
        let chain = CurrentChain { dead_time_current_a: 1e-3, ..CurrentChain::FIELD };
        let field = Field { current_chain: Some(chain), ..Field::NONE };
        // 80 rad/s: 0.16 A against the friction, which is far above 1 mA.
        let scenario = Scenario { field, reference_amplitude_rad_s: 80.0, ..QUIET };
        for seed in 0..3 {
            let vd = FieldValues::draw(&scenario, seed).current_chain.expect("on").dead_time_v;
            let trace = run(&scenario, seed);
            let omega = trace.velocity_rad_s[4999];
            let current = 1e-4 * omega / 0.05;
            // Settled: e⁻¹⁷ of a start that is off by V_d, and the error of the equation.
            assert!((trace.voltage_v[4999] - 0.05 * omega - 0.5 * current - vd).abs() < 1e-6, "{vd}");
        }
    }
}
