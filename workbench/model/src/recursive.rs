//! The streaming estimator of the firmware on signals that come in pieces, with fading memory.
//!
//! ```text
//! reference record ─► scales, nominal model, settling time ─► Recursive
//! samples y, u1, u2 ─► Detector of the core, forgetting factor λ ─► θ, cov θ, σ² after each `every` samples
//! ```
//!
//! The estimator is that of [`bearing_watch`], least squares or streaming instruments, in single precision. The
//! covariance of a, b, c is M·C·Mᵀ, C that of the δ-parameters.

use bearing_watch::model::Sampling;
use bearing_watch::plan::{RunTime, RunTimeSample};
use bearing_watch::{Detector, Model, ModelError};
use nalgebra::{DMatrix, DVector};

use crate::Error;
use crate::core::features::{of_core, raw_from_delta};
use crate::identify::{Structure, Terms as _};
use crate::settings::Method;
use crate::trace::labels::LabelledTrace;
use crate::trace::{Channels, Trace};
use crate::train::{Estimation, Recipe, estimating};

/// How it estimates.
#[derive(Clone, Copy, Debug)]
pub struct How {
    /// Least squares or instruments.
    pub method: Method,
    /// Forgetting factor of a row.
    pub forgetting: f64,
    /// Samples from one estimate to the next; by instruments each is the next auxiliary model.
    pub every: u32,
}

/// An estimator with its constants.
#[derive(Clone, Debug)]
pub struct Recursive {
    model: Model<RunTime>,
    structure: Structure,
    /// The signal of each channel: 0 for y, 1 for u1, 2 for u2.
    signals: Vec<usize>,
}

/// An estimate.
#[derive(Clone, Debug)]
pub struct Estimated {
    /// Number of samples so far.
    pub samples: usize,
    /// Why there is no estimate; the numbers are then NaN.
    pub reason: Option<String>,
    /// Parameters a, b, c, then the constant.
    pub theta: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Residual variance, in the unit of y squared.
    pub variance: f64,
    /// Equivalent number of rows.
    pub rows: u32,
}

impl Recursive {
    /// With the scales of a reference record, whose least-squares model is the nominal one.
    ///
    /// # Errors
    /// A record that does not excite the parameters, or settings out of range.
    pub fn new(reference: Trace, structure: Structure, how: How) -> Result<Self, Error> {
        if how.every < 2 {
            return Err(Error::Usage("every is at least 2 samples".into()));
        }
        let estimation =
            Estimation { method: how.method.core(), memory: Some(how.forgetting), ..Estimation::default() };
        let second = if structure.nc > 0 { "u2" } else { "u1" };
        let columns = Channels::new("y", "u1", second);
        let recipe = Recipe { columns, estimation, ..Recipe::new(structure) };
        let reference = LabelledTrace { trace: reference, class: 0 };
        let found = estimating(&[reference], &["reference".into()], &recipe)?;
        let sampling = Sampling { interval_s: 0.0, park: None, block_mean: 1, segment_samples: how.every };
        let refused = |error: ModelError| Error::Usage(format!("the core refuses this estimator: {error}"));
        let model = found.parts.estimating(sampling).map_err(refused)?;
        let place = |name: &str| ["y", "u1", "u2"].iter().position(|own| *own == name).unwrap_or(0);
        let signals = model.constants().channels.iter().map(|channel| place(channel.name.as_str())).collect();
        Ok(Self { model, structure, signals })
    }

    /// Names of the parameters.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.structure.names()
    }

    /// The estimator before the first sample.
    #[must_use]
    pub fn start(&self) -> Running<'_> {
        let sample = RunTimeSample { values: vec![0.0; self.signals.len()], ..RunTimeSample::default() };
        Running { own: self, detector: Detector::new(&self.model), sample, samples: 0 }
    }
}

/// A running estimator.
#[derive(Debug)]
pub struct Running<'m> {
    own: &'m Recursive,
    detector: Detector<'m, RunTime>,
    sample: RunTimeSample,
    samples: usize,
}

impl Running<'_> {
    /// Takes the next samples of y, u1 and u2; returns the estimates that are due.
    pub fn take(&mut self, signals: [&[f64]; 3]) -> Vec<Estimated> {
        let mut estimates = Vec::new();
        for k in 0..signals[0].len() {
            for (cell, &signal) in self.sample.values.iter_mut().zip(&self.own.signals) {
                *cell = signals[signal].get(k).map_or(f32::NAN, |value| *value as f32);
            }
            self.samples += 1;
            let due = self.detector.step(&self.sample);
            estimates.extend(due.and_then(|report| report.estimate().map(|found| self.estimated(found))));
        }
        estimates
    }

    fn estimated(&self, found: &bearing_watch::Estimate<RunTime>) -> Estimated {
        let n = self.own.structure.parameters();
        let map = raw_from_delta(self.own.structure);
        let map = map.view((0, 0), (n, n));
        let covariance = DMatrix::from_fn(n, n, |i, j| f64::from(found.covariance(i, j)));
        let layout = self.own.model.plan().layout();
        debug_assert_eq!(layout.parameters(), n, "one column for each parameter");
        let none = found.reason.is_some();
        let or_nan = |x: f64| if none { f64::NAN } else { x };
        let theta = of_core(self.own.structure, found.delta(), found.variance).rows(0, n).into_owned();
        Estimated {
            samples: self.samples,
            reason: found.reason.map(|reason| reason.to_string()),
            theta: theta.map(or_nan),
            covariance: (map * covariance * map.transpose()).map(or_nan),
            variance: or_nan(f64::from(found.variance)),
            rows: found.rows,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::least_squares;

    /// A first-order model whose gain changes in the middle.
    fn signals(count: usize) -> Trace {
        let mut state = 1_u32;
        let mut noise = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / 16_777_216.0 - 0.5
        };
        let (mut y, mut u1) = (vec![0.0], vec![noise()]);
        for k in 1..count {
            let gain = if k < count / 2 { 1.0 } else { 2.0 };
            y.push(0.8 * y[k - 1] + gain * u1[k - 1] + 0.02 * noise());
            u1.push(noise());
        }
        Trace { id: "one".into(), u2: u1.clone(), y, u1, ..Trace::default() }
    }

    fn half(trace: &Trace) -> Trace {
        let part = |x: &Vec<f64>| x[..x.len() / 2].to_vec();
        Trace { id: "half".into(), y: part(&trace.y), u1: part(&trace.u1), u2: part(&trace.u2), ..Trace::default() }
    }

    #[test]
    fn it_is_least_squares_and_follows_a_change() {
        let (trace, structure) = (signals(4000), Structure::new(1, 1, 0, 1, 1));
        let how = How { method: Method::Ls, forgetting: 0.99, every: 500 };
        let own = Recursive::new(half(&trace), structure, how).expect("constants");
        let mut running = own.start();
        let found = running.take([&trace.y, &trace.u1, &trace.u2]);
        assert_eq!((found.len(), found[0].samples, own.names()), (8, 500, vec!["a1".to_string(), "b1".into()]));
        let batch = least_squares(&half(&trace), structure).expect("an estimate");
        // A memory of 100 rows has about √(2000/200) times the deviation of all rows.
        let ratio = found[3].covariance[(1, 1)].sqrt() / batch.covariance[(1, 1)].sqrt();
        assert!((2.0..5.0).contains(&ratio), "{ratio}");
        for (estimate, gain) in [(&found[3], 1.0), (&found[7], 2.0)] {
            for (k, truth) in [-0.8, gain].into_iter().enumerate() {
                let deviation = estimate.covariance[(k, k)].sqrt();
                assert!((estimate.theta[k] - truth).abs() < 5.0 * deviation && deviation < 0.01, "{estimate:?}");
            }
        }
        // In pieces it is the same.
        let mut pieces = own.start();
        let mut all = pieces.take([&trace.y[..777], &trace.u1[..777], &trace.u2[..777]]);
        all.extend(pieces.take([&trace.y[777..], &trace.u1[777..], &trace.u2[777..]]));
        assert!(all.iter().zip(&found).all(|(one, other)| one.theta == other.theta) && all.len() == 8);
        let refused = Recursive::new(half(&trace), structure, How { every: 1, ..how });
        assert!(refused.is_err_and(|error| error.to_string().contains("every")));
    }
}
