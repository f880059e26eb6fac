//! The load of the actuator.
//!
//! A positive force opposes positive motion. The hydraulic actuator of the Moog rig applies a sine or a constant force
//! with a fluctuation, an AR(1) process at 2 ms with linear interpolation, as in the DC-motor rig. The springs of the
//! RIT rig depend on the position and are part of the [`plant`](super::plant).

use core::f64::consts::TAU;

use super::super::{LoadFluctuation, NoiseSource, RigError, finite, not_negative};

/// Interval of the fluctuation.
const KNOT_S: f64 = 0.002;
/// AR(1) pole of the fluctuation at this interval.
const POLE: f64 = 0.2;

/// Load of an experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EmaLoad {
    /// Hydraulic actuator, force sine.
    Sine {
        /// Amplitude (peak).
        amplitude_n: f64,
        /// Frequency.
        frequency_hz: f64,
    },
    /// Hydraulic actuator, constant force.
    Constant {
        /// Force.
        force_n: f64,
    },
    /// Springs, F = k_e x.
    Springs {
        /// k_e of both springs together.
        stiffness_n_per_m: f64,
    },
}

impl EmaLoad {
    /// This load with all forces multiplied by a factor.
    #[must_use]
    pub const fn times(self, factor: f64) -> Self {
        match self {
            Self::Sine { amplitude_n, frequency_hz } => Self::Sine { amplitude_n: factor * amplitude_n, frequency_hz },
            Self::Constant { force_n } => Self::Constant { force_n: factor * force_n },
            Self::Springs { stiffness_n_per_m } => Self::Springs { stiffness_n_per_m: factor * stiffness_n_per_m },
        }
    }

    /// Stiffness of the springs, zero if there are none.
    pub(crate) const fn springs_n_per_m(&self) -> f64 {
        match self {
            Self::Sine { .. } | Self::Constant { .. } => 0.0,
            Self::Springs { stiffness_n_per_m } => *stiffness_n_per_m,
        }
    }

    /// The external force without fluctuation; zero for springs.
    pub(crate) fn external_n(&self, t_s: f64) -> f64 {
        match self {
            Self::Sine { amplitude_n, frequency_hz } => amplitude_n * libm::sin(TAU * frequency_hz * t_s),
            Self::Constant { force_n } => *force_n,
            Self::Springs { .. } => 0.0,
        }
    }

    /// Returns an error with the name of a value that cannot be simulated.
    pub fn validate(&self) -> Result<(), RigError> {
        match *self {
            Self::Sine { amplitude_n, frequency_hz } => {
                finite("load.amplitude_n", amplitude_n)?;
                not_negative("load.frequency_hz", frequency_hz)
            }
            Self::Constant { force_n } => finite("load.force_n", force_n),
            Self::Springs { stiffness_n_per_m } => not_negative("load.stiffness_n_per_m", stiffness_n_per_m),
        }?;
        Ok(())
    }
}

/// The external force of one record, with its fluctuation.
#[derive(Debug, Clone)]
pub(super) struct ExternalForce {
    load: EmaLoad,
    fluctuation: LoadFluctuation,
    /// Number of the knot before the time that was read last.
    knot: f64,
    /// Fluctuation at this knot and at the next one.
    values_n: [f64; 2],
}

impl ExternalForce {
    pub(super) fn new(load: EmaLoad, fluctuation_n: f64, source: NoiseSource) -> Self {
        let mut fluctuation = LoadFluctuation::new(source, fluctuation_n, POLE);
        let values_n = [fluctuation.draw(), fluctuation.draw()];
        Self { load, fluctuation, knot: 0.0, values_n }
    }

    /// The force at `t_s`, which must not decrease from call to call.
    pub(super) fn at(&mut self, t_s: f64) -> f64 {
        while t_s >= (self.knot + 1.0) * KNOT_S {
            self.knot += 1.0;
            self.values_n = [self.values_n[1], self.fluctuation.draw()];
        }
        let [from, to] = self.values_n;
        self.load.external_n(t_s) + from + (to - from) * (t_s / KNOT_S - self.knot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stream;

    #[test]
    fn fluctuation_is_linear_between_its_knots_and_has_its_rms() {
        let source = NoiseSource::new(4, Stream::LoadFluctuation);
        let mut force = ExternalForce::new(EmaLoad::Constant { force_n: 8e3 }, 60.0, source);
        let values: Vec<f64> = (0..80_000).map(|k| force.at(5e-4 * f64::from(k)) - 8e3).collect();
        for four in values.chunks_exact(4).zip(values[4..].chunks_exact(4)) {
            let (now, next) = (four.0, four.1);
            for (k, part) in [0.25, 0.5, 0.75].into_iter().enumerate() {
                // Rounding of 8 kN, and of times of up to 40 s in units of 2 ms.
                assert!((now[k + 1] - now[0] - part * (next[0] - now[0])).abs() < 1e-8);
            }
        }
        let knots: Vec<f64> = values.iter().step_by(4).copied().collect();
        let square = knots.iter().map(|x| x * x).sum::<f64>() / 20_000.0;
        // Four standard deviations of the rms; one is √((1 + p²)/(1 − p²)/2n) = 0.52 % at p = 0.2.
        assert!((square.sqrt() / 60.0 - 1.0).abs() < 0.021, "{square}");
        let product = knots.windows(2).map(|x| x[0] * x[1]).sum::<f64>() / 20_000.0;
        // Correlation of neighbours 0.2; four standard deviations of 1/√n.
        assert!((product / square - 0.2).abs() < 0.03, "{}", product / square);
    }

    #[test]
    fn a_factor_multiplies_every_force() {
        for load in [
            EmaLoad::Sine { amplitude_n: 4e3, frequency_hz: 0.8 },
            EmaLoad::Constant { force_n: 8e3 },
            EmaLoad::Springs { stiffness_n_per_m: 2.4e5 },
        ] {
            let half = load.times(0.5);
            assert_eq!(half.external_n(0.3), 0.5 * load.external_n(0.3));
            assert_eq!(half.springs_n_per_m(), 0.5 * load.springs_n_per_m());
        }
        // Peak of the sine at a quarter of 1.25 s.
        let peak = EmaLoad::Sine { amplitude_n: 4e3, frequency_hz: 0.8 }.external_n(0.3125);
        assert!((peak - 4e3).abs() < 1e-9);
    }
}
