//! The bearing orders by direct sums in f64 over whole records: phasors of the unwrapped angle, blocks cut in advance,
//! products of all pairs, and the spectrum at each slip.

use std::f64::consts::TAU;
use std::ops::Range;

use bearing_watch::model::{CONTROLS, TrackedOrder, Tracking};
use bearing_watch::plan::RunTime;
use nalgebra::Complex;

/// Γ(5/4).
const GAMMA: f64 = 0.906_402_477_055_477;
const TURN: f64 = 4_294_967_296.0;
const HARMONICS: usize = 3;
const LAGS: usize = 6;

/// What the orders are computed from, a number a step.
#[derive(Debug, Default)]
pub struct Path {
    /// Turned since the start, counts of 2⁻³² turn.
    pub turned: Vec<i64>,
    pub white: Vec<f64>,
    pub excitation: Vec<f64>,
}

/// What the core's [`bearing_watch::shaft::OrderStrength`] should say.
#[derive(Clone, Copy, Debug, Default)]
pub struct Expected {
    pub prominence: f64,
    pub score: f64,
    pub amplitude: f64,
    pub deviation: f64,
    pub slip: f64,
    pub slip_deviation: f64,
}

/// A part of a block: samples of one direction and about one speed.
struct Part {
    samples: Range<usize>,
    cell: i64,
    /// Whether the block of the part before goes on in it, and whether its block ends with it.
    continues: bool,
    ends: bool,
}

/// All parts that have closed at the end of the record.
fn parts(path: &Path, cell_turns: f64, items: usize) -> Vec<Part> {
    let width = (cell_turns * TURN) as i64;
    let (mut parts, mut cell, mut travelled, mut idle, mut last): (Vec<Part>, _, _, _, _) = (vec![], 0, 0, 0, 0);
    let (mut from, mut direction, mut continues) = (0, 0.0, false);
    let (mut square, mut way) = (0.0, 0.0);
    for (k, (&turned, &excitation)) in path.turned.iter().zip(&path.excitation).enumerate() {
        let step = (turned - last) as f64;
        (square, way) = (square + excitation.powi(2), way + excitation.powi(2) * step);
        travelled += (turned - last).abs();
        last = turned;
        let now = turned.div_euclid(width);
        if k < idle {
            continue;
        }
        let ratio = step.abs() / (way / square).abs();
        let faster = excitation != 0.0 && !(1.0 / 1.5..=1.5).contains(&ratio);
        let (ends, reverses) = (now != cell || travelled >= width, direction * excitation < 0.0);
        if excitation != 0.0 {
            direction = excitation;
        }
        if ends || reverses || faster {
            parts.push(Part { samples: from..k + 1, cell, continues, ends });
            // One item a sample, then one for the controls each, then one that keeps the block.
            (from, idle, continues) = (k + 1, k + items + CONTROLS + 2, !ends);
            (square, way) = (0.0, 0.0);
        }
        if ends {
            (cell, travelled) = (now, 0);
        }
    }
    parts
}

/// The filters of the residual: pole, pole of the high-pass, and samples from step to step.
#[derive(Clone, Copy)]
struct Filters {
    pole: f64,
    high_pass: f64,
    decimation: usize,
}

/// The response of the residual's filter at an angle of θ a step; of each second sample, with that of its half-band
/// filter.
fn response(Filters { pole, high_pass, decimation }: Filters, theta: f64) -> Complex<f64> {
    let z = Complex::from_polar(1.0, -theta);
    let of_samples = 0.5 + (9.0 * (theta / 2.0).cos() - (1.5 * theta).cos()) / 16.0;
    let half_band = if decimation == 1 { 1.0 } else { of_samples };
    let high = if high_pass > 0.0 { (1.0 - z) / (1.0 - z * (1.0 - high_pass)) } else { 1.0.into() };
    high / (1.0 - z * pole) * half_band
}

/// b and W of the parts that close `after` samples after their last one, within the record.
fn blocks(path: &Path, (order, filters): (f64, Filters), parts: &[Part], after: usize) -> Vec<(Complex<f64>, f64)> {
    let closed = parts.iter().filter(|part| part.samples.end + after <= path.turned.len());
    let of = |part: &Part| {
        let (mut sum, mut square, mut way) = (Complex::new(0.0, 0.0), 0.0, 0.0);
        for k in part.samples.clone() {
            let phase = TAU * order * path.turned[k] as f64 / TURN;
            sum += Complex::from_polar(path.white[k] * path.excitation[k], -phase);
            let before = if k == 0 { 0 } else { path.turned[k - 1] };
            square += path.excitation[k].powi(2);
            way += path.excitation[k].powi(2) * (path.turned[k] - before) as f64;
        }
        if square == 0.0 {
            return (Complex::new(0.0, 0.0), 0.0);
        }
        let response = response(filters, TAU * order * way / square / TURN);
        (response.conj() * sum, response.norm_sqr() * square)
    };
    closed.map(of).collect()
}

/// Whole blocks: the parts of each together.
fn whole(parts: &[Part], of_parts: &[(Complex<f64>, f64)]) -> Vec<(Complex<f64>, f64)> {
    let mut blocks: Vec<(Complex<f64>, f64)> = vec![];
    for (part, &(b, w)) in parts.iter().zip(of_parts) {
        match blocks.last_mut() {
            Some((sum, weight)) if part.continues => (*sum, *weight) = (*sum + b, *weight + w),
            _ => blocks.push((b, w)),
        }
    }
    if of_parts.len().checked_sub(1).is_some_and(|last| !parts[last].ends) {
        blocks.pop();
    }
    blocks
}

/// Sums of one harmonic: R(h, d), V(d), Σ W.
struct Harmonic {
    lags: [Complex<f64>; LAGS + 1],
    pairs: [f64; LAGS + 1],
    weight: f64,
}

impl Harmonic {
    fn new(blocks: &[(Complex<f64>, f64)], parts: &[Part]) -> Self {
        let mut sums = Self { lags: [Complex::new(0.0, 0.0); LAGS + 1], pairs: [0.0; LAGS + 1], weight: 0.0 };
        for (n, &(b, w)) in blocks.iter().enumerate() {
            sums.lags[0] += b.norm_sqr();
            sums.pairs[0] += w * w;
            sums.weight += w;
            // Parts of the last six blocks, of which the newest may go on in this part.
            let held = parts[..n].iter().rev().scan(0, |blocks, part| {
                *blocks += usize::from(!part.continues);
                Some(*blocks - usize::from(!part.continues))
            });
            let held = held.take_while(|blocks| *blocks < LAGS).count();
            for m in n - held..n {
                let ((b_m, w_m), apart) = (blocks[m], parts[n].cell - parts[m].cell);
                let product = b * b_m.conj();
                match apart.unsigned_abs() as usize {
                    0 => {
                        sums.lags[0] += 2.0 * product.re;
                        sums.pairs[0] += 2.0 * w * w_m;
                    }
                    d @ 1..=LAGS => {
                        sums.lags[d] += if apart < 0 { product.conj() } else { product };
                        sums.pairs[d] += w * w_m;
                    }
                    _ => (),
                }
            }
        }
        sums
    }
}

fn taper(d: usize) -> f64 {
    1.0 - d as f64 / 7.0
}

/// The orders of a record.
pub fn expected(tracking: &Tracking<RunTime>, path: &Path, decimation: usize) -> Vec<Expected> {
    let shape = &tracking.blocks;
    let cell_turns = f64::from(shape.cell_turns_log2).exp2();
    let filters = Filters { pole: shape.pole.into(), high_pass: shape.high_pass.into(), decimation };
    let items = tracking.orders.len() * HARMONICS;
    let parts = parts(path, cell_turns, items);
    let noise = |(c, order): (usize, &i32)| {
        let order = f64::from(*order) / 65_536.0;
        let blocks = whole(&parts, &blocks(path, (order, filters), &parts, 1 + items + c)).into_iter();
        let roots: Vec<f64> = blocks.filter(|(_, w)| *w > 0.0).map(|(b, w)| (b.norm_sqr() / w).powf(0.25)).collect();
        [order.ln(), 4.0 * (roots.iter().sum::<f64>() / roots.len() as f64 / GAMMA).ln(), roots.len() as f64]
    };
    let points: Vec<[f64; 3]> = shape.controls.iter().enumerate().map(noise).collect();
    // The line through the points by the normal equations of its two coefficients.
    let sum = |f: &dyn Fn(f64, f64) -> f64| points.iter().map(|[x, y, _]| f(*x, *y)).sum::<f64>();
    let (n, x, y) = (points.len() as f64, sum(&|x, _| x), sum(&|_, y| y));
    let slope = (n * sum(&|x, y| x * y) - x * y) / (n * sum(&|x, _| x * x) - x * x);
    let variance = |order: f64| ((y - slope * x) / n + slope * order.ln()).exp();
    let fewest = points.iter().map(|[_, _, count]| *count).fold(f64::INFINITY, f64::min);
    // Variance of a line at an abscissa by the inverse of its normal equations [n x; x xx].
    let squares = sum(&|x, _| x * x);
    let far: f64 = points.iter().map(|[x, y, _]| (y - variance(x.exp()).ln()).powi(2)).sum();
    // The mean square about the line, of two degrees of freedom less than points, beyond that of the blocks.
    let of_blocks = 16.0 * (0.886_226_925_452_758 / (GAMMA * GAMMA) - 1.0) / fewest;
    let excess = far / (n - 2.0) - of_blocks;
    let uncertain = |order: f64| {
        let at = order.ln();
        let unit = (squares - 2.0 * x * at + n * at * at) / (n * squares - x * x);
        // A fifth of it counts, and not all of a large one.
        (of_blocks + (0.2 * excess).clamp(0.0, 0.12)) * unit
    };
    let lines = tracking.orders.iter().enumerate().map(|(line, order)| {
        let harmonic = |h: usize| {
            let own = (h + 1) as f64 * f64::from(order.order_q16) / 65_536.0;
            Harmonic::new(&blocks(path, (own, filters), &parts, 1 + line * HARMONICS + h), &parts)
        };
        let sums: [Harmonic; HARMONICS] = std::array::from_fn(harmonic);
        strength(order, &sums, (&variance, &uncertain), (cell_turns, f64::from(shape.slip)))
    });
    lines.collect()
}

/// The normal score of the largest of M F-distributed ratios with 2/(9a) and 2/(9b) degrees of freedom (Paulson 1942),
/// with a common denominator and a constant part of the numerator's variance in common.
fn paulson((ratio, a): (f64, f64), b: f64, (largest_of, constant): (f64, f64)) -> f64 {
    let (mean, deviation) = (0.7 * largest_of.ln(), 1.0 / (1.0 + 0.2 * largest_of.ln()));
    let varying = a * (1.0 - constant);
    let variance = varying * deviation.powi(2) + a * constant + b * ratio.powf(2.0 / 3.0);
    ((1.0 - b) * ratio.cbrt() - (1.0 - a) - mean * varying.sqrt()) / variance.sqrt()
}

fn strength(
    order: &TrackedOrder,
    sums: &[Harmonic; HARMONICS],
    (variance, uncertain): (&dyn Fn(f64) -> f64, &dyn Fn(f64) -> f64),
    (cell_turns, most): (f64, f64),
) -> Expected {
    let weights = order.weights.map(f64::from);
    let total: f64 = weights.iter().sum();
    let first = &sums[0];
    // The power of a harmonic without twice what stays in phase from block to block; of what exceeds twice the noise of
    // the control orders, twice as much is noise too, up to four times that of the control orders; all of it without
    // three times what stays in phase.
    let controls = |h: usize| variance((h + 1) as f64 * f64::from(order.order_q16) / 65_536.0);
    let at = |h: usize| {
        let control = controls(h);
        let norm = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
        let lagged: Vec<f64> = sums[h].lags[1..].iter().map(|r| r.norm()).collect();
        let in_phase = norm(&lagged) / norm(&first.pairs[1..]) * first.pairs[0];
        let [own, rest] = [2.0, 3.0].map(|times| (sums[h].lags[0].re - times * in_phase) / sums[h].weight);
        let excess = if own.is_nan() { 0.0 } else { (own / control - 2.0).max(0.0) };
        let limited = control * (1.0 + 2.0 * excess).min(4.0);
        if rest > limited { rest } else { limited }
    };
    let base = controls(0);
    // ψ for a slip of one.
    let turning = TAU * f64::from(order.order_q16) / 65_536.0 * f64::from(order.slip_ratio) * cell_turns;
    let lagged = |h: usize, slip: f64| -> f64 {
        let at = |d: usize| sums[h].lags[d] * Complex::from_polar(1.0, -((d * (h + 1)) as f64) * turning * slip);
        (1..=LAGS).map(|d| taper(d) * at(d).re).sum()
    };
    let spectrum = |slip: f64| -> f64 {
        let own = |h: usize| {
            let power = sums[h].lags[0].re + 2.0 * lagged(h, slip);
            weights[h] * power / sums[h].weight / at(h)
        };
        (0..HARMONICS).map(own).sum::<f64>()
    };
    let tried: Vec<f64> = (-8..=8).map(|k| spectrum(f64::from(k) * most / 8.0)).collect();
    // Of equal values the nearest to zero.
    let best =
        (0..17).fold(0, |best, k| if tried[k] > tried[best] || (k <= 8 && tried[k] >= tried[best]) { k } else { best });
    let (mut slip, mut peak, mut curvature) = ((best as f64 - 8.0) * most / 8.0, tried[best], 0.0);
    // The parabola through three points. An order that does not slip with the cage has none.
    if (1..16).contains(&best) && 2.0 * peak > tried[best - 1] + tried[best + 1] {
        let (slope, bend) = ((tried[best + 1] - tried[best - 1]) / 2.0, 2.0 * peak - tried[best - 1] - tried[best + 1]);
        slip += slope / bend * most / 8.0;
        peak += slope * slope / bend / 2.0;
        curvature = bend / (most / 8.0).powi(2);
    }
    let sum_of = |f: &dyn Fn(usize) -> f64| (1..=LAGS).map(f).sum::<f64>();
    let noise = first.pairs[0] + 2.0 * sum_of(&|d| taper(d).powi(2) * first.pairs[d]);
    let spread = 2.0 * sum_of(&|d| (d as f64 * taper(d)).powi(2) * first.pairs[d]);
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let freedom = 2.0 * (total * first.weight).powi(2) / (squares * noise);
    let prominence = (peak / total).max(0.0);
    let (relative, own) = (2.0 / (9.0 * freedom), uncertain(f64::from(order.order_q16) / 65_536.0) / 9.0);
    // Only what varies with the slip has a largest value over slips.
    let constant = first.pairs[0] / noise;
    let independent = 1.0 + 2.0 * (turning * most).abs() * (spread / noise / (1.0 - constant)).sqrt();
    let rates: f64 = (0..HARMONICS).map(|h| ((h + 1) as f64 * weights[h] * controls(h) / at(h)).powi(2)).sum();
    let steady = sum_of(&|d| taper(d) * first.pairs[d]);
    let power = (lagged(0, slip) / steady).max(0.0);
    let crossed = 1.0 + power * first.pairs[0] / (base * first.weight);
    let slip_deviation = turning.abs() * (rates * spread * crossed).sqrt() / first.weight / curvature;
    Expected {
        prominence,
        score: paulson((prominence, relative), own, (independent, constant)),
        amplitude: 2.0 * power.sqrt(),
        deviation: 2.0 * (base / first.weight).sqrt(),
        slip,
        slip_deviation: if curvature > 0.0 { slip_deviation.min(most) } else { most },
    }
}
