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
use nalgebra::{DMatrix, DVector};

use crate::grey_box::filter::LowPass;
use crate::trace::{MotionTrace, bridged};

/// Number of traces that are used.
const TRACES: usize = 8;
/// Samples from row to row.
const ROW: usize = 5;

/// Filtered signals of one trace.
struct Signals {
    current: Vec<f64>,
    /// ω̇, ω, s.
    motion: [Vec<f64>; 3],
    /// T, |T| s.
    load: [Vec<f64>; 2],
    settle: usize,
}

impl Signals {
    /// `cutoff` in cycles per sample.
    fn new(trace: &MotionTrace, cutoff: f64, sign_velocity_rad_s: f64) -> Self {
        let filter = LowPass::butterworth(1, cutoff);
        let [current, velocity, load_nm] =
            [&trace.current_a, &trace.velocity_rad_s, &trace.load_nm].map(|signal| bridged(signal));
        let sign: Vec<f64> = velocity.iter().map(|w| (w / sign_velocity_rad_s).clamp(-1.0, 1.0)).collect();
        let friction: Vec<f64> = load_nm.iter().zip(&sign).map(|(t, s)| t.abs() * s).collect();
        Self {
            current: filter.forward(&current),
            motion: [filter.derivative(&velocity), filter.forward(&velocity), filter.forward(&sign)],
            load: [filter.forward(&load_nm), filter.forward(&friction)],
            settle: (1.6 / cutoff).ceil() as usize,
        }
    }

    /// Adds the squares of the residual of (1) and their number to `sum`.
    fn residual(&self, lags: [f64; 3]) -> (f64, f64) {
        let [current, velocity, load] = lags;
        let last = self.current.len().saturating_sub(MAX_LAG as usize + 2);
        let rows: Vec<usize> = (self.settle..last).step_by(ROW).collect();
        let columns = 6;
        if rows.len() < 2 * columns {
            return (0.0, 0.0);
        }
        let cell = |row: usize, column: usize| match column {
            0 => 1.0,
            1..=3 => at(&self.motion[column - 1], rows[row], velocity),
            _ => at(&self.load[column - 4], rows[row], load),
        };
        let x = DMatrix::from_fn(rows.len(), columns, cell);
        let y = DVector::from_iterator(rows.len(), rows.iter().map(|&k| at(&self.current, k, current)));
        let (mut gram, right) = (x.tr_mul(&x), x.tr_mul(&y));
        // Signals that are not excited have dependent columns; so small a ridge has no effect on the others.
        let ridge = 1e-9 * gram.diagonal();
        gram.set_diagonal(&(gram.diagonal() + ridge.add_scalar(1e-12)));
        let solved = gram.cholesky().map_or(0.0, |factor| right.dot(&factor.solve(&right)));
        ((y.norm_squared() - solved).max(0.0), rows.len() as f64)
    }
}

/// Value at sample `k` + `lag`.
fn at(x: &[f64], k: usize, lag: f64) -> f64 {
    let (whole, part) = (lag.floor() as usize, lag.fract());
    x[k + whole] + part * (x[k + whole + 1] - x[k + whole])
}

/// Returns the lags with the least residual. `cutoff` in cycles per sample.
pub(super) fn best(traces: &[&MotionTrace], cutoff: f64, sign_velocity_rad_s: f64) -> Lags {
    let signals: Vec<Signals> =
        traces.iter().take(TRACES).map(|trace| Signals::new(trace, cutoff, sign_velocity_rad_s)).collect();
    let cost = |lags: [f64; 3]| {
        let parts = signals.iter().map(|own| own.residual(lags));
        parts.map(|(squares, rows)| if rows > 0.0 { (squares / rows).max(1e-300).ln() } else { 0.0 }).sum::<f64>()
    };
    let mut lags = [0.0; 3];
    for step in [0.5, 0.1] {
        for _ in 0..3 {
            for own in 0..3 {
                lags = along(&cost, lags, own, step);
            }
        }
    }
    let [current, velocity, load] = lags.map(|lag| lag as f32);
    Lags { current, velocity, load }
}

/// The best lags along one of them; if the others are above zero, all are shifted so that the least is zero.
fn along(cost: &impl Fn([f64; 3]) -> f64, from: [f64; 3], own: usize, step: f64) -> [f64; 3] {
    let reach = if step > 0.3 { (f64::from(MAX_LAG) / step) as i32 } else { 6 };
    let tried = (-reach..=reach).filter_map(|k| {
        let mut lags = from;
        lags[own] += step * f64::from(k);
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
