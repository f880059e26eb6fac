//! The measurement of the load torque.
//!
//! ```text
//! T_m(t) = (1 + g) T(t − d) + o + n(t),   n white      (1)
//! ```
//!
//! T is linear between samples and constant before the first one.

use crate::{NoiseSource, RigError, not_negative};

/// How the load torque is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoadMeasurement {
    /// The true load is recorded.
    Exact,
    /// The load is recorded by a sensor with errors.
    Sensor(LoadSensor),
    /// There is no load sensor: the load is not recorded.
    Absent,
}

/// Ranges of the sensor's errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadSensor {
    /// Largest |g| of (1).
    pub gain: f64,
    /// Largest |o| of (1).
    pub offset_nm: f64,
    /// Standard deviation of n of (1).
    pub noise_nm: f64,
    /// d of (1).
    pub delay_s: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadSensorValues {
    /// 1 + g of (1).
    pub gain: f64,
    /// o of (1).
    pub offset_nm: f64,
    /// Standard deviation of n of (1).
    pub noise_nm: f64,
    /// d of (1).
    pub delay_s: f64,
}

impl LoadSensor {
    /// The ranges of the field.
    pub const FIELD: Self = Self { gain: 0.05, offset_nm: 0.01, noise_nm: 0.01, delay_s: 0.005 };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        not_negative("field.load_sensor.gain", self.gain)?;
        not_negative("field.load_sensor.offset_nm", self.offset_nm)?;
        not_negative("field.load_sensor.noise_nm", self.noise_nm)?;
        not_negative("field.load_sensor.delay_s", self.delay_s)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> LoadSensorValues {
        LoadSensorValues {
            gain: 1.0 + source.uniform(-self.gain, self.gain),
            offset_nm: source.uniform(-self.offset_nm, self.offset_nm),
            noise_nm: self.noise_nm,
            delay_s: self.delay_s,
        }
    }
}

impl LoadSensorValues {
    /// A sensor without errors.
    pub const EXACT: Self = Self { gain: 1.0, offset_nm: 0.0, noise_nm: 0.0, delay_s: 0.0 };

    /// The measured loads (1) of the true loads at these times.
    #[must_use]
    pub fn measure(&self, t_s: &[f64], load_nm: &[f64], mut noise: NoiseSource) -> Vec<f64> {
        let mut segment = 0;
        t_s.iter()
            .map(|t| {
                let then = t - self.delay_s;
                while segment + 1 < t_s.len() && t_s[segment + 1] <= then {
                    segment += 1;
                }
                let load = interpolate(t_s, load_nm, segment, then);
                self.gain * load + self.offset_nm + self.noise_nm * noise.gaussian() // (1)
            })
            .collect()
    }
}

/// The value at `t` on the straight line from sample `k` to the next; constant beyond the ends.
fn interpolate(t_s: &[f64], values: &[f64], k: usize, t: f64) -> f64 {
    let Some((next_s, next)) = t_s.get(k + 1).zip(values.get(k + 1)) else { return values[k] };
    let part = ((t - t_s[k]) / (next_s - t_s[k])).max(0.0);
    values[k] + part * (next - values[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stream;
    use crate::field::tests::moments;

    fn noise() -> NoiseSource {
        NoiseSource::new(9, Stream::LoadSensorNoise)
    }

    #[test]
    fn a_ramp_is_scaled_shifted_and_late() {
        let sensor = LoadSensorValues { gain: 1.04, offset_nm: -0.007, noise_nm: 0.0, delay_s: 0.005 };
        // Irregular sampling: samples 1 ms early or late.
        let t_s: Vec<f64> = (0..100).map(|k| 0.002 * f64::from(k) + 1e-4 * f64::from(k % 3)).collect();
        let load: Vec<f64> = t_s.iter().map(|t| 0.1 + 2.0 * t).collect();
        for (t, measured) in t_s.iter().zip(sensor.measure(&t_s, &load, noise())) {
            // A ramp is exact on straight lines; before the first sample the load is constant.
            let expected = 1.04 * (0.1 + 2.0 * (t - 0.005).max(0.0)) - 0.007;
            assert!((measured - expected).abs() < 1e-15, "{t}");
        }
    }

    #[test]
    fn noise_has_its_standard_deviation_and_no_sensor_error_is_exact() {
        let t_s: Vec<f64> = (0..20_000).map(|k| 0.002 * f64::from(k)).collect();
        let load = vec![0.1; t_s.len()];
        let sensor = LoadSensorValues { noise_nm: 0.01, ..LoadSensorValues::EXACT };
        let (mean, sd) = moments(&sensor.measure(&t_s, &load, noise()));
        // Four standard deviations: of the mean 0.01/√20000, of the standard deviation 0.5 %.
        assert!((mean - 0.1).abs() < 3e-4 && (sd / 0.01 - 1.0).abs() < 0.02, "{mean} {sd}");
        let wave: Vec<f64> = t_s.iter().map(|t| t.sin()).collect();
        assert_eq!(LoadSensorValues::EXACT.measure(&t_s, &wave, noise()), wave);
    }

    #[test]
    fn errors_stay_in_their_ranges() {
        let draws: Vec<LoadSensorValues> =
            (0..1000).map(|seed| LoadSensor::FIELD.draw(NoiseSource::new(seed, Stream::LoadSensor))).collect();
        assert!(draws.iter().all(|s| (0.95..1.05).contains(&s.gain) && s.offset_nm.abs() < 0.01));
        // The extremes of 1000 draws lie within 1 % of the width of the range, with a probability of 1 − 1e-4.
        assert!(draws.iter().any(|s| s.gain < 0.951) && draws.iter().any(|s| s.gain > 1.049));
        assert!(draws.iter().any(|s| s.offset_nm < -0.0098) && draws.iter().any(|s| s.offset_nm > 0.0098));
    }
}
