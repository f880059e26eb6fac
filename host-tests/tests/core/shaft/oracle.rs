//! The shaft's estimates by other means, in f64: direct-form filters, normal equations, and phasors of the unwrapped
//! angle.

use bearing_watch::Angle;
use bearing_watch::model::ShaftConstants;
use bearing_watch::plan::RunTime;
use nalgebra::{DMatrix, DVector};

use crate::rig::Motion;

/// What the core's [`bearing_watch::ShaftEstimate`] should say.
#[derive(Debug)]
pub struct Expected {
    /// p₀ … p₄, without p₃ where no load is measured.
    pub parameters: Vec<f64>,
    pub deviations: Vec<f64>,
    /// Drag at the usual velocity, and its deviation.
    pub drag: (f64, f64),
    pub variance: f64,
    pub rows: usize,
    /// Prominence and amplitude of each order.
    pub orders: Vec<(f64, f64)>,
}

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

/// x delayed by that number of samples, with linear interpolation between samples.
fn delayed(x: &[f64], by: f64) -> Vec<f64> {
    let (whole, part) = (by.floor() as usize, by.fract());
    let at = |k: usize| x[k.max(whole + 1) - whole] * (1.0 - part) + x[k.max(whole + 1) - whole - 1] * part;
    (0..x.len()).map(at).collect()
}

/// A stream without refused samples; the core's first four fill its delay line.
pub fn expected(constants: &ShaftConstants<RunTime>, load: bool, motions: &[Motion]) -> Expected {
    let ShaftConstants { current_delay, balance, tracking } = constants;
    let column = |pick: fn(&Motion) -> f32| motions.iter().map(|m| f64::from(pick(m))).collect::<Vec<_>>();
    let later = |pick| delayed(&column(pick), f64::from(*current_delay))[4..].to_vec();
    let i = column(|m| m.current_a)[4..].to_vec();
    let (w, r, t) = (later(|m| m.velocity_rad_s), later(|m| m.reference_rad_s), later(|m| m.load_nm));
    let s: Vec<f64> = r.iter().map(|r| (r / f64::from(balance.sign_velocity_rad_s)).clamp(-1.0, 1.0)).collect();

    // Torque balance.
    let (g, ts) = (f64::from(balance.filter.gain), f64::from(balance.interval_s));
    let [(fi, _), (fw, dw), (fr, dr), (ft, _), (fs, _)] = [&i, &w, &r, &t, &s].map(|x| filtered(x, g, ts));
    let rows: Vec<usize> = (1 + balance.settle as usize..i.len()).step_by(balance.row_interval as usize).collect();
    // A tenth of a row of full excitation that holds the nominal viscous friction, as the last.
    let held = 0.1_f64.sqrt() / f64::from(balance.scale[1]);
    let matrix = |columns: [&[f64]; 5]| {
        let used = columns.iter().enumerate().filter(|(k, _)| load || *k != 3).map(|(_, column)| column);
        let used: Vec<_> = used.collect();
        let cell = |k: usize, c: usize| match rows.get(k) {
            Some(&row) => used[c][row],
            None if c == 1 => held,
            None => 0.0,
        };
        DMatrix::from_fn(rows.len() + 1, used.len(), cell)
    };
    let one = vec![1.0; i.len()];
    let (x, z) = (matrix([&dw, &fw, &fs, &ft, &one]), matrix([&dr, &fr, &fs, &ft, &one]));
    let target = rows.iter().map(|&k| fi[k]).chain([held * f64::from(balance.nominal[1])]);
    let y = DVector::from_iterator(rows.len() + 1, target);
    let inverse = (z.transpose() * &x).try_inverse().expect("excited");
    let parameters = &inverse * (z.transpose() * &y);
    let n = parameters.len();
    let variance = (&y - &x * &parameters).norm_squared() / (rows.len() - n) as f64;
    let covariance = &inverse * (z.transpose() * &z) * inverse.transpose() * variance;

    let speed = f64::from(balance.usual_velocity_rad_s);
    let drag = parameters[2] + speed * parameters[1];
    let drag_variance = covariance[(2, 2)] + speed * (2.0 * covariance[(1, 2)] + speed * covariance[(1, 1)]);

    // Residual, and the way turned to it.
    let p = balance.nominal.map(f64::from);
    let e: Vec<f64> = (0..i.len()).map(|k| i[k] - p[1] * w[k] - p[2] * s[k] - p[3] * t[k] - p[4]).collect();
    let residual = |k: usize| (e[k] + e[k - 1]) / 2.0 - p[0] * (w[k] - w[k - 1]) / ts;
    let steps = motions.windows(2).map(|pair| Angle::since(pair[1].angle, pair[0].angle));
    let mut way = vec![0.0];
    steps.for_each(|step| way.push(way[way.len() - 1] + f64::from(step) / 4_294_967_296.0));
    let back = (f64::from(*current_delay) + 1.0).floor() as usize;
    let still = f64::from(tracking.slowest_turn) / 4_294_967_296.0;
    let moving: Vec<(f64, f64)> = (1..i.len())
        .filter_map(|k| {
            let (now, before) = (way[k + 4 - back], way[k + 3 - back]);
            ((now - before).abs() > still).then(|| (now, residual(k) * (now - before).signum()))
        })
        .collect();
    let orders = tracking.orders.iter().enumerate().map(|(k, order)| {
        // The first block of order k is k samples longer.
        let length = tracking.block_samples as usize;
        let (first, rest) = moving.split_at(length + k);
        let blocks: Vec<_> = std::iter::once(first).chain(rest.chunks_exact(length)).collect();
        let samples = (k + blocks.len() * length) as f64;
        let turn = std::f64::consts::TAU * f64::from(order.order_q16) / 65_536.0;
        let (mut prominence, mut amplitude) = (0.0, 0.0);
        for (h, weight) in (1..).zip(order.weights) {
            let phasor = |block: &&[(f64, f64)]| {
                block.iter().fold([0.0; 2], |[x, y], (way, r)| {
                    let phase = f64::from(h) * turn * way;
                    [x + r * phase.cos(), y - r * phase.sin()]
                })
            };
            let own: Vec<[f64; 2]> = blocks.iter().map(phasor).collect();
            let sum = own.iter().fold([0.0; 2], |[x, y], b| [x + b[0], y + b[1]]);
            let square = sum[0].powi(2) + sum[1].powi(2);
            let power: f64 = own.iter().map(|b| b[0].powi(2) + b[1].powi(2)).sum();
            prominence += f64::from(weight) * square / power;
            if h == 1 {
                amplitude = 2.0 * ((square - power).max(0.0) / (1.0 - 1.0 / blocks.len() as f64)).sqrt() / samples;
            }
        }
        (prominence / order.weights.iter().map(|w| f64::from(*w)).sum::<f64>(), amplitude)
    });
    Expected {
        parameters: parameters.iter().copied().collect(),
        deviations: (0..n).map(|k| covariance[(k, k)].sqrt()).collect(),
        drag: (drag, drag_variance.sqrt()),
        variance,
        rows: rows.len(),
        orders: orders.collect(),
    }
}
