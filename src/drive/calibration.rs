//! Offsets of the current sensors, measured at standstill with the inverter off.
//!
//! ```text
//! offset = (1/N) Σ x,   s² = (Σ (x − x₀)² − (Σ (x − x₀))²/N) / (N − 1)    (1)
//! ```
//!
//! x₀ is the first sample of a phase. The sums are integers, so no digit is lost. The standard deviation of the offset
//! is s/√N for white noise: 1000 samples of a noise of 3 counts give 0.1 counts.

use core::fmt;

use super::{Phase, PhaseCounts, PhaseSensor};

/// What a calibration must look like.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CalibrationLimits {
    /// Number of samples N, at least 2.
    pub samples: u16,
    /// Lowest and highest plausible offset, counts.
    pub offset_counts: [f32; 2],
    /// Lowest and highest plausible standard deviation, counts. Less noise than the lowest means a stuck converter; 0
    /// accepts a constant.
    pub deviation_counts: [f32; 2],
}

/// Why offsets are refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CalibrationError {
    /// There are not enough samples yet.
    TooFew {
        /// Samples taken.
        samples: u16,
    },
    /// The noise is too large: the motor turns, a current flows, or the sensor is broken.
    Noisy {
        /// The phase.
        phase: Phase,
        /// Standard deviation, counts.
        deviation_counts: f32,
    },
    /// The converter repeats itself.
    Stuck {
        /// The phase.
        phase: Phase,
    },
    /// The offset is not plausible: a current flows, or the sensor is broken.
    OutOfBand {
        /// The phase.
        phase: Phase,
        /// The offset, counts.
        offset_counts: f32,
    },
}

impl CalibrationError {
    /// The kind of error in words.
    #[must_use]
    pub const fn message(&self) -> &'static str {
        match self {
            Self::TooFew { .. } => "too few samples for offsets of the current sensors",
            Self::Noisy { .. } => "a current sensor is too noisy for an offset",
            Self::Stuck { .. } => "the converter of a current sensor is stuck",
            Self::OutOfBand { .. } => "the offset of a current sensor is out of its band",
        }
    }
}

impl fmt::Display for CalibrationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let phase = match self {
            Self::Noisy { phase, .. } | Self::Stuck { phase } | Self::OutOfBand { phase, .. } => match phase {
                Phase::A => " (phase a)",
                Phase::B => " (phase b)",
                Phase::C => " (phase c)",
            },
            Self::TooFew { .. } => "",
        };
        f.write_str(self.message())?;
        f.write_str(phase)
    }
}

impl core::error::Error for CalibrationError {}

/// Sums of one phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Sums {
    first: u16,
    count: u16,
    /// Σ (x − x₀): at most 2¹⁶ terms below 2¹⁶.
    sum: i64,
    /// Σ (x − x₀)²
    squares: u64,
}

impl Sums {
    #[inline]
    fn push(&mut self, counts: u16) {
        if self.count == 0 {
            self.first = counts;
        }
        let departure = i64::from(counts).wrapping_sub(i64::from(self.first));
        self.count = self.count.saturating_add(1);
        self.sum = self.sum.wrapping_add(departure);
        self.squares = self.squares.wrapping_add(departure.wrapping_mul(departure).cast_unsigned());
    }

    /// Offset and standard deviation (1).
    fn offset_and_deviation(&self) -> (f32, f32) {
        let n = f32::from(self.count.max(2));
        let mean = self.sum as f32 / n;
        let variance = (self.squares as f32 - self.sum as f32 * mean) / (n - 1.0);
        let deviation = if variance > 0.0 { libm::sqrtf(variance) } else { 0.0 };
        (f32::from(self.first) + mean, deviation)
    }
}

/// Measures the offsets of the current sensors.
///
/// ```
/// use bearing_watch::drive::{CalibrationLimits, OffsetCalibration, PhaseCounts, PhaseSensor};
/// let sensor = PhaseSensor { offset_counts: 2048.0, gain_a: 0.01, usable: [16, 4079] };
/// let limits =
///     CalibrationLimits { samples: 1000, offset_counts: [1948.0, 2148.0], deviation_counts: [0.1, 8.0] };
/// let mut calibration = OffsetCalibration::new(limits);
/// for k in 0..1000 {
///     calibration.push(&PhaseCounts::Two([2050 + k % 2, 2041 + k % 3])); // the ADC interrupt, inverter off
/// }
/// let [a, b, _] = calibration.finish([sensor; 3])?;
/// assert!((a.offset_counts - 2050.5).abs() < 1e-3 && (b.offset_counts - 2042.0).abs() < 1e-2);
/// # Ok::<(), bearing_watch::drive::CalibrationError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OffsetCalibration {
    limits: CalibrationLimits,
    sums: [Sums; 3],
}

impl OffsetCalibration {
    /// No samples yet.
    #[must_use]
    pub fn new(limits: CalibrationLimits) -> Self {
        Self { limits, sums: [Sums::default(); 3] }
    }

    /// Takes the counts of one instant; returns whether there are enough. Further ones are ignored.
    #[inline]
    pub fn push(&mut self, counts: &PhaseCounts) -> bool {
        let wanted = self.limits.samples.max(2);
        let [first, ..] = &self.sums;
        if first.count < wanted {
            self.sums.iter_mut().zip(counts.as_slice()).for_each(|(sums, counts)| sums.push(*counts));
        }
        let [first, ..] = &self.sums;
        first.count >= wanted
    }

    /// The sensors with measured offsets; a phase that was never sampled keeps its own.
    ///
    /// # Errors
    /// The first phase whose offset is refused, and why.
    pub fn finish(&self, mut sensors: [PhaseSensor; 3]) -> Result<[PhaseSensor; 3], CalibrationError> {
        let wanted = self.limits.samples.max(2);
        for ((index, sums), (sensor, phase)) in self.sums.iter().enumerate().zip(sensors.iter_mut().zip(Phase::ALL)) {
            if index == 2 && sums.count == 0 {
                continue; // two sensors
            }
            if sums.count < wanted {
                return Err(CalibrationError::TooFew { samples: sums.count });
            }
            let (offset_counts, deviation_counts) = sums.offset_and_deviation();
            let [least, most] = self.limits.deviation_counts;
            // Compared so that a limit that is no number admits nothing.
            let moves = deviation_counts >= least;
            if !moves {
                return Err(CalibrationError::Stuck { phase });
            }
            let is_quiet = deviation_counts <= most;
            if !is_quiet {
                return Err(CalibrationError::Noisy { phase, deviation_counts });
            }
            let [lowest, highest] = self.limits.offset_counts;
            if !(lowest..=highest).contains(&offset_counts) {
                return Err(CalibrationError::OutOfBand { phase, offset_counts });
            }
            sensor.offset_counts = offset_counts;
        }
        Ok(sensors)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::cast_sign_loss, reason = "counts are positive")]

    use super::*;

    const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 2048.0, gain_a: 0.01, usable: [16, 4079] };
    const LIMITS: CalibrationLimits =
        CalibrationLimits { samples: 4000, offset_counts: [2000.0, 2100.0], deviation_counts: [0.3, 8.0] };

    /// Twelve uniform numbers less six: nearly normal.
    fn noise(state: &mut u32) -> f64 {
        (0..12)
            .map(|_| {
                *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(*state >> 8) / 16_777_216.0
            })
            .sum::<f64>()
            - 6.0
    }

    fn calibrated(offset: f64, deviation: f64, samples: usize) -> Result<[PhaseSensor; 3], CalibrationError> {
        let mut calibration = OffsetCalibration::new(LIMITS);
        let mut state = 5;
        for k in 0..samples {
            let mut at = |offset: f64, deviation: f64| (offset + deviation * noise(&mut state)).round() as u16;
            let counts = PhaseCounts::Three([at(2040.0, 2.0), at(offset, deviation), at(2060.7, 2.0)]);
            assert_eq!(calibration.push(&counts), k + 1 >= 4000);
        }
        calibration.finish([SENSOR; 3])
    }

    #[test]
    fn offsets_are_within_four_standard_errors() {
        let [a, b, c] = calibrated(2051.3, 2.0, 5000).unwrap();
        // 2/√4000 = 0.032 counts.
        for (sensor, exact) in [(a, 2040.0), (b, 2051.3), (c, 2060.7)] {
            assert!((sensor.offset_counts - exact).abs() < 0.13, "{sensor:?} {exact}");
        }
    }

    #[test]
    fn refusals_name_the_phase() {
        assert_eq!(calibrated(2051.3, 2.0, 3999), Err(CalibrationError::TooFew { samples: 3999 }));
        assert_eq!(calibrated(2051.0, 0.0, 4000), Err(CalibrationError::Stuck { phase: Phase::B }));
        let noisy = calibrated(2051.3, 20.0, 4000).unwrap_err();
        assert!(
            matches!(noisy, CalibrationError::Noisy { phase: Phase::B, deviation_counts: s } if (18.5..21.5).contains(&s)),
            "{noisy:?}"
        );
        let far = calibrated(1990.0, 2.0, 4000).unwrap_err();
        assert!(matches!(far, CalibrationError::OutOfBand { phase: Phase::B, .. }), "{far:?}");
        assert_eq!(std::format!("{far}"), "the offset of a current sensor is out of its band (phase b)");
    }

    #[test]
    fn limits_that_are_no_numbers_admit_nothing() {
        let nan = f32::NAN;
        for limits in [
            CalibrationLimits { offset_counts: [nan, 2100.0], ..LIMITS },
            CalibrationLimits { offset_counts: [2000.0, nan], ..LIMITS },
            CalibrationLimits { deviation_counts: [nan, 8.0], ..LIMITS },
            CalibrationLimits { deviation_counts: [0.3, nan], ..LIMITS },
        ] {
            let mut calibration = OffsetCalibration::new(CalibrationLimits { samples: 100, ..limits });
            for k in 0..100 {
                calibration.push(&PhaseCounts::Two([2050 + k % 3, 2041 + k % 3]));
            }
            assert!(calibration.finish([SENSOR; 3]).is_err(), "{limits:?}");
        }
    }

    #[test]
    fn counts_behind_the_last_sample_are_ignored() {
        let mut calibration = OffsetCalibration::new(CalibrationLimits { samples: 100, ..LIMITS });
        (0..100).for_each(|k| _ = calibration.push(&PhaseCounts::Three([2050 + k % 3; 3])));
        let before = calibration.clone();
        (0..100).for_each(|_| assert!(calibration.push(&PhaseCounts::Three([4095, 0, 4095]))));
        assert_eq!(calibration, before);
    }

    #[test]
    fn two_sensors_leave_the_third_as_it_was() {
        let mut calibration = OffsetCalibration::new(CalibrationLimits { samples: 2, ..LIMITS });
        calibration.push(&PhaseCounts::Two([2040, 2060]));
        assert!(calibration.push(&PhaseCounts::Two([2042, 2062])));
        let [a, b, c] = calibration.finish([SENSOR; 3]).unwrap();
        assert_eq!([a.offset_counts, b.offset_counts, c.offset_counts], [2041.0, 2061.0, 2048.0]);
    }

    #[test]
    fn the_deviation_of_two_readings_is_their_difference_by_the_root_of_two() {
        let mut sums = Sums::default();
        [2040, 2044].into_iter().for_each(|counts| sums.push(counts));
        let (offset, deviation) = sums.offset_and_deviation();
        assert!((offset - 2042.0).abs() < 1e-3 && (deviation - 8.0_f32.sqrt()).abs() < 1e-5, "{offset} {deviation}");
    }

    #[test]
    fn a_constant_is_within_limits_of_zero() {
        let limits = CalibrationLimits { samples: 10, deviation_counts: [0.0, 0.0], ..LIMITS };
        let mut calibration = OffsetCalibration::new(limits);
        (0..10).for_each(|_| _ = calibration.push(&PhaseCounts::Two([2050, 2060])));
        let sensors = calibration.finish([SENSOR; 3]).unwrap();
        assert_eq!(sensors.map(|sensor| sensor.offset_counts), [2050.0, 2060.0, 2048.0]);
    }
}
