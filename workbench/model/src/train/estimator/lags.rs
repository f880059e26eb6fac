//! The lags of the shaft's signals, from healthy traces with a measured load.
//!
//! ```text
//! i(t + τ_i) = p₀ ω̇(t + τ_ω) + p₁ ω(t + τ_ω) + p₂ s + p₃ T(t + τ_T) + p₄ + p₅ |T| s                     (1)
//! ```
//!
//! Behind a low-pass filter every signal is smooth, so a lag is a shift with straight lines between samples. The lags
//! with the least residual of (1) over all traces are found one after the other, to a tenth of a sample; a lag common
//! to all signals has no effect on (1), so the least lag is zero.

use bearing_watch::model::{Lags, MAX_LAG};
use nalgebra::{DMatrix, SMatrix};

use crate::grey_box::filter::LowPass;
use crate::trace::{MotionTrace, bridged};

/// Number of traces that are used.
const TRACES: usize = 8;
/// Samples from row to row.
const ROW: usize = 5;

/// Shifts of a signal by whole samples, so that lines between them reach the largest lag.
const SHIFTS: usize = MAX_LAG as usize + 1;
/// i, ω̇, ω, s, T, |T| s.
const SIGNALS: usize = 6;
/// The regressors of (1), and the current.
const COLUMNS: usize = SIGNALS + 1;

/// Products of the filtered signals of one trace, each shifted by 0 to 5 samples, and of a constant.
///
/// A signal at a lag is a line between two shifts, so that its products with others are sums of these: a trace is read
/// once, and not for each lag.
struct Products {
    gram: DMatrix<f64>,
    rows: usize,
}

impl Products {
    /// `cutoff` in cycles per sample.
    fn new(trace: &MotionTrace, cutoff: f64, sign_velocity_rad_s: f64) -> Self {
        let filter = LowPass::butterworth(1, cutoff);
        let [current, velocity, load_nm] =
            [&trace.current_a, &trace.velocity_rad_s, &trace.load_nm].map(|signal| bridged(signal));
        let sign: Vec<f64> = velocity.iter().map(|w| (w / sign_velocity_rad_s).clamp(-1.0, 1.0)).collect();
        let friction: Vec<f64> = load_nm.iter().zip(&sign).map(|(t, s)| t.abs() * s).collect();
        let signals: [Vec<f64>; SIGNALS] = [
            filter.forward(&current),
            filter.derivative(&velocity),
            filter.forward(&velocity),
            filter.forward(&sign),
            filter.forward(&load_nm),
            filter.forward(&friction),
        ];
        let settle = (1.6 / cutoff).ceil() as usize;
        let last = current.len().saturating_sub(MAX_LAG as usize + 2);
        let rows: Vec<usize> = (settle..last).step_by(ROW).collect();
        let x = DMatrix::from_fn(rows.len(), 1 + SIGNALS * SHIFTS, |row, column| match column.checked_sub(1) {
            None => 1.0,
            Some(place) => signals[place / SHIFTS][rows[row] + place % SHIFTS],
        });
        Self { gram: x.tr_mul(&x), rows: rows.len() }
    }

    /// The squares of the residual of (1) and their number.
    fn residual(&self, lags: [f64; 3]) -> (f64, f64) {
        if self.rows < 2 * SIGNALS {
            return (0.0, 0.0);
        }
        let [current, velocity, load] = lags;
        // The current last; the constant is its own shift.
        let lags = [velocity, velocity, velocity, load, load, current];
        let signals = [1, 2, 3, 4, 5, 0];
        let mut weights = [[(0, 1.0), (0, 0.0)]; COLUMNS];
        for ((weights, signal), lag) in weights[1..].iter_mut().zip(signals).zip(lags) {
            let (shift, part) = (1 + signal * SHIFTS + lag.floor() as usize, lag.fract());
            *weights = [(shift, 1.0 - part), (shift + 1, part)];
        }
        let products = SMatrix::<f64, COLUMNS, COLUMNS>::from_fn(|row, column| {
            let pairs = weights[row].iter().flat_map(|one| weights[column].iter().map(move |other| (one, other)));
            pairs.map(|((one, a), (other, b))| a * b * self.gram[(*one, *other)]).sum()
        });
        let mut gram = products.fixed_view::<SIGNALS, SIGNALS>(0, 0).into_owned();
        let right = products.fixed_view::<SIGNALS, 1>(0, SIGNALS).into_owned();
        // Signals that are not excited have dependent columns; so small a ridge has no effect on the others.
        let ridge = 1e-9 * gram.diagonal();
        gram.set_diagonal(&(gram.diagonal() + ridge.add_scalar(1e-12)));
        let solved = gram.cholesky().map_or(0.0, |factor| right.dot(&factor.solve(&right)));
        ((products[(SIGNALS, SIGNALS)] - solved).max(0.0), self.rows as f64)
    }
}

/// Returns the lags with the least residual. `cutoff` in cycles per sample.
pub(crate) fn best(traces: &[&MotionTrace], cutoff: f64, sign_velocity_rad_s: f64) -> Lags {
    let products: Vec<Products> =
        traces.iter().take(TRACES).map(|trace| Products::new(trace, cutoff, sign_velocity_rad_s)).collect();
    let cost = |lags: [f64; 3]| {
        let parts = products.iter().map(|trace| trace.residual(lags));
        parts.map(|(squares, rows)| if rows > 0.0 { (squares / rows).max(1e-300).ln() } else { 0.0 }).sum::<f64>()
    };
    let mut lags = [0.0; 3];
    for step in [0.5, 0.1] {
        for _ in 0..3 {
            for signal in 0..3 {
                lags = along(&cost, lags, signal, step);
            }
        }
    }
    let [current, velocity, load] = lags.map(|lag| lag as f32);
    Lags { current, velocity, load }
}

/// The best lags along one of them; if the others are above zero, all are shifted so that the least is zero.
fn along(cost: &impl Fn([f64; 3]) -> f64, from: [f64; 3], signal: usize, step: f64) -> [f64; 3] {
    let reach = if step > 0.3 { (f64::from(MAX_LAG) / step) as i32 } else { 6 };
    let tried = (-reach..=reach).filter_map(|k| {
        let mut lags = from;
        lags[signal] += step * f64::from(k);
        let least = lags.iter().copied().fold(f64::MAX, f64::min);
        // Rounded, so that steps add up to tenths.
        let lags = lags.map(|lag| ((lag - least) * 10.0).round() / 10.0);
        lags.iter().all(|lag| *lag <= f64::from(MAX_LAG) - 0.1).then(|| (cost(lags), lags))
    });
    tried.min_by(|one, other| one.0.total_cmp(&other.0)).map_or(from, |(_, lags)| lags)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rig::{Condition, Scenario, simulate};

    #[test]
    fn a_late_load_and_the_filter_of_the_current_are_found() {
        let late = |samples: usize| {
            let traces: Vec<MotionTrace> = (0..4)
                .map(|seed| {
                    let scenario = Condition::MIX.apply(Scenario::STANDARD, 70 + seed);
                    let trace = simulate(&scenario, 70 + seed).expect("valid");
                    let mut load = vec![trace.load_torque_nm[0]; samples];
                    load.extend_from_slice(&trace.load_torque_nm[..trace.len() - samples]);
                    MotionTrace {
                        current_a: trace.current_a.clone(),
                        velocity_rad_s: trace.velocity_rad_s.clone(),
                        load_nm: load,
                        angle_rad: trace.angle_rad.clone(),
                        reference_rad_s: vec![],
                    }
                })
                .collect();
            let all: Vec<&MotionTrace> = traces.iter().collect();
            best(&all, 0.016, 1.7)
        };
        // The filter of the current delays by 1.6 ms, of which half an interval is the hold of the voltage.
        let (own, shifted) = (late(0), late(3));
        assert!((0.2..1.0).contains(&own.current) && own.load < 0.3, "{own:?}");
        assert!((shifted.load - own.load - 3.0).abs() < 0.15, "{own:?} {shifted:?}");
    }
}
