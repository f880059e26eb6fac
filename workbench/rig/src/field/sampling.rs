//! Missing samples, and jitter of the sampling instants.
//!
//! A missing sample is NaN in all columns but the time: the drive has measured and controlled, and the record has lost
//! the row. With jitter, measurement and control happen at `t(k) = (k + u(k)) Ts`, u uniform; the record contains
//! t(k). The first sample is at 0.

use super::draws::choice;
use crate::{NoiseSource, RigError, fraction, within};

/// Which samples are missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Missing {
    /// Each sample is missing with this probability.
    Random {
        /// The probability.
        rate: f64,
    },
    /// One sample in `every` is missing, at equal distances.
    Periodic {
        /// The distance in samples.
        every: u32,
    },
    /// Runs of samples are missing.
    Bursts {
        /// Long-term fraction of missing samples.
        rate: f64,
        /// Length of a run.
        samples: u32,
    },
}

impl Missing {
    pub(super) fn validate(&self) -> Result<(), RigError> {
        match *self {
            Self::Random { rate } => fraction("field.missing.rate", rate)?,
            Self::Periodic { every } => within("field.missing.every", f64::from(every), [1.0, 1e9])?,
            Self::Bursts { rate, samples } => {
                within("field.missing.samples", f64::from(samples), [1.0, 1e9])?;
                within("field.missing.rate", rate, [0.0, 0.9])?
            }
        };
        Ok(())
    }

    /// The missing samples of a record of `count` samples.
    #[must_use]
    pub fn draw(&self, mut source: NoiseSource, count: usize) -> Vec<usize> {
        match *self {
            Self::Random { rate } => (0..count).filter(|_| source.uniform(0.0, 1.0) < rate).collect(),
            Self::Periodic { every } => (choice(&mut source, every) as usize..count).step_by(every as usize).collect(),
            Self::Bursts { rate, samples } => {
                // Runs of L samples and gaps of 1/p on average: the fraction is L/(L + 1/p).
                let start = rate / (f64::from(samples) * (1.0 - rate));
                let mut left = 0;
                let mut lost = |_: &usize| {
                    if left == 0 && source.uniform(0.0, 1.0) < start {
                        left = samples + 1;
                    }
                    left = left.saturating_sub(1);
                    left > 0
                };
                (0..count).filter(&mut lost).collect()
            }
        }
    }
}

/// Range of the jitter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleJitter {
    /// Largest |u|, relative to the sampling interval.
    pub fraction: f64,
}

impl SampleJitter {
    /// The range of the field.
    pub const FIELD: Self = Self { fraction: 0.1 };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        // Beyond 0.45 two instants could nearly coincide.
        within("field.jitter.fraction", self.fraction, [0.0, 0.45])?;
        Ok(())
    }
}

/// The sampling instants of one record.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    sample_time_s: f64,
    jitter: Option<(f64, NoiseSource)>,
    now_s: f64,
}

impl Clock {
    pub(crate) fn new(sample_time_s: f64, jitter: Option<SampleJitter>, source: NoiseSource) -> Self {
        Self { sample_time_s, jitter: jitter.map(|jitter| (jitter.fraction, source)), now_s: 0.0 }
    }

    /// The instant of sample `k`, and the interval since the last one.
    pub(crate) fn advance(&mut self, k: usize) -> [f64; 2] {
        let Some((fraction, source)) = &mut self.jitter else {
            return [k as f64 * self.sample_time_s, self.sample_time_s];
        };
        let next_s = (k as f64 + source.uniform(-*fraction, *fraction)) * self.sample_time_s;
        let interval_s = next_s - self.now_s;
        self.now_s = next_s;
        [next_s, interval_s]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::{QUIET, run};
    use crate::{Duty, Field, Scenario, Stream};

    const COUNT: usize = 500_000;

    fn lost(missing: Missing, seed: u64) -> Vec<usize> {
        missing.draw(NoiseSource::new(seed, Stream::Missing), COUNT)
    }

    #[test]
    fn one_in_a_hundred_is_missing() {
        let random = lost(Missing::Random { rate: 0.01 }, 1).len();
        // Four standard deviations of a binomial count: 4√(5e5 · 0.01 · 0.99) = 281.
        assert!(random.abs_diff(5000) < 282, "{random}");
        let periodic = lost(Missing::Periodic { every: 100 }, 1);
        assert_eq!(periodic.len(), 5000);
        assert!(periodic.windows(2).all(|pair| pair[1] - pair[0] == 100));
        assert_ne!(periodic[0], lost(Missing::Periodic { every: 100 }, 2)[0]);
        let bursts = lost(Missing::Bursts { rate: 0.01, samples: 20 }, 1).len();
        // 250 runs: four standard deviations are 4/√250 of 5000.
        assert!(bursts.abs_diff(5000) < 1265, "{bursts}");
    }

    #[test]
    fn bursts_are_runs_of_twenty() {
        let lost = lost(Missing::Bursts { rate: 0.01, samples: 20 }, 3);
        let mut length = 1;
        for pair in lost.windows(2) {
            if pair[1] == pair[0] + 1 {
                length += 1;
            } else {
                // Two runs may follow each other without a gap.
                assert_eq!(length % 20, 0);
                length = 1;
            }
        }
    }

    #[test]
    fn a_missing_sample_is_missing_in_all_columns_and_changes_no_other() {
        let scenario = Scenario { duty: Duty::Waveform, ..QUIET };
        let missing = Missing::Random { rate: 0.01 };
        let field = Field { missing: Some(missing), ..Field::NONE };
        let (whole, gaps) = (run(&scenario, 5), run(&Scenario { field, ..scenario }, 5));
        let lost = missing.draw(NoiseSource::new(5, Stream::Missing), 5000);
        assert!(!lost.is_empty());
        for ((name, gap), (_, column)) in gaps.recorded().into_iter().zip(whole.recorded()) {
            for k in 0..5000 {
                let gone = name != "t_s" && lost.contains(&k);
                assert!(if gone { gap[k].is_nan() } else { gap[k] == column[k] }, "{name} {k}");
            }
        }
    }

    #[test]
    fn recorded_instants_jitter_about_the_grid() {
        let field = Field { jitter: Some(SampleJitter::FIELD), ..Field::NONE };
        let trace = run(&Scenario { field, duty: Duty::Waveform, ..QUIET }, 6);
        let off: Vec<f64> = trace.t_s.iter().zip(0..).map(|(t, k)| t / 0.002 - f64::from(k)).collect();
        assert_eq!(off[0], 0.0);
        // Rounding of a number near 5000.
        assert!(off.iter().all(|u| u.abs() < 0.1 + 1e-12));
        let square = off.iter().map(|u| u * u).sum::<f64>() / 5000.0;
        // The variance of a uniform number is 0.1²/3; four standard deviations of its estimate are 4·0.9/√5000.
        assert!((square / (0.01 / 3.0) - 1.0).abs() < 0.051, "{square}");
        for (t, reference) in trace.t_s.iter().zip(&trace.velocity_ref_rad_s) {
            // Rounding only: the reference belongs to the recorded instant.
            assert!((reference - 40.0 * (core::f64::consts::TAU * 0.2 * t).sin()).abs() < 1e-12);
        }
        for k in 1..5000 {
            // The angle is the integral of the velocity over the recorded intervals: trapezium rule, 10 rad/s² at most
            // within an interval after the start, so 1e-5 rad.
            let mean = 0.5 * (trace.velocity_rad_s[k] + trace.velocity_rad_s[k - 1]);
            let turned = trace.angle_rad[k] - trace.angle_rad[k - 1];
            assert!((turned - mean * (trace.t_s[k] - trace.t_s[k - 1])).abs() < 1e-5, "{k}");
        }
    }
}
