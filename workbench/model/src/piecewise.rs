//! Piece-wise estimation: first-order models of the straight runs of one record (thesis §6.2.1).
//!
//! Input: a trace. Output: its straight runs, a model of each run, and the medians over the runs as features.
//!
//! ```text
//! f₀ = argmax |FFT(w (y − mean))|²                        fundamental of the output           (1)
//! s = LP(y) differentiated, LP with zero phase, cut-off at r f₀                               (2)
//! runs = intervals of at least min_samples with |s(t)| ≥ threshold · max|s| of their stroke   (3)
//! θ of [1 1 1 1 1] on the *unfiltered* signals of each run;  features = medians over the runs (4)
//! ```
//!
//! A stroke is the part of the low-passed copy LP(y) between two turning points. The threshold is relative to the
//! stroke: if a record mixes two frequencies, a threshold relative to the steepest slope of the whole record would
//! leave most strokes without a run. The low-passed copy only determines where to cut. A lower threshold yields longer
//! but less straight runs: for a pure sine a threshold of 0.8 keeps 41 % of each half period, 0.3 keeps 81 %.

use realfft::RealFftPlanner;

use crate::Error;
use crate::grey_box::filter::LowPass;
use crate::identify::{Structure, least_squares};
use crate::trace::Trace;

/// The structure of the model of a run.
pub const STRUCTURE: Structure = Structure::new(1, 1, 1, 1, 1);

/// Settings that determine the runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutting {
    /// Minimum slope within a straight run as a fraction of the steepest slope; above 0 and below 1.
    pub threshold: f64,
    /// Minimum number of samples of a run.
    pub min_samples: usize,
    /// Cut-off of the low-passed copy, in multiples of the fundamental (r of (2)).
    pub cutoff_ratio: f64,
}

impl Default for Cutting {
    /// The values of the source.
    fn default() -> Self {
        Self { threshold: 0.8, min_samples: 200, cutoff_ratio: 1.0 }
    }
}

/// Result for one trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Pieces {
    /// Fundamental of the output, cycles per sample.
    pub fundamental: f64,
    /// Straight runs.
    pub runs: Vec<std::ops::Range<usize>>,
    /// a₁, b₁, c₁ of each run.
    pub theta: Vec<[f64; 3]>,
    /// Medians over the runs.
    pub median: [f64; 3],
}

/// Cuts a trace and estimates its runs.
///
/// # Errors
/// An invalid threshold; no fundamental, or no run that is long enough.
pub fn estimate(trace: &Trace, cutting: &Cutting) -> Result<Pieces, Error> {
    if !(cutting.threshold > 0.0 && cutting.threshold < 1.0 && cutting.cutoff_ratio > 0.0) {
        return Err(Error::Usage("the slope threshold lies between 0 and 1, the cut-off ratio above 0".into()));
    }
    let fundamental = fundamental(&trace.y).ok_or_else(|| {
        let problem = "the output has no period within the record; record at least two periods";
        Error::trace(&trace.id, problem)
    })?;
    let runs = straight_runs(&trace.y, fundamental, cutting);
    let piece = |run: &std::ops::Range<usize>| {
        let cut = |x: &[f64]| x[run.clone()].to_vec();
        let signals = [&trace.y, &trace.u1, &trace.u2].map(|x| cut(x));
        // A run that does not determine the model (for example, constant input) is skipped.
        let estimate = least_squares(&trace.with_signals(signals), STRUCTURE).ok()?;
        Some((run.clone(), [estimate.theta[0], estimate.theta[1], estimate.theta[2]]))
    };
    let (runs, theta): (Vec<_>, Vec<_>) = runs.iter().filter_map(piece).unzip();
    if runs.is_empty() {
        let (threshold, shortest) = (cutting.threshold, cutting.min_samples);
        let problem = format!(
            "no straight run of {shortest} samples at a slope threshold of {threshold}; lower one of them, or record \
             slower motion"
        );
        return Err(Error::trace(&trace.id, problem));
    }
    let median = [0, 1, 2].map(|k| median(theta.iter().map(|theta: &[f64; 3]| theta[k]).collect()));
    Ok(Pieces { fundamental, runs, theta, median })
}

/// (1) with a Hann window; the peak is refined by a parabola through the logarithms of three bins. In cycles per
/// sample.
fn fundamental(y: &[f64]) -> Option<f64> {
    let n = y.len();
    if n < 8 {
        return None;
    }
    let mean = y.iter().sum::<f64>() / n as f64;
    let window = |k: usize| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / n as f64).cos();
    let mut input: Vec<f64> = y.iter().enumerate().map(|(k, y)| (y - mean) * window(k)).collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum = transform.make_output_vec();
    transform.process(&mut input, &mut spectrum).ok()?;
    let power: Vec<f64> = spectrum.iter().map(|bin| bin.norm_sqr()).collect();
    // At least two periods are required; the last bin has no right neighbour.
    let peak = (2..power.len() - 1).max_by(|&i, &j| power[i].total_cmp(&power[j]))?;
    let [before, at, after] = [power[peak - 1], power[peak], power[peak + 1]].map(|p| p.max(f64::MIN_POSITIVE).ln());
    let bend = before - 2.0 * at + after;
    let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    (power[peak] > 0.0).then(|| (peak as f64 + shift.clamp(-0.5, 0.5)) / n as f64)
}

/// (2) and (3).
fn straight_runs(y: &[f64], fundamental: f64, cutting: &Cutting) -> Vec<std::ops::Range<usize>> {
    let copy = LowPass::butterworth(2, (fundamental * cutting.cutoff_ratio).min(0.49)).zero_phase(y);
    let slope: Vec<f64> = copy.windows(3).map(|w| w[2] - w[0]).collect(); // slope at the middle sample
    let mut runs = Vec::new();
    let mut begin = 0;
    // Strokes end at changes of the sign of the slope.
    for stroke in slope.chunk_by(|a, b| (*a < 0.0) == (*b < 0.0)) {
        let least = cutting.threshold * stroke.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
        let mut at = begin + 1; // middle sample of the first difference
        for run in stroke.chunk_by(|a, b| (a.abs() >= least) == (b.abs() >= least)) {
            if run[0].abs() >= least && least > 0.0 && run.len() >= cutting.min_samples {
                runs.push(at..at + run.len());
            }
            at += run.len();
        }
        begin += stroke.len();
    }
    runs
}

fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    let half = x.len() / 2;
    if x.len() % 2 == 1 { x[half] } else { (x[half - 1] + x[half]) / 2.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine(frequency: f64, count: usize) -> Vec<f64> {
        (0..count).map(|k| (TAU * frequency * k as f64).sin()).collect()
    }

    #[test]
    fn fundamental_of_a_sine_between_bins() {
        for frequency in [0.001, 0.00137, 0.02] {
            let y: Vec<f64> = sine(frequency, 5000).iter().map(|y| 3.0 + 2.0 * y).collect();
            let found = fundamental(&y).expect("periods");
            // A parabola through logarithms has an error of at most 0.02 bins of 1/5000 at a Hann peak; leakage of −f
            // adds to it.
            assert!((found - frequency).abs() < 0.05 / 5000.0, "{found} for {frequency}");
        }
        assert!(fundamental(&[1.0; 100]).is_none(), "no power");
    }

    #[test]
    fn runs_of_a_sine_are_as_long_as_the_threshold_says() {
        let y = sine(0.001, 6000);
        for threshold in [0.8, 0.5, 0.3] {
            let cutting = Cutting { threshold, min_samples: 100, cutoff_ratio: 3.0 };
            let runs = straight_runs(&y, 0.001, &cutting);
            let wanted = f64::acos(threshold) / TAU * 2.0 / 0.001; // part of a half turn with slope above the threshold
            let inner = &runs[1..runs.len() - 1];
            assert_eq!(inner.len(), 11, "slopes between the ends"); // 12 half periods, the first and last cut in two
            for run in inner {
                // The ends of the record slightly distort the copy, and therefore its steepest slope.
                assert!((run.len() as f64 / wanted - 1.0).abs() < 0.05, "{run:?} for {wanted}");
            }
        }
    }

    #[test]
    fn every_run_gives_the_model_of_an_exact_record() {
        let u1 = sine(0.0013, 6000);
        let u2: Vec<f64> = (0..6000).map(|k| (0.37 * k as f64).sin()).collect();
        let mut y = vec![0.0];
        for t in 1..6000 {
            y.push(0.9 * y[t - 1] + 0.5 * u1[t - 1] - 0.2 * u2[t - 1]);
        }
        let trace =
            Trace { id: "x".into(), interval_s: None, irregular_steps: 0, y, u1, u2, motion: None, ..Trace::default() };
        let pieces = estimate(&trace, &Cutting { min_samples: 100, ..Cutting::default() }).expect("runs");
        assert!(pieces.runs.len() > 8);
        for theta in &pieces.theta {
            for (found, truth) in theta.iter().zip([-0.9, 0.5, -0.2]) {
                assert!((found - truth).abs() < 1e-9, "{theta:?}"); // exact equations, rounding times condition
            }
        }
        let message =
            estimate(&trace, &Cutting { min_samples: 900, ..Cutting::default() }).expect_err("longer than all");
        assert!(message.to_string().contains("no straight run of 900 samples"));
        assert!(estimate(&trace, &Cutting { threshold: 1.5, ..Cutting::default() }).is_err());
    }
}
