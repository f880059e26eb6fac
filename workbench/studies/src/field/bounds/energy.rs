//! Energy of a full-size spall in one record, relative to the noise.
//!
//! ```text
//! S(f) = |J jω + B|²/(1/σ_ω² + 1/(ω² σ_θ²)) + Kt² σ_i²/|F|² + S_load(f)   variance a sample, N²m²         (1)
//! λ_h = Σ_k [½ a_h² + (ε Kt i/h)²]/S(f_h),   f_h = h O |ω|/2π below half the sampling rate                (2)
//! a_h = 2 Td (d₀/d) |c_h|,   c_h: Fourier coefficient of a raised cosine of width d                       (3)
//! ```
//!
//! (1) is the noise of the torque balance Kt i − J dω/dt − B ω of measured current and velocity, the latter from its
//! channel and from the angle, which is rounded to a resolver's steps; the voltage is no channel of the detector. The
//! filter F of the current is before its noise, and is undone. `S_load` is the fluctuation of a load that is not
//! measured; it is linear between samples. (2) counts the ripple of the torque constant at the sidebands of the order
//! as if its phase were that of the pulses.

use std::f64::consts::{PI, TAU};

use rig::bearing::{PULSE_DUTY, PULSE_NM, TORQUE_RIPPLE};
use rig::field::angle::step_rad;
use rig::field::{FieldValues, LoadMeasurement};
use rig::noise::CURRENT_FILTER_HZ;
use rig::{RigTrace, Scenario};

/// Harmonics that are tried.
pub const HARMONICS: usize = 6;
/// Td d₀/2 of the rig: the mean torque of full-size pulses.
pub const MEAN_NM: f64 = 0.5 * PULSE_NM * PULSE_DUTY;

/// A full-size spall in one record.
#[derive(Clone, Debug)]
pub struct Spall {
    /// λ of each harmonic (2).
    pub harmonics: [f64; HARMONICS],
    /// The part of the pulses alone, without that of the ripple, which varies with the current.
    pub pulses: [f64; HARMONICS],
    /// Non-centrality of the mean drag in the noise alone.
    pub drag: f64,
    /// Deviation of an amplitude of the first harmonic, N·m.
    pub floor_nm: f64,
    /// Number of slips that the record can tell apart.
    pub slips: f64,
    /// Velocity at each sample of the record, rad/s.
    pub path: Vec<f64>,
    /// Sampling interval.
    pub interval_s: f64,
}

impl Spall {
    /// In the motion of a healthy record; `floor_nm` replaces the noise (1) at the orders if it was measured.
    #[must_use]
    pub fn of(scenario: &Scenario, values: &FieldValues, trace: &RigTrace, floor_nm: Option<f64>) -> Self {
        let (noise, order) = (Noise::of(scenario, values), scenario.bearing.orders().outer);
        let kt = values.motor(&scenario.motor).kt_nm_per_a;
        let width = values.slip.map_or(PULSE_DUTY, |slip| slip.width);
        let interval_s = scenario.sample_time_s;
        let (mut harmonics, mut pulses, mut drag) = ([0.0; HARMONICS], [0.0; HARMONICS], 0.0);
        let (mut turns, mut floor) = (0.0, 0.0);
        let mut path = Vec::with_capacity(trace.len());
        let moving = trace.angle_rad.windows(2).zip(&trace.current_a).zip(&trace.load_torque_nm);
        let samples = trace.len() as f64;
        for ((angles, current), load) in
            moving.filter(|((w, i), _)| w[0].is_finite() && w[1].is_finite() && i.is_finite())
        {
            let velocity = (angles[1] - angles[0]) / interval_s;
            let sign = velocity.tanh();
            let grown = values.slip.map_or(1.0, |slip| {
                (slip.ranges.load_floor + load.abs() / slip.ranges.load_scale_nm).min(slip.ranges.load_ceiling)
            });
            path.push(velocity);
            turns += velocity.abs() * interval_s / TAU;
            drag += (grown * MEAN_NM * sign).powi(2) / noise.at(0.0);
            let first_hz = order * velocity.abs() / TAU;
            for ((h, energy), own) in (1_u8..).zip(&mut harmonics).zip(&mut pulses) {
                let (h, hz) = (f64::from(h), f64::from(h) * first_hz);
                if hz >= 0.5 / interval_s {
                    continue;
                }
                let pulse = grown * sign * amplitude(h, width);
                // Two sidebands each of the first two harmonics.
                let ripple = if h < 2.5 { TORQUE_RIPPLE * kt * current / h } else { 0.0 };
                let square = 0.5 * pulse * pulse;
                let variance = floor_nm.map_or_else(|| noise.at(hz), |floor| 0.5 * samples * floor * floor);
                *own += square / variance;
                *energy += (square + ripple * ripple) / variance;
            }
            if first_hz < 0.5 / interval_s {
                floor += sign * sign / noise.at(first_hz);
            }
        }
        // An amplitude a has the energy ½ a² Σ 1/S, twice its square over the square of its deviation.
        let own = if floor > 0.0 { 2.0 / floor.sqrt() } else { f64::INFINITY };
        let slips = values.slip.map_or(1.0, |slip| 1.0 + 2.0 * slip.ranges.slip[1] * order * turns);
        Self { harmonics, pulses, drag, floor_nm: floor_nm.unwrap_or(own), slips, path, interval_s }
    }

    /// Non-centrality of the first harmonics of a spall of this size.
    pub(super) fn energy(&self, severity: f64, harmonics: usize) -> f64 {
        severity * severity * self.harmonics.iter().take(harmonics).sum::<f64>()
    }
}

/// a_h of (3).
fn amplitude(h: f64, width: f64) -> f64 {
    let x = h * width;
    let gap = 1.0 - x * x;
    // The limit at x = 1 is a half.
    let shape = if gap.abs() < 1e-6 { 0.5 } else { (PI * x).sin() / (PI * x) / gap };
    PULSE_NM * PULSE_DUTY * shape.abs()
}

/// Constants of (1).
#[derive(Clone, Copy, Debug)]
struct Noise {
    inertia: f64,
    viscous: f64,
    /// σ_ω², σ_θ², Kt² σ_i².
    velocity: f64,
    angle: f64,
    current: f64,
    /// Variance and pole of the load's fluctuation, if it is not measured.
    load: Option<(f64, f64)>,
    interval_s: f64,
}

impl Noise {
    fn of(scenario: &Scenario, values: &FieldValues) -> Self {
        let motor = values.motor(&scenario.motor);
        let absent = scenario.field.load == LoadMeasurement::Absent;
        Self {
            inertia: motor.j_kg_m2,
            viscous: motor.b_nm_s_per_rad,
            velocity: scenario.velocity_noise_rad_s.powi(2),
            angle: scenario.angle_bits.map_or(0.0, |bits| step_rad(bits).powi(2) / 12.0),
            current: (motor.kt_nm_per_a * scenario.current_noise_a).powi(2),
            load: absent.then(|| (scenario.load_fluctuation_nm.powi(2), scenario.load_fluctuation_pole)),
            interval_s: scenario.sample_time_s,
        }
    }

    /// S of (1).
    fn at(&self, hz: f64) -> f64 {
        let omega = TAU * hz;
        let unfiltered = 1.0 + (hz / CURRENT_FILTER_HZ).powi(4);
        let shaft = (self.inertia * omega).powi(2) + self.viscous.powi(2);
        let load = self.load.map_or(0.0, |(variance, pole)| {
            let x = PI * hz * self.interval_s;
            let linear = if x > 0.0 { (x.sin() / x).powi(4) } else { 1.0 };
            variance * (1.0 - pole * pole) / (1.0 + pole * pole - 2.0 * pole * (2.0 * x).cos()) * linear
        });
        // Twelfths of a squared step are the variance of rounding. An exact sensor leaves no noise.
        let both = 1.0 / (1.0 / self.velocity + 1.0 / (omega * omega * self.angle));
        shaft * both + self.current * unfiltered + load
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_that_of_the_torque_balance() {
        let values = FieldValues::draw(&Scenario::STANDARD, 1);
        let with = |bits: u32| Noise::of(&Scenario { angle_bits: Some(bits), ..Scenario::STANDARD }, &values);
        // At 24 Hz, the outer race at 40 rad/s: 2.5e-4 · 151 · 0.55 = 20.7 mN·m of the velocity, 6.5 of the current.
        // Rounding by 6 bits, 28 mrad, is 4.3 rad/s there; by 14 bits 0.017 rad/s, or 0.6 mN·m.
        assert!((with(6).at(24.0).sqrt() / 0.0217 - 1.0).abs() < 0.02, "{}", with(6).at(24.0).sqrt());
        let noise = with(14);
        assert!((noise.at(24.0).sqrt() / 0.006_53 - 1.0).abs() < 0.01, "{}", noise.at(24.0).sqrt());
        // An eighth of the pulses over 5000 samples at this speed: about a hundred in all.
        let at = |h: f64| 0.5 * (amplitude(h, PULSE_DUTY) / 8.0).powi(2) * 5000.0 / noise.at(24.0 * h);
        let all = at(1.0) + at(2.0) + at(3.0);
        assert!((100.0..200.0).contains(&all), "{all}");
        let field = rig::field::Field { load: LoadMeasurement::Absent, ..rig::field::Field::NONE };
        let blind = Noise::of(&Scenario { field, ..Scenario::WITH_RESOLVER }, &values);
        // A slow fluctuation of pole 0.2 has (1 + 0.2)/(1 − 0.2) times its variance.
        assert!(((blind.at(0.0) - noise.at(0.0)).sqrt() / (0.06 * 1.5_f64.sqrt()) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn harmonics_of_the_pulse_are_those_of_its_sampled_shape() {
        for width in [0.15, 0.5, 1.0 / 3.0] {
            for h in [1.0, 2.0, 3.0] {
                let n = 20_000;
                let (mut x, mut y) = (0.0, 0.0);
                for k in 0..n {
                    let place = f64::from(k) / f64::from(n);
                    if place < width {
                        let pulse = PULSE_NM * PULSE_DUTY / width * 0.5 * (1.0 - (TAU * place / width).cos());
                        let (sin, cos) = (TAU * h * place).sin_cos();
                        (x, y) = (x + pulse * cos, y + pulse * sin);
                    }
                }
                let exact = 2.0 * x.hypot(y) / f64::from(n);
                assert!((amplitude(h, width) / exact - 1.0).abs() < 1e-3, "{h} {width}: {}", amplitude(h, width));
            }
        }
    }
}
