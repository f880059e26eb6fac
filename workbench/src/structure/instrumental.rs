//! The four-stage instrumental-variable method of [`crate::identify::iv4`] for many structures and stacked traces.
//!
//! ```text
//! Z = [u1 lags, u2 lags, constant, lags of the simulated output] = Q R      (1)  Z alone is triangularised;
//! [Z, lags of y, y] → Qᵀ[…]                                                 (2)  the rest is carried along
//! (QᵀX) θ = Qᵀy                                                             (3)
//! ```
//!
//! X shares its input columns with Z, so that they need no second pass. The first stage is the shared least-squares
//! factor; nothing else can be shared, since each structure has instruments and a noise filter of its own. With
//! several traces all sums run over all of them; filters and simulations start anew in each.

use nalgebra::{DMatrix, DVector};

use super::free_run::{FreeRun, add_filtered};
use super::shared::Solution;
use super::triangle::{Triangle, block_rows, solve_staircase};
use crate::identify::{Order, Structure};
use crate::trace::Trace;

/// As in least squares of one structure.
const DEPENDENT: f64 = 1e-11;

/// Why a structure has no iv4 estimate.
pub(super) const LOST: &str = "the instruments do not determine the parameters";
const REGULAR: &str = "the residuals are too few or too regular for a noise model";

/// Memory of [`iv4`], one a thread.
#[derive(Debug)]
pub(super) struct Scratch {
    triangle: Triangle,
    block: Vec<f64>,
    /// Filtered y, u1, u2 of each trace.
    filtered: Vec<Trace>,
    instruments: Vec<Vec<f64>>,
    work: Vec<f64>,
    noise: Vec<Vec<f64>>,
}

impl Scratch {
    pub(super) fn new(traces: &[Trace]) -> Self {
        Self {
            triangle: Triangle::new(0, 0),
            block: Vec::new(),
            filtered: traces.to_vec(),
            instruments: vec![Vec::new(); traces.len()],
            work: Vec::new(),
            noise: vec![Vec::new(); traces.len()],
        }
    }
}

/// Stages two to four, from the least-squares parameters.
///
/// # Errors
/// Instruments that do not determine the parameters, or residuals that no noise model fits.
pub(super) fn iv4(
    traces: &[Trace],
    structure: Structure,
    first: &Solution,
    scratch: &mut Scratch,
) -> Result<Solution, &'static str> {
    let t0 = structure.order.depth();
    let model = FreeRun::new(structure, &first.theta);
    for (trace, instruments) in traces.iter().zip(&mut scratch.instruments) {
        model.simulate(trace, instruments);
    }
    let second = solve(traces, structure, 1.0, scratch)?;

    for (trace, noise) in traces.iter().zip(&mut scratch.noise) {
        residuals(trace, structure, &second, 1.0, &mut scratch.work);
        noise.clear();
        noise.extend_from_slice(&scratch.work[t0..]);
    }
    let shaping = autoregression(structure.parameters(), scratch)?;
    let model = FreeRun::new(structure, &second);
    for (k, trace) in traces.iter().enumerate() {
        let into = &mut scratch.filtered[k];
        for (x, y) in [(&trace.y, &mut into.y), (&trace.u1, &mut into.u1), (&trace.u2, &mut into.u2)] {
            filter(&shaping, x, y);
        }
        model.simulate(trace, &mut scratch.work);
        filter(&shaping, &scratch.work, &mut scratch.instruments[k]);
    }
    let constant = shaping.iter().sum();
    let filtered = std::mem::take(&mut scratch.filtered);
    let last = solve(&filtered, structure, constant, scratch);
    let mut residual_sum = 0.0;
    for trace in &filtered {
        residuals(trace, structure, last.as_deref().unwrap_or(&second), constant, &mut scratch.work);
        residual_sum += scratch.work[t0..].iter().map(|e| e * e).sum::<f64>();
    }
    scratch.filtered = filtered;
    Ok(Solution { theta: last?, residual_sum, rows: first.rows })
}

/// (1) to (3) with the instruments of `scratch`.
fn solve(
    traces: &[Trace],
    structure: Structure,
    constant: f64,
    scratch: &mut Scratch,
) -> Result<Vec<f64>, &'static str> {
    let Order { na, nb, nc, nkb, nkc } = structure.order;
    let [na, nb, nc, nkb, nkc] = [na, nb, nc, nkb, nkc].map(usize::from);
    let (t0, n) = (structure.order.depth(), structure.parameters());
    let Scratch { triangle, block, instruments, .. } = scratch;
    triangle.reset(n, n + na + 1);
    let rows = block_rows(n + na + 1);
    block.resize((n + na + 1) * rows, 0.0);
    for (trace, instruments) in traces.iter().zip(instruments.iter()) {
        for t in (t0..trace.y.len()).step_by(rows) {
            let height = rows.min(trace.y.len() - t);
            let mut columns = block.chunks_exact_mut(height);
            let mut lags = |x: &[f64], first: usize, count: usize| {
                for (lag, column) in (first..first + count).zip(&mut columns) {
                    column.copy_from_slice(&x[t - lag..][..height]);
                }
            };
            lags(&trace.u1, nkb, nb);
            lags(&trace.u2, nkc, nc);
            if structure.offset
                && let Some(column) = columns.next()
            {
                column.fill(constant);
            }
            let mut lags = |x: &[f64], first: usize, count: usize| {
                for (lag, column) in (first..first + count).zip(&mut columns) {
                    column.copy_from_slice(&x[t - lag..][..height]);
                }
            };
            lags(instruments, 1, na);
            lags(&trace.y, 1, na);
            lags(&trace.y, 0, 1);
            triangle.absorb(block, height);
        }
    }
    // X in the order a, b, c, constant; its columns of y are the carried ones, with the model's sign.
    let system = DMatrix::from_fn(n, n, |row, column| {
        if column < na { -triangle.column(n + column)[row] } else { triangle.column(column - na)[row] }
    });
    let theta = system.lu().solve(&DVector::from_column_slice(triangle.column(n + na))).ok_or(LOST)?;
    if theta.iter().all(|p| p.is_finite()) { Ok(theta.as_slice().to_vec()) } else { Err(LOST) }
}

/// `A y − B u1 − C u2 − constant`; meaningful from t₀ on.
fn residuals(trace: &Trace, structure: Structure, theta: &[f64], constant: f64, work: &mut Vec<f64>) {
    let Order { na, nb, nc, nkb, nkc } = structure.order;
    let negative: Vec<f64> = theta[usize::from(na)..].iter().map(|p| -p).collect();
    let (b, rest) = negative.split_at(nb.into());
    let (c, rest) = rest.split_at(nc.into());
    let level = constant * rest.first().copied().unwrap_or(0.0);
    work.clear();
    work.extend(trace.y.iter().map(|y| y + level));
    add_filtered(&theta[..usize::from(na)], 1, &trace.y, work);
    add_filtered(b, nkb.into(), &trace.u1, work);
    add_filtered(c, nkc.into(), &trace.u2, work);
}

/// `1 + l₁ q⁻¹ + … + l_n q⁻ⁿ` that whitens the noise, by least squares from each trace's n-th residual on.
fn autoregression(n: usize, scratch: &mut Scratch) -> Result<Vec<f64>, &'static str> {
    let Scratch { triangle, block, noise, .. } = scratch;
    triangle.reset(n + 1, n + 1);
    let rows = block_rows(n + 1);
    block.resize((n + 1) * rows, 0.0);
    for w in noise.iter() {
        if w.len() <= 2 * n {
            return Err(REGULAR);
        }
        for t in (n..w.len()).step_by(rows) {
            let height = rows.min(w.len() - t);
            for (k, column) in block.chunks_exact_mut(height).take(n + 1).enumerate() {
                // The target is the column after the lags 1 … n.
                let lag = (k + 1) % (n + 1);
                column.copy_from_slice(&w[t - lag..][..height]);
            }
            triangle.absorb(block, height);
        }
    }
    let mut columns: Vec<f64> = (0..=n).flat_map(|k| triangle.column(k).iter().copied()).collect();
    let heights: Vec<usize> = (1..=n + 1).collect();
    solve_staircase(&mut columns, n + 1, &heights, DEPENDENT).map_err(|_| REGULAR)?;
    let taps = columns[n * (n + 1)..][..n].iter().map(|l| -l);
    Ok(std::iter::once(1.0).chain(taps).collect())
}

/// Filters with zeros before the first sample.
fn filter(taps: &[f64], x: &[f64], output: &mut Vec<f64>) {
    output.clear();
    output.resize(x.len(), 0.0);
    add_filtered(taps, 0, x, output);
}
