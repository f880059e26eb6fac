//! The sensors of the drive.
//!
//! ```text
//! counts = ⌊2ᵇ (θ/2π) + n⌋ mod 2ᵇ                 resolver of b bits            (1)
//! i_k,m  = (1 + g_k) i_k + o_k + n_k,  k = a, b, c   phase currents               (2)
//! x_m = x + n_x,   ω_m = ω + n_ω                  position, velocity            (3)
//! ```
//!
//! Every n is white at the control rate. A record draws the gain errors g and the offsets o of its three current
//! sensors. The q current is the Park transform of (2) at the electrical angle of (1), as a drive computes it.

use core::f64::consts::TAU;

use super::super::within;
use super::super::{NoiseSource, RigError, Stream, not_negative};
use super::{Actuator, EmaState};

/// √3/2
const HALF_SQRT_3: f64 = 0.866_025_403_784_438_6;

/// Errors of the sensors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorErrors {
    /// Bits of a turn of the resolver.
    pub resolver_bits: u32,
    /// Standard deviation of the resolver's noise in counts.
    pub resolver_noise_counts: f64,
    /// Standard deviation of the noise of each phase current.
    pub current_noise_a: f64,
    /// Largest offset of a phase current; each sensor draws its own.
    pub current_offset_a: f64,
    /// Largest gain error of a phase current; each sensor draws its own.
    pub current_gain: f64,
    /// Standard deviation of the position noise.
    pub position_noise_m: f64,
    /// Standard deviation of the velocity noise.
    pub velocity_noise_rad_s: f64,
}

impl SensorErrors {
    /// The sensors of the standard rig. Noise of the resolver, offset and gain error are those of usual parts: half a
    /// count, 0.25 % of the current limit, and 0.5 %.
    pub const STANDARD: Self = Self {
        resolver_bits: 14,
        resolver_noise_counts: 0.5,
        current_noise_a: 0.25,
        current_offset_a: 0.1,
        current_gain: 0.005,
        position_noise_m: 5e-6,
        velocity_noise_rad_s: 0.4,
    };

    /// Sensors without noise, offset and gain error; the angle has 14 bits.
    pub const QUIET: Self = Self {
        resolver_bits: 14,
        resolver_noise_counts: 0.0,
        current_noise_a: 0.0,
        current_offset_a: 0.0,
        current_gain: 0.0,
        position_noise_m: 0.0,
        velocity_noise_rad_s: 0.0,
    };

    /// Returns an error with the name of a value that cannot be simulated.
    pub fn validate(&self) -> Result<(), RigError> {
        within("sensors.resolver_bits", f64::from(self.resolver_bits), [1.0, 30.0])?;
        not_negative("sensors.resolver_noise_counts", self.resolver_noise_counts)?;
        not_negative("sensors.current_noise_a", self.current_noise_a)?;
        not_negative("sensors.current_offset_a", self.current_offset_a)?;
        within("sensors.current_gain", self.current_gain, [0.0, 0.5])?;
        not_negative("sensors.position_noise_m", self.position_noise_m)?;
        not_negative("sensors.velocity_noise_rad_s", self.velocity_noise_rad_s)?;
        Ok(())
    }
}

/// Measured signals of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measured {
    pub(super) position_m: f64,
    pub(super) velocity_rad_s: f64,
    pub(super) phases_a: [f64; 3],
    pub(super) direct_a: f64,
    pub(super) quadrature_a: f64,
    pub(super) resolver_counts: u32,
    /// Shaft angle from the counts, unwrapped since the start of the record.
    pub(super) angle_rad: f64,
    /// Measured minus true electrical angle, as cosine and sine.
    pub(super) misalignment: [f64; 2],
}

/// The sensors with their noise.
#[derive(Debug)]
pub(super) struct EmaSensors {
    errors: SensorErrors,
    pole_pairs: f64,
    offsets_a: [f64; 3],
    gains: [f64; 3],
    resolver: NoiseSource,
    current: NoiseSource,
    position: NoiseSource,
    velocity: NoiseSource,
    /// Counts since the start of the record, not wrapped; `None` before the first sample.
    unwrapped: Option<i64>,
}

impl EmaSensors {
    pub(super) fn new(errors: &SensorErrors, actuator: &Actuator, seed: u64) -> Self {
        let mut source = NoiseSource::new(seed, Stream::CurrentChain);
        let mut three = |limit: f64| [0; 3].map(|_| source.uniform(-limit, limit));
        Self {
            errors: *errors,
            pole_pairs: f64::from(actuator.pole_pairs),
            offsets_a: three(errors.current_offset_a),
            gains: three(errors.current_gain).map(|gain| 1.0 + gain),
            resolver: NoiseSource::new(seed, Stream::ResolverNoise),
            current: NoiseSource::new(seed, Stream::CurrentNoise),
            position: NoiseSource::new(seed, Stream::PositionNoise),
            velocity: NoiseSource::new(seed, Stream::VelocityNoise),
            unwrapped: None,
        }
    }

    pub(super) fn measure(&mut self, state: &EmaState) -> Measured {
        let counts = self.resolver_counts(state.angle_rad);
        let step_rad = TAU / self.counts_per_turn();
        let (sin, cos) = libm::sincos(self.pole_pairs * step_rad * f64::from(counts));
        let (true_sin, true_cos) = libm::sincos(self.pole_pairs * state.angle_rad);
        let phases_a = self.phases(state, [true_cos, true_sin]);
        let [a, b, c] = phases_a;
        // Clarke transform, amplitude-invariant and without the zero sequence; then Park.
        let (alpha, beta) = ((2.0 * a - b - c) / 3.0, (b - c) / (2.0 * HALF_SQRT_3));
        Measured {
            position_m: state.position_m + self.errors.position_noise_m * self.position.gaussian(), // (3)
            velocity_rad_s: state.velocity_rad_s + self.errors.velocity_noise_rad_s * self.velocity.gaussian(),
            phases_a,
            direct_a: alpha * cos + beta * sin,
            quadrature_a: beta * cos - alpha * sin,
            resolver_counts: counts,
            angle_rad: step_rad * self.unwrap(counts),
            misalignment: [cos * true_cos + sin * true_sin, sin * true_cos - cos * true_sin],
        }
    }

    fn counts_per_turn(&self) -> f64 {
        f64::from(1_u32 << self.errors.resolver_bits)
    }

    /// Equation (1).
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number from 0 to below 2³⁰, the remainder of a division"
    )]
    fn resolver_counts(&mut self, angle_rad: f64) -> u32 {
        let per_turn = self.counts_per_turn();
        let noise = self.errors.resolver_noise_counts * self.resolver.gaussian();
        let counts = (per_turn * (angle_rad / TAU) + noise).floor().rem_euclid(per_turn); // (1)
        counts as u32
    }

    /// Equation (2): inverse Park and Clarke transform of the true currents.
    fn phases(&mut self, state: &EmaState, [cos, sin]: [f64; 2]) -> [f64; 3] {
        let alpha = state.direct_a * cos - state.quadrature_a * sin;
        let beta = state.direct_a * sin + state.quadrature_a * cos;
        let mut phases = [alpha, HALF_SQRT_3 * beta - 0.5 * alpha, -HALF_SQRT_3 * beta - 0.5 * alpha];
        for ((phase, gain), offset) in phases.iter_mut().zip(self.gains).zip(self.offsets_a) {
            *phase = gain * *phase + offset + self.errors.current_noise_a * self.current.gaussian(); // (2)
        }
        phases
    }

    /// Counts since the start of the record: the shorter way from the last counts.
    #[expect(clippy::cast_precision_loss, reason = "counts of a record are far below 2⁵³")]
    fn unwrap(&mut self, counts: u32) -> f64 {
        let (turn, now) = (1_i64 << self.errors.resolver_bits, i64::from(counts));
        let last = self.unwrapped.unwrap_or(now);
        let half = turn / 2;
        let change = (now - last + half).rem_euclid(turn) - half;
        self.unwrapped = Some(last + change);
        (last + change) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: f64 = 16_384.0;

    fn sensors(errors: SensorErrors) -> EmaSensors {
        EmaSensors::new(&errors, &Actuator::MAXFORCE, 3)
    }

    fn at(angle_rad: f64) -> EmaState {
        EmaState { direct_a: -2.0, quadrature_a: 9.0, velocity_rad_s: 50.0, angle_rad, ..EmaState::default() }
    }

    #[test]
    fn counts_are_the_true_angle_rounded_down() {
        let mut resolver = sensors(SensorErrors::QUIET);
        for k in -3000..3000 {
            let angle = 0.0137 * f64::from(k);
            let seen = resolver.measure(&at(angle));
            let turns = angle / TAU;
            let expected = ((turns - turns.floor()) * TURN).floor();
            assert_eq!(f64::from(seen.resolver_counts), expected, "{angle}");
            // Unwrapped from the start, which lies −3000 · 0.0137 = −41.1 rad, in turn −7.
            let error = angle - (seen.angle_rad - 7.0 * TAU);
            // Rounded down to a step of 2π/2¹⁴; rounding of the angle.
            assert!((-1e-12..TAU / TURN + 1e-12).contains(&error), "{angle} {error}");
        }
    }

    #[test]
    fn noise_of_the_resolver_has_its_standard_deviation() {
        let mut resolver = sensors(SensorErrors { resolver_noise_counts: 3.0, ..SensorErrors::QUIET });
        let draws: Vec<f64> = (0..20_000).map(|_| f64::from(resolver.measure(&at(1.0)).resolver_counts)).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 20_000.0;
        // Noise and quantisation, 9 + 1/12; four standard deviations of a variance, √(2/n) = 1 %.
        assert!((variance / (9.0 + 1.0 / 12.0) - 1.0).abs() < 0.04, "{variance}");
        // Rounding down takes half a count; four standard deviations of a mean, 3/√n = 0.021.
        assert!((mean - (TURN / TAU - 0.5)).abs() < 0.085, "{mean}");
    }

    #[test]
    fn phases_are_cosines_of_the_electrical_angle() {
        let mut ideal = sensors(SensorErrors { resolver_bits: 30, ..SensorErrors::QUIET });
        for k in 0..200 {
            let angle = 0.31 * f64::from(k);
            let seen = ideal.measure(&at(angle));
            for (phase, shift) in seen.phases_a.iter().zip([0.0, -1.0, 1.0]) {
                let electrical = 6.0 * angle + shift * TAU / 3.0;
                let expected = -2.0 * electrical.cos() - 9.0 * electrical.sin();
                // Rounding of a sine of an argument of up to 400.
                assert!((phase - expected).abs() < 1e-11);
            }
            // An angle of 2⁻³⁰ turn: 6 · 6e-9 rad · 9 A.
            assert!((seen.direct_a + 2.0).abs() < 4e-7 && (seen.quadrature_a - 9.0).abs() < 4e-7);
        }
    }

    #[test]
    fn gain_and_offset_stay_fixed_in_a_record_and_differ_between_phases() {
        let errors = SensorErrors { current_offset_a: 0.1, current_gain: 0.02, ..SensorErrors::QUIET };
        let mut bent = sensors(errors);
        let zero = EmaState { direct_a: 0.0, quadrature_a: 0.0, ..at(0.4) };
        let offsets = bent.measure(&zero).phases_a;
        assert_eq!(bent.measure(&zero).phases_a, offsets);
        assert!(offsets.iter().all(|offset| offset.abs() <= 0.1 && *offset != 0.0));
        assert!(offsets[0] != offsets[1] && offsets[1] != offsets[2]);
        let (seen, ideal) = (bent.measure(&at(0.4)).phases_a, sensors(SensorErrors::QUIET).measure(&at(0.4)).phases_a);
        for k in 0..3 {
            let gain = (seen[k] - offsets[k]) / ideal[k] - 1.0;
            assert!(gain.abs() <= 0.02 && gain != 0.0, "{gain}");
        }
        let other = EmaSensors::new(&errors, &Actuator::MAXFORCE, 4).measure(&zero).phases_a;
        assert_ne!(other, offsets);
    }

    #[test]
    fn noise_of_each_sensor_has_its_standard_deviation() {
        let mut noisy = sensors(SensorErrors { current_offset_a: 0.0, current_gain: 0.0, ..SensorErrors::STANDARD });
        let ideal = sensors(SensorErrors::QUIET).measure(&at(1.0));
        let mut squares = [0.0; 5];
        for _ in 0..20_000 {
            let seen = noisy.measure(&at(1.0));
            let errors = [
                seen.phases_a[0] - ideal.phases_a[0],
                seen.phases_a[1] - ideal.phases_a[1],
                seen.phases_a[2] - ideal.phases_a[2],
                seen.position_m - ideal.position_m,
                seen.velocity_rad_s - ideal.velocity_rad_s,
            ];
            squares.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error * error / 20_000.0);
        }
        for (square, sd) in squares.iter().zip([0.25, 0.25, 0.25, 5e-6, 0.4]) {
            // Four standard deviations of an rms, 1/√(2n) = 0.5 %.
            assert!((square.sqrt() / sd - 1.0).abs() < 0.02, "{square} {sd}");
        }
    }
}
