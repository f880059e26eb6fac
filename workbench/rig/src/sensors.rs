//! What the drive measures at a sample.
//!
//! Without effects of the field: the velocity with white noise, the filtered current with white noise, and the angle,
//! exact or rounded down to the resolution of a resolver. The loop controls the measured velocity.

use super::field::angle::{rounded, step_rad};
use super::field::{Constants, CurrentChainValues, DifferencedVelocity, FieldValues, ResolverValues};
use super::{NoiseSource, PlantState, Scenario, Stream};

/// Measured signals of one sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured {
    pub(super) velocity_rad_s: f64,
    pub(super) current_a: f64,
    pub(super) angle_rad: f64,
}

/// Sensors of velocity, current and angle.
#[derive(Debug)]
pub(super) struct Sensors {
    resolver: Option<(ResolverValues, DifferencedVelocity)>,
    /// The resolution of the angle without a resolver of the field.
    step_rad: Option<f64>,
    current_chain: Option<CurrentChainValues>,
    constants: Option<Constants>,
    velocity_noise_rad_s: f64,
    velocity_noise: NoiseSource,
    current_noise_a: f64,
    current_noise: NoiseSource,
}

impl Sensors {
    pub(super) fn new(scenario: &Scenario, values: &FieldValues, velocity_rad_s: f64, seed: u64) -> Self {
        let differenced = |resolver: ResolverValues| {
            let filter = DifferencedVelocity::new(resolver.cutoff_hz, scenario.sample_time_s, velocity_rad_s);
            (resolver, filter)
        };
        Self {
            resolver: values.resolver.map(differenced),
            step_rad: scenario.angle_bits.map(step_rad),
            current_chain: values.current_chain,
            constants: values.constants,
            velocity_noise_rad_s: scenario.velocity_noise_rad_s,
            velocity_noise: NoiseSource::new(seed, Stream::VelocityNoise),
            current_noise_a: scenario.current_noise_a,
            current_noise: NoiseSource::new(seed, Stream::CurrentNoise),
        }
    }

    /// The measured signals in this state, `interval_s` after the last sample; `filtered_a` is the filtered current.
    pub(super) fn measure(&mut self, state: &PlantState, filtered_a: f64, interval_s: f64) -> Measured {
        let (velocity_rad_s, angle_rad) = match &mut self.resolver {
            Some((resolver, filter)) => {
                let angle_rad = resolver.measured_rad(state.angle_rad);
                (filter.update(angle_rad, interval_s), angle_rad)
            }
            None => {
                let noise = self.velocity_noise_rad_s * self.velocity_noise.gaussian();
                let angle_rad = self.step_rad.map_or(state.angle_rad, |step| rounded(state.angle_rad, step));
                (state.velocity_rad_s + noise, angle_rad)
            }
        };
        Measured { velocity_rad_s, current_a: self.current(filtered_a, state.angle_rad), angle_rad }
    }

    fn current(&mut self, filtered_a: f64, angle_rad: f64) -> f64 {
        let noise = self.current_noise_a * self.current_noise.gaussian();
        let scaled = match &self.constants {
            Some(constants) => constants.current_gain * filtered_a + constants.current_offset_a,
            None => filtered_a,
        };
        match &self.current_chain {
            Some(chain) => chain.measured_a(scaled, noise, angle_rad),
            None => scaled + noise,
        }
    }
}
