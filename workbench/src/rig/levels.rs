//! How strong the rig's signals are, and noise of a wanted signal-to-noise ratio.
//!
//! A ratio of D decibels means white noise of standard deviation
//!
//! ```text
//! σ_i = I · 10^(−D/20),   σ_ω = Ω · 10^(−D/20)      (1)
//! ```
//!
//! with I and Ω the root mean square of current and velocity of the *healthy* rig without measurement noise. The
//! noise is a property of the sensors: it stays the same when a defect or other excitation changes the signals.
//!
//! The ratio is that of the noise added. Velocity noise enters the loop, and the controller turns it into a real
//! current: what a trace shows beyond the noise-free signals is more than σ_i.
//!
//! The standard rig's own noise is 24.6 dB (current) and 33.9 dB (velocity).

use super::{Defect, RigError, Scenario, simulate};

/// Root mean square of the healthy signals without measurement noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalLevels {
    /// I of (1).
    pub current_a: f64,
    /// Ω of (1).
    pub velocity_rad_s: f64,
}

impl SignalLevels {
    /// Of [`Scenario::STANDARD`], the mean over seeds.
    pub const STANDARD: Self = Self { current_a: 2.20, velocity_rad_s: 27.14 };

    /// Measures them on one simulated trace: the scenario without its defect and its measurement noise.
    ///
    /// # Errors
    /// Where the rig refuses the scenario.
    pub fn measure(scenario: &Scenario, seed: u64) -> Result<Self, RigError> {
        let quiet = Scenario { current_noise_a: 0.0, velocity_noise_rad_s: 0.0, defect: Defect::HEALTHY, ..*scenario };
        let trace = simulate(&quiet, seed)?;
        let rms = |x: &[f64]| (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt();
        Ok(Self { current_a: rms(&trace.current_a), velocity_rad_s: rms(&trace.velocity_rad_s) })
    }
}

impl Scenario {
    /// This scenario with current and velocity noise `decibels` below these signals (1).
    #[must_use]
    pub fn with_signal_to_noise(self, levels: SignalLevels, decibels: f64) -> Self {
        let ratio = libm::pow(10.0, -decibels / 20.0);
        Self {
            current_noise_a: levels.current_a * ratio, // (1)
            velocity_noise_rad_s: levels.velocity_rad_s * ratio,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_and_scatter(x: &[f64]) -> (f64, f64) {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        (mean, (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt())
    }

    #[test]
    fn standard_levels_are_those_of_the_standard_rig() {
        let defect = Defect::full(crate::rig::DefectKind::Spall);
        let spalled = Scenario::STANDARD.with_defect(defect);
        let levels: Vec<SignalLevels> =
            (0..40).map(|seed| SignalLevels::measure(&spalled, 900 + seed).expect("valid")).collect();
        let current = mean_and_scatter(&levels.iter().map(|l| l.current_a).collect::<Vec<_>>());
        let velocity = mean_and_scatter(&levels.iter().map(|l| l.velocity_rad_s).collect::<Vec<_>>());
        println!("current {current:?} A, velocity {velocity:?} rad/s");
        for ((mean, scatter), standard) in
            [(current, SignalLevels::STANDARD.current_a), (velocity, SignalLevels::STANDARD.velocity_rad_s)]
        {
            // Four deviations of the mean, and half a unit of the last digit of the constant.
            let allowed = 4.0 * scatter + 0.005;
            assert!((mean - standard).abs() < allowed && allowed < 0.01 * standard, "{mean} ± {scatter}");
        }
    }

    #[test]
    fn noise_measured_on_traces_has_the_ratio_asked_for() {
        // With the controller off, velocity noise stays where it is added: noisy − quiet is the noise.
        let open = Scenario { proportional_gain_v_s_per_rad: 0.0, integral_gain_v_per_rad: 0.0, ..Scenario::STANDARD };
        let levels = SignalLevels::measure(&Scenario::STANDARD, 77).expect("valid");
        let quiet = Scenario { current_noise_a: 0.0, velocity_noise_rad_s: 0.0, ..open };
        for decibels in [10.0, 20.0, 30.0] {
            let noisy = open.with_signal_to_noise(levels, decibels);
            let mut squares = [0.0; 2];
            for seed in 0..20 {
                let [with, without] = [noisy, quiet].map(|scenario| simulate(&scenario, seed).expect("valid"));
                let power = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 1e5;
                squares[0] += power(&with.current_a, &without.current_a);
                squares[1] += power(&with.velocity_rad_s, &without.velocity_rad_s);
            }
            for (square, level) in squares.iter().zip([levels.current_a, levels.velocity_rad_s]) {
                let measured = 20.0 * (level / square.sqrt()).log10();
                // Four deviations of the rms of 1e5 samples, 4/√2e5 = 0.9 % or 0.078 dB.
                assert!((measured - decibels).abs() < 0.078, "{measured} for {decibels} dB");
            }
        }
    }
}
