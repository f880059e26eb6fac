//! The columns of the regressor as slices of the signals; no matrix is built.
//!
//! ```text
//! y(t) = Σ θₖ φₖ(t) + e(t),   φ = −y(t−1)…, u1(t−nkb)…, u2(t−nkc)…, 1,   rows t₀ … N−1
//! ```
//!
//! The columns of y hold +y(t−k); the negative sign of the model is applied to the result.

use super::Structure;
use super::kernel::filter::add_columns;
use crate::trace::Trace;

/// Signals of equal length, measured or filtered.
#[derive(Clone, Copy)]
pub(super) struct Signals<'a> {
    pub y: &'a [f64],
    pub u1: &'a [f64],
    pub u2: &'a [f64],
    /// The constant column, at least as long as the number of rows; not read by structures without a constant term.
    pub constant: &'a [f64],
}

impl<'a> Signals<'a> {
    pub(super) fn of(trace: &'a Trace, constant: &'a [f64]) -> Self {
        Self { y: &trace.y, u1: &trace.u1, u2: &trace.u2, constant }
    }

    /// Rows t₀ … N−1 of every column, in the order of the parameters.
    pub(super) fn columns(&self, structure: Structure) -> Vec<&'a [f64]> {
        let Structure { na, nb, nc, nkb, nkc, .. } = structure;
        let t0 = structure.depth();
        let mut columns = Vec::with_capacity(structure.parameters() + usize::from(na) + 1);
        columns.extend(lags(self.y, t0, 1, na));
        columns.extend(lags(self.u1, t0, nkb.into(), nb));
        columns.extend(lags(self.u2, t0, nkc.into(), nc));
        if structure.offset {
            columns.push(&self.constant[..self.y.len() - t0]);
        }
        columns
    }

    /// `A y − B u1 − C u2 − constant` for rows t₀ … N−1.
    pub(super) fn residuals(&self, structure: Structure, theta: &[f64], residuals: &mut Vec<f64>) {
        let na = usize::from(structure.na);
        residuals.clear();
        residuals.extend_from_slice(&self.y[structure.depth()..]);
        subtract(&self.columns(structure), na, theta, residuals);
    }
}

/// Rows t₀ … N−1 of x(t−first), x(t−first−1), ….
pub(super) fn lags(x: &[f64], t0: usize, first: usize, count: u8) -> impl Iterator<Item = &[f64]> {
    (first..first + usize::from(count)).map(move |lag| &x[t0 - lag..x.len() - lag])
}

/// Subtracts the columns times θ from `target`; the first `negative` columns have − sign in the model.
pub(super) fn subtract(columns: &[&[f64]], negative: usize, theta: &[f64], target: &mut [f64]) {
    let weights: Vec<f64> = theta.iter().enumerate().map(|(k, &p)| if k < negative { p } else { -p }).collect();
    add_columns(&weights, columns, target);
}

/// The constant column if the structure has a constant term; empty otherwise.
pub(super) fn constant(structure: Structure, value: f64, samples: usize) -> Vec<f64> {
    if structure.offset { vec![value; samples] } else { Vec::new() }
}
