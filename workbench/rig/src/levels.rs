//! Signal levels of the rig, and measurement noise for a given signal-to-noise ratio.
//!
//! A ratio of D decibels means white noise of standard deviation
//!
//! ```text
//! σ_i = I · 10^(−D/20),   σ_ω = Ω · 10^(−D/20)      (1)
//! ```
//!
//! where I and Ω are the root mean square of current and velocity of the *healthy* rig without measurement noise. The
//! noise is a property of the sensors: it does not change if a defect or other excitation changes the signals.
//!
//! D refers to the added noise only. The loop feeds the velocity noise back, and the controller converts it to a real
//! current: the difference between the recorded current and the noise-free current is therefore larger than σ_i.
//!
//! The standard noise of the rig is 24.6 dB (current) and 33.9 dB (velocity).

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
    /// Levels of [`Scenario::STANDARD`], mean over seeds.
    pub const STANDARD: Self = Self { current_a: 2.20, velocity_rad_s: 27.14 };

    /// Measures the levels on one simulated trace of the scenario without its defect and its measurement noise.
    ///
    /// # Errors
    /// Returns an error if the rig refuses the scenario.
    pub fn measure(scenario: &Scenario, seed: u64) -> Result<Self, RigError> {
        let quiet = Scenario { current_noise_a: 0.0, velocity_noise_rad_s: 0.0, defect: Defect::HEALTHY, ..*scenario };
        let trace = simulate(&quiet, seed)?;
        let rms = |x: &[f64]| (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt();
        Ok(Self { current_a: rms(&trace.current_a), velocity_rad_s: rms(&trace.velocity_rad_s) })
    }
}

impl Scenario {
    /// This scenario with current and velocity noise `decibels` below the levels (1).
    pub(crate) fn with_signal_to_noise(self, levels: SignalLevels, decibels: f64) -> Self {
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
        let defect = Defect::full(crate::DefectKind::Spall);
        let spalled = Scenario::STANDARD.with_defect(defect);
        let levels: Vec<SignalLevels> =
            (0..40).map(|seed| SignalLevels::measure(&spalled, 900 + seed).expect("valid")).collect();
        let current = mean_and_scatter(&levels.iter().map(|l| l.current_a).collect::<Vec<_>>());
        let velocity = mean_and_scatter(&levels.iter().map(|l| l.velocity_rad_s).collect::<Vec<_>>());
        println!("current {current:?} A, velocity {velocity:?} rad/s");
        for ((mean, scatter), standard) in
            [(current, SignalLevels::STANDARD.current_a), (velocity, SignalLevels::STANDARD.velocity_rad_s)]
        {
            // Four standard deviations of the mean, and half a unit of the last digit of the constant.
            let allowed = 4.0 * scatter + 0.005;
            assert!((mean - standard).abs() < allowed && allowed < 0.01 * standard, "{mean} ± {scatter}");
        }
    }

    #[test]
    fn noise_measured_on_traces_has_the_ratio_asked_for() {
        // Without the controller, velocity noise affects only the measured velocity: noisy − quiet is the noise.
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
                // Four standard deviations of the rms of 1e5 samples, 4/√2e5 = 0.9 % or 0.078 dB.
                assert!((measured - decibels).abs() < 0.078, "{measured} for {decibels} dB");
            }
        }
    }
}
