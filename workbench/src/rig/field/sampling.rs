//! Missing samples, and jitter of the sampling instants.
//!
//! A missing sample is NaN in all columns but the time: the drive has measured and controlled, and the record has lost
//! the row. With jitter, measurement and control happen at `t(k) = (k + u(k)) Ts`, u uniform; the record contains
//! t(k). The first sample is at 0.

use crate::rig::{NoiseSource, RigError};

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
            Self::Random { rate } => super::fraction("field.missing.rate", rate)?,
            Self::Periodic { every } => super::within("field.missing.every", f64::from(every), [1.0, 1e9])?,
            Self::Bursts { rate, samples } => {
                super::within("field.missing.samples", f64::from(samples), [1.0, 1e9])?;
                super::within("field.missing.rate", rate, [0.0, 0.9])?
            }
        };
        Ok(())
    }

    /// The missing samples of a record of `count` samples.
    #[must_use]
    pub fn draw(&self, mut source: NoiseSource, count: usize) -> Vec<usize> {
        match *self {
            Self::Random { rate } => (0..count).filter(|_| source.uniform(0.0, 1.0) < rate).collect(),
            Self::Periodic { every } => {
                (super::choice(&mut source, every) as usize..count).step_by(every as usize).collect()
            }
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
        super::within("field.jitter.fraction", self.fraction, [0.0, 0.45])?;
        Ok(())
    }
}

/// The sampling instants of one record.
#[derive(Debug, Clone)]
pub(in crate::rig) struct Clock {
    sample_time_s: f64,
    jitter: Option<(f64, NoiseSource)>,
    now_s: f64,
}

impl Clock {
    pub(in crate::rig) fn new(sample_time_s: f64, jitter: Option<SampleJitter>, source: NoiseSource) -> Self {
        Self { sample_time_s, jitter: jitter.map(|jitter| (jitter.fraction, source)), now_s: 0.0 }
    }

    /// The instant of sample `k`, and the interval since the last one.
    pub(in crate::rig) fn advance(&mut self, k: usize) -> [f64; 2] {
        let Some((fraction, source)) = &mut self.jitter else {
            return [k as f64 * self.sample_time_s, self.sample_time_s];
        };
        let next_s = (k as f64 + source.uniform(-*fraction, *fraction)) * self.sample_time_s;
        let interval_s = next_s - self.now_s;
        self.now_s = next_s;
        [next_s, interval_s]
    }
}
