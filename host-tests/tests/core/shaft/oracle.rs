//! The torque balance and its residual by other means, in f64: direct-form filters, normal equations with priors,
//! parameters over time from the equations of all rows so far.

use bearing_watch::model::{Lags, ShaftConstants, TERMS, TorqueBalance};
use bearing_watch::plan::{Load, RunTime};
use nalgebra::{DMatrix, DVector};

use super::orders::{Expected as Order, Path, expected as expected_orders};
use crate::shaft::dc_motor::Motion;

/// What the core's [`bearing_watch::shaft::ShaftEstimate`] should say.
#[derive(Debug)]
pub struct Expected {
    /// Values and deviations of p₀ … p₆ without those of a load that is not measured, then of the drag, then of the
    /// amplitude of a weight.
    pub parameters: Vec<(f64, f64)>,
    /// Those of p₀ … p₆, each without its own prior.
    pub of_rows: Vec<(f64, f64)>,
    pub variance: f64,
    pub rows: usize,
    pub orders: Vec<Order>,
}

impl Expected {
    /// Parameters and those of rows without the two of a weight, whose phase is any.
    pub fn without_phase(&self) -> [Vec<(f64, f64)>; 2] {
        [&self.parameters, &self.of_rows].map(|all| {
            let kept = all.iter().enumerate().filter(|(k, _)| ![3, 5].contains(k));
            kept.map(|(_, own)| *own).collect()
        })
    }
}

/// The step from which the filters run: the core's delay line is full.
const START: usize = 8;
/// Counts of a turn.
const TURN: f64 = 4_294_967_296.0;
/// Rows between two refreshments of the parameters.
const REFRESH: usize = 16;

/// Low-pass and its derivative by the bilinear transform, in direct form I, at rest on the first value.
fn filtered(x: &[f64], g: f64, interval_s: f64) -> (Vec<f64>, Vec<f64>) {
    let root = std::f64::consts::SQRT_2;
    let norm = 1.0 + root * g + g * g;
    let (a1, a2) = (2.0 * (g * g - 1.0) / norm, (1.0 - root * g + g * g) / norm);
    let run = |b: [f64; 3], start: f64| -> Vec<f64> {
        let (mut x1, mut x2, mut y1, mut y2) = (x[0], x[0], start, start);
        let step = |&now: &f64| {
            let y = b[0] * now + b[1] * x1 + b[2] * x2 - a1 * y1 - a2 * y2;
            (x2, x1, y2, y1) = (x1, now, y1, y);
            y
        };
        x.iter().map(step).collect()
    };
    let low = g * g / norm;
    let slope = 2.0 / interval_s * low;
    (run([low, 2.0 * low, low], x[0]), run([slope, 0.0, -slope], 0.0))
}

/// The sample of a step: of each second sample, the first is between two steps.
fn sample(step: usize, decimation: usize) -> usize {
    step * decimation + decimation - 1
}

/// The samples of all steps from [`START`] on.
fn samples(x: usize, decimation: usize) -> impl Iterator<Item = usize> {
    (sample(START, decimation)..x).step_by(decimation)
}

/// x at each step, delayed by that number of samples, with linear interpolation between samples; of each second sample
/// behind the binomial half-band filter.
fn delayed(x: &[f64], by: f64, decimation: usize) -> Vec<f64> {
    let (whole, part) = (by.floor() as usize, by.fract());
    let halved = |k: usize| (0..7).map(|j| HALF_BAND[j] * x[k - j]).sum::<f64>();
    let at = |k: usize| if decimation == 1 { x[k] } else { halved(k) };
    samples(x.len(), decimation).map(|k| at(k - whole) * (1.0 - part) + at(k - whole - 1) * part).collect()
}

/// The maximally flat half-band filter of seven coefficients.
const HALF_BAND: [f64; 7] = [-1.0 / 32.0, 0.0, 9.0 / 32.0, 0.5, 9.0 / 32.0, 0.0, -1.0 / 32.0];

/// The angle in the middle of the last interval, by so many samples late; the half-band filter is three samples late.
fn angles(late: f64, motions: &[Motion], decimation: usize) -> Vec<u32> {
    let late = late as f32 + if decimation == 1 { 0.5 } else { 4.0 };
    let (whole, part) = (late.floor() as usize, late.fract());
    let at = |k: usize| {
        let (newer, older) = (motions[k - whole].angle, motions[k - whole - 1].angle);
        newer.bits().wrapping_add_signed((part * older.since(newer) as f32) as i32)
    };
    samples(motions.len(), decimation).map(at).collect()
}

/// Signals at each step from [`START`] on, all delayed to the slowest one, and the friction terms.
struct Signals {
    i: Vec<f64>,
    w: Vec<f64>,
    t: Vec<f64>,
    /// s, |T| s, s/(1 + (ω/ω_s)²).
    frictions: [Vec<f64>; 3],
    /// Of the shaft, to the bit as in the core, since a block ends where it passes the end of a cell.
    angle: Vec<u32>,
    /// Whether t and |T| s are cosine and sine of the angle of an axis, whose phase is only known of its rows.
    weighs: bool,
    /// Whether the weight changes at rests.
    changes: bool,
}

impl Signals {
    fn new(balance: &TorqueBalance, lags: Lags, motions: &[Motion], (load, decimation): (Load, usize)) -> Self {
        let longest = lags.current.max(lags.velocity).max(lags.load);
        let later = |pick: fn(&Motion) -> f32, lag: f32| {
            let column: Vec<f64> = motions.iter().map(|m| f64::from(pick(m))).collect();
            delayed(&column, f64::from(longest - lag), decimation)
        };
        let (i, w) = (later(|m| m.current_a, lags.current), later(|m| m.velocity_rad_s, lags.velocity));
        let t = later(|m| m.load_nm, lags.load);
        let angle = angles(f64::from(longest), motions, decimation);
        let sign = |w: &f64| (w / f64::from(balance.sign_velocity_rad_s)).clamp(-1.0, 1.0);
        let s: Vec<f64> = w.iter().map(sign).collect();
        let loaded = t.iter().zip(&s).map(|(t, s)| t.abs() * s).collect();
        let square = |w: f64| (w / f64::from(balance.stribeck_velocity_rad_s)).powi(2);
        let stribeck = w.iter().zip(&s).map(|(w, s)| s / (1.0 + square(*w))).collect();
        let plain = Self { i, w, t, frictions: [s, loaded, stribeck], angle, weighs: false, changes: false };
        let Load::Weight { axis_q32, changes } = load else { return plain };
        let ratio = f64::from(axis_q32) / TURN;
        let mut turns = 0.0;
        let axis = plain.angle.iter().scan(plain.angle[0], |last, angle| {
            turns += f64::from(angle.wrapping_sub(*last).cast_signed()) / TURN;
            *last = *angle;
            Some(std::f64::consts::TAU * turns * ratio)
        });
        let (cos, sin): (Vec<f64>, Vec<f64>) = axis.map(|angle| (angle.cos(), angle.sin())).unzip();
        let [s, _, stribeck] = plain.frictions;
        Self { t: cos, frictions: [s, sin, stribeck], weighs: true, changes, ..plain }
    }
}

/// Least squares with priors: Σ (y − xᵀp)² + spread Σ (σ/prior)² (p − nominal)² is least.
struct Squares {
    gram: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
    rows: usize,
}

impl Squares {
    fn new(balance: &TorqueBalance, terms: &[usize]) -> Self {
        let n = terms.len();
        let mut own = Self { gram: DMatrix::zeros(n, n), right: DVector::zeros(n), square: 0.0, rows: 0 };
        for (k, &term) in terms.iter().enumerate() {
            let [nominal, prior, deviation] =
                [balance.nominal[term], balance.prior[term], balance.deviation].map(f64::from);
            let weight = f64::from(balance.row_spread) * (deviation / prior).powi(2);
            own.gram[(k, k)] = weight;
            own.right[k] = weight * nominal;
            own.square += weight * nominal * nominal;
        }
        own
    }

    /// Without the prior of the term in place k, for its parameter alone.
    fn without_prior(&self, balance: &TorqueBalance, terms: &[usize], k: usize) -> Self {
        let priors = Self::new(balance, terms);
        let mut own = Self { gram: self.gram.clone(), right: self.right.clone(), ..*self };
        own.gram[(k, k)] -= priors.gram[(k, k)];
        own.right[k] -= priors.right[k];
        own
    }

    fn add(&mut self, x: &DVector<f64>, y: f64) {
        self.gram += x * x.transpose();
        self.right += x * y;
        self.square += y * y;
        self.rows += 1;
    }

    /// Lets the parameters change along a vector by an unknown part of it, 0 ± 1 beside rows of deviation 1, for which
    /// the sum of squares is least.
    fn loosen(&mut self, by: &DVector<f64>) {
        let pulled = &self.gram * by;
        let (scale, along) = (1.0 + by.dot(&pulled), by.dot(&self.right));
        self.right -= &pulled * (along / scale);
        self.square -= along * along / scale;
        self.gram -= &pulled * pulled.transpose() / scale;
    }

    /// Parameters, inverse of the normal equations, sum of squares of the residual.
    fn solve(&self) -> (DVector<f64>, DMatrix<f64>, f64) {
        // Columns differ by four orders of magnitude, which their diagonal takes away.
        let scale = DMatrix::from_diagonal(&self.gram.diagonal().map(|d| 1.0 / d.sqrt()));
        let inverse = (&scale * &self.gram * &scale).try_inverse().expect("priors determine all");
        let inverse = &scale * inverse * &scale;
        let p = &inverse * &self.right;
        let rest = self.square - 2.0 * p.dot(&self.right) + (p.transpose() * &self.gram * &p)[(0, 0)];
        (p, inverse, rest)
    }
}

/// A stream without refused samples.
pub fn expected(
    constants: &ShaftConstants<RunTime>,
    (known, decimation): (Load, usize),
    motions: &[Motion],
) -> Expected {
    let ShaftConstants { lags, balance, tracking } = constants;
    let signals = Signals::new(balance, *lags, motions, (known, decimation));
    let load = known != Load::Unknown;
    let terms: Vec<usize> = (0..TERMS).filter(|term| load || ![3, 5].contains(term)).collect();
    let (squares, present) = rows(balance, &terms, &signals);
    let (p, inverse, rest) = squares.solve();
    let spread = f64::from(balance.row_spread);
    let variance = rest / (squares.rows as f64 - spread * terms.len() as f64);
    let covariance = inverse * (variance * spread);
    let mut parameters: Vec<(f64, f64)> = (0..terms.len()).map(|k| (p[k], covariance[(k, k)].sqrt())).collect();
    let of_rows = (0..terms.len()).map(|k| {
        let (p, inverse, _) = squares.without_prior(balance, &terms, k).solve();
        (p[k], (inverse[(k, k)] * variance * spread).sqrt())
    });
    let of_rows = of_rows.collect();
    let all = drag_weights(balance);
    let weights = DVector::from_iterator(terms.len(), terms.iter().map(|&term| all[term]));
    parameters.push((weights.dot(&p), weights.dot(&(&covariance * &weights)).sqrt()));
    if signals.weighs {
        let amplitude = p[3].hypot(p[5]);
        let slope = DVector::from_fn(terms.len(), |k, _| if k == 3 || k == 5 { p[k] / amplitude } else { 0.0 });
        parameters.push((amplitude, slope.dot(&(&covariance * &slope)).sqrt()));
    }
    let path = path(constants, &signals, (motions.len(), decimation), &present);
    Expected { parameters, of_rows, variance, rows: squares.rows, orders: expected_orders(tracking, &path, decimation) }
}

/// What a unit of each parameter adds to the friction at the usual velocity and load.
pub fn drag_weights(balance: &TorqueBalance) -> [f64; TERMS] {
    let [speed, stribeck, load] =
        [balance.usual_velocity_rad_s, balance.stribeck_velocity_rad_s, balance.usual_load_nm].map(f64::from);
    [0.0, speed, 1.0, 0.0, 0.0, load, stribeck.powi(2) / (stribeck.powi(2) + speed.powi(2))]
}

/// All rows of a stream, and the parameters that hold at each of its steps.
fn rows(balance: &TorqueBalance, terms: &[usize], signals: &Signals) -> (Squares, Vec<[f64; TERMS]>) {
    let (g, ts) = (f64::from(balance.filter.gain), f64::from(balance.interval_s));
    let Signals { i, w, t, frictions: [s, loaded, stribeck], .. } = signals;
    let ((fw, dw), one) = (filtered(w, g, ts), vec![1.0; i.len()]);
    let [fi, fs, ft, fq, fb] = [i, s, t, loaded, stribeck].map(|x| filtered(x, g, ts).0);
    let columns = [&dw, &fw, &fs, &ft, &one, &fq, &fb];
    let mut squares = Squares::new(balance, terms);
    let mut now = balance.nominal.map(f64::from);
    let (mut next, mut present) = (None, Vec::new());
    let first = 1 + balance.settle as usize;
    let (slow, mut resting) = (0.15 * f64::from(balance.usual_velocity_rad_s), 0);
    for k in 0..i.len() {
        if let Some((from, p)) = next
            && k == from
        {
            now = p;
        }
        present.push(now);
        if k < first || !(k - first).is_multiple_of(balance.row_interval as usize) {
            continue;
        }
        let slot = (k - first) / balance.row_interval as usize + 1;
        if !slot.is_multiple_of(REFRESH) {
            if signals.changes && fw[k].abs() < slow {
                resting += 1;
                if resting > 3 {
                    continue;
                }
            } else if core::mem::take(&mut resting) >= 3 {
                // Half of the weight is a deviation of its change.
                let unit = 0.5 / (f64::from(balance.deviation) * f64::from(balance.row_spread).sqrt());
                let of = |term: &usize| if [3, 5].contains(term) { unit * now[*term] } else { 0.0 };
                squares.loosen(&DVector::from_iterator(terms.len(), terms.iter().map(of)));
            }
            squares.add(&DVector::from_iterator(terms.len(), terms.iter().map(|&term| columns[term][k])), fi[k]);
        } else if balance.adapt_after_rows < u16::MAX && squares.rows >= usize::from(balance.adapt_after_rows) {
            let mut p = now;
            terms.iter().zip(squares.solve().0.iter()).for_each(|(&term, value)| p[term] = *value);
            // So many parameters a step that all are known before the next row.
            let a_step = 8_usize.div_ceil(balance.row_interval.into());
            next = Some((k + terms.len().div_ceil(a_step), p));
        }
    }
    (squares, present)
}

/// Way turned, whitened residual and excitation of each step after the first.
fn path(
    constants: &ShaftConstants<RunTime>,
    signals: &Signals,
    (length, decimation): (usize, usize),
    present: &[[f64; TERMS]],
) -> Path {
    let ShaftConstants { balance, tracking, .. } = constants;
    let Signals { i, w, t, frictions: [s, loaded, stribeck], angle, weighs, .. } = signals;
    let (ts, slowest) = (f64::from(balance.interval_s), f64::from(tracking.blocks.slowest_rad_s));
    let e = |k: usize| {
        let p = &present[k];
        i[k] - p[1] * w[k] - p[2] * s[k] - p[3] * t[k] - p[4] - p[5] * loaded[k] - p[6] * stribeck[k]
    };
    let mut path = Path::default();
    let (mut turned, mut filtered, mut slow) = (0_i64, 0.0, 0.0);
    // The orders of a step are added at the sample after it.
    let steps = (1..i.len()).take_while(|k| sample(k + START, decimation) + decimation - 1 < length);
    for k in steps {
        turned += i64::from(angle[k].wrapping_sub(angle[k - 1]).cast_signed());
        let mean = (w[k] + w[k - 1]) / 2.0;
        let x = (mean.abs() / slowest - 1.0).clamp(0.0, 1.0);
        // The first sample starts the filters; an interval needs two.
        let known = !weighs || present[k] != balance.nominal.map(f64::from);
        let g = if k > 1 && known { 3.0 * x.powi(2) - 2.0 * x.powi(3) } else { 0.0 };
        let rho = g * ((e(k) + e(k - 1)) / 2.0 - present[k][0] * (w[k] - w[k - 1]) / ts);
        filtered = rho + f64::from(tracking.blocks.pole) * filtered;
        let white = filtered - slow;
        slow += f64::from(tracking.blocks.high_pass) * white;
        path.turned.push(turned);
        path.white.push(white);
        path.excitation.push(if mean < 0.0 { -g } else { g });
    }
    path
}
