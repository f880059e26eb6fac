//! Plain alternatives, which know the drive's fourteen runs and no fleet.
//!
//! ```text
//! residual   i − p₁ dω/dt − p₂ ω − p₃ tanh(ω/ω₀) − p₄ T_load − p₅, by least squares over the record       (1)
//! band       x = ln rms of the residual between 10 and 100 Hz, of a run: its mean                          (2)
//! threshold  alarm where (x − mean)/s > Φ⁻¹(1 − 1/R)                                                       (3)
//! CUSUM      C ← max(0, C + (x − mean)/s − ½),   alarm where C > h                                         (4)
//! R          = e^b − b − 1 over ½,   b = h + 1.166                                                         (5)
//! ```
//!
//! R is the set mean number of runs between false alarms, and (5) Siegmund's formula (1985) for a sum in steps of ½
//! standard deviation. Mean and s are those of the drive's runs. Several sums share R.

use model::grey_box::filter::LowPass;
use model::trace::Trace;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use super::judge::Watch;

/// Band of (2), Hz.
const BAND_HZ: [f64; 2] = [10.0, 100.0];
/// Samples after which the filters have settled.
const SETTLED: usize = 400;
/// What the continuous sum of (4) lacks of the one in steps.
const OVERSHOOT: f64 = 1.166;

/// (2) of a record; not a number if the record does not move.
pub(super) fn band(trace: &Trace) -> f64 {
    let (Some(motion), Some(interval_s)) = (&trace.motion, trace.interval_s) else { return f64::NAN };
    let (w, load) = (&motion.velocity_rad_s, &motion.load_nm);
    let rows = w.len().saturating_sub(2);
    let usual = (w.iter().map(|w| w * w).sum::<f64>() / w.len().max(1) as f64).sqrt();
    let x = DMatrix::from_fn(rows, 5, |row, term| match term {
        0 => (w[row + 2] - w[row]) / (2.0 * interval_s),
        1 => w[row + 1],
        2 => (w[row + 1] / (0.05 * usual)).tanh(),
        3 => load[row + 1],
        _ => 1.0,
    });
    let y = DVector::from_fn(rows, |row, _| motion.current_a[row + 1]);
    let Ok(parameters) = (x.transpose() * &x).pseudo_inverse(1e-12).map(|inverse| inverse * x.transpose() * &y) else {
        return f64::NAN;
    };
    let residual = y - x * parameters;
    let low = |hz: f64, x: &[f64]| LowPass::butterworth(2, (hz * interval_s).min(0.45)).forward(x);
    let within = low(BAND_HZ[1], residual.as_slice());
    let slow = low(BAND_HZ[0], &within);
    let power = within.iter().zip(slow).skip(SETTLED).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    0.5 * (power / rows.saturating_sub(SETTLED).max(1) as f64).ln()
}

/// Mean and standard deviation of some runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Usual {
    mean: f64,
    deviation: f64,
}

impl Usual {
    pub(super) fn of(runs: impl Iterator<Item = f64> + Clone) -> Self {
        let count = runs.clone().count() as f64;
        let mean = runs.clone().sum::<f64>() / count;
        let squares: f64 = runs.map(|x| (x - mean).powi(2)).sum();
        Self { mean, deviation: (squares / (count - 1.0)).sqrt() }
    }

    fn score(&self, x: f64) -> f64 {
        (x - self.mean) / self.deviation
    }
}

/// (3).
#[derive(Clone, Copy, Debug)]
pub(super) struct Threshold {
    usual: Usual,
    limit: f64,
}

impl Threshold {
    pub(super) fn new(usual: Usual, runs: f64) -> Self {
        Self { usual, limit: Normal::standard().inverse_cdf(1.0 - 1.0 / runs) }
    }
}

impl Watch for Threshold {
    type Record = Vec<f64>;

    fn run(&mut self, records: &[Vec<f64>]) -> Option<usize> {
        (self.usual.score(mean(records.iter().flatten().copied())) > self.limit).then_some(0)
    }
}

/// (4), a sum for each value of a record.
#[derive(Clone, Debug)]
pub(super) struct Cusum {
    sums: Vec<(Usual, f64)>,
    limit: f64,
}

impl Cusum {
    pub(super) fn new(usual: Vec<Usual>, runs: f64) -> Self {
        let limit = siegmund(runs * usual.len() as f64);
        Self { sums: usual.into_iter().map(|usual| (usual, 0.0)).collect(), limit }
    }
}

impl Watch for Cusum {
    type Record = Vec<f64>;

    fn run(&mut self, records: &[Vec<f64>]) -> Option<usize> {
        let mut raised = None;
        for (place, (usual, sum)) in self.sums.iter_mut().enumerate() {
            let score = usual.score(mean(records.iter().map(|record| record[place])));
            *sum = (*sum + if score.is_nan() { 0.0 } else { score - 0.5 }).max(0.0);
            raised = raised.or((*sum > self.limit).then_some(place));
        }
        raised
    }
}

/// Mean of those that are numbers.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.filter(|x| x.is_finite()).fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0_f64));
    sum / count
}

/// h of (5).
fn siegmund(runs: f64) -> f64 {
    let (mut low, mut high) = (OVERSHOOT, 100.0);
    for _ in 0..60 {
        let b: f64 = 0.5 * (low + high);
        if 2.0 * (b.exp() - b - 1.0) < runs { low = b } else { high = b }
    }
    low - OVERSHOOT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_of_a_sum_is_that_of_tables() {
        // Montgomery's table of the tabular CUSUM with k = ½: h = 5 has a run length of 930 for one side, h = 4 of 335.
        assert!((siegmund(930.0) - 5.0).abs() < 0.02 && (siegmund(335.0) - 4.0).abs() < 0.03);
    }

    #[test]
    fn a_shift_is_summed_and_one_outlier_is_not() {
        let usual = Usual::of([-1.0, 0.0, 1.0].into_iter());
        let mut cusum = Cusum::new(vec![usual], 1000.0);
        assert_eq!((1..20).find(|_| cusum.run(&[vec![1.5], vec![f64::NAN]]).is_some()), Some(6));
        let mut cusum = Cusum::new(vec![usual], 1000.0);
        assert!((0..20).all(|k| cusum.run(&[vec![if k == 9 { 5.0 } else { 0.0 }]]).is_none()));
        let mut threshold = Threshold::new(usual, 1000.0);
        assert!(threshold.run(&[vec![3.0]]).is_none() && threshold.run(&[vec![3.2]]).is_some());
    }
}
