//! Regressor rows and the filters that estimators apply to them. Filters start from zero.

use nalgebra::{DMatrix, DVector};

use super::kernel::filter::recur;
use super::{Structure, Terms, reflect_unstable, simulate};
use crate::trace::Trace;

/// Regressor rows `start` … N−1 with `output` in place of y: −y(t−1)…, u1(t−nkb)…, u2(t−nkc)…, 1. Signals are zero
/// before the first sample.
pub(super) fn regressors(structure: Structure, start: usize, output: &[f64], u1: &[f64], u2: &[f64]) -> DMatrix<f64> {
    let Structure { na, nb, nc, nkb, nkc, .. } = structure;
    let mut x = DMatrix::from_element(output.len() - start, structure.parameters(), 1.0);
    let lags =
        |signal, first: u8, count: u8, sign| (0..count as usize).map(move |k| (signal, first as usize + k, sign));
    let columns = lags(output, 1, na, -1.0).chain(lags(u1, nkb, nb, 1.0)).chain(lags(u2, nkc, nc, 1.0));
    for (mut column, (signal, lag, sign)) in x.column_iter_mut().zip(columns) {
        for (row, cell) in column.iter_mut().enumerate() {
            *cell = if start + row >= lag { sign * signal[start + row - lag] } else { 0.0 };
        }
    }
    x
}

/// Regressions of the measured and of the simulated output, both filtered by 1/A.
pub(super) struct Prefiltered {
    /// Rows of the measured output, Φ/A.
    pub measured: DMatrix<f64>,
    /// Rows of the simulated output, Ψ/A: the gradient of the simulated output with respect to θ.
    pub simulated: DMatrix<f64>,
    /// y/A.
    pub target: DVector<f64>,
    /// y − simulated output.
    pub output_error: DVector<f64>,
    /// Whether A was unstable and its poles were reflected.
    pub reflected: bool,
}

/// Filters by 1/A of `theta` (unstable poles are reflected) and keeps rows t₀ ….
///
/// Without a constant term the filters start at the first sample, as the simulation does. With a constant term they
/// start at t₀, because up to there the simulation equals the measured output. In both cases y/A − (Φ/A) θ is the
/// output error.
pub(super) fn prefilter(trace: &Trace, structure: Structure, theta: &[f64]) -> Prefiltered {
    let t0 = structure.depth();
    let start = if structure.offset { t0 } else { 0 };
    let ([a, _, _], _) = structure.polynomials(theta);
    let stable = reflect_unstable(&a);
    let output = simulate(trace, structure, theta);
    let na = structure.na as usize;
    let filtered = |output: &[f64], columns: usize| {
        let mut x = regressors(structure, start, output, &trace.u1, &trace.u2);
        x.column_iter_mut().take(columns).for_each(|mut column| all_pole(&stable, column.as_mut_slice()));
        x.remove_rows(0, t0 - start)
    };
    let measured = filtered(&trace.y, structure.parameters());
    let mut simulated = filtered(&output, na);
    // The columns of the inputs and the constant are the same in both.
    for k in na..structure.parameters() {
        simulated.set_column(k, &measured.column(k));
    }
    let mut target = trace.y[start..].to_vec();
    all_pole(&stable, &mut target);
    let output_error = DVector::from_iterator(
        trace.y.len() - t0,
        trace.y[t0..].iter().zip(&output[t0..]).map(|(y, simulated)| y - simulated),
    );
    let target = DVector::from_column_slice(&target[t0 - start..]);
    Prefiltered { measured, simulated, target, output_error, reflected: stable != a }
}

/// Filters in place by 1/A, `A = 1 + a₁ q⁻¹ + …`.
pub(crate) fn all_pole(a: &[f64], x: &mut [f64]) {
    recur(&a[1..], 0, x);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::kernel::filter::fir;

    fn trace() -> Trace {
        let wave = |f: f64| (0..40).map(|t| (f * t as f64).sin() + 0.3 * (2.7 * f * t as f64).cos()).collect();
        Trace {
            id: "t".into(),
            interval_s: None,
            irregular_steps: 0,
            y: wave(0.9),
            u1: wave(0.5),
            u2: wave(0.23),
            motion: None,
            ..Trace::default()
        }
    }

    #[test]
    fn all_pole_undoes_taps() {
        let a = [1.0, -0.7, 0.2];
        let mut x = Vec::new();
        fir(&a, &trace().y, &mut x);
        all_pole(&a, &mut x);
        for (got, want) in x.iter().zip(trace().y) {
            assert!((got - want).abs() < 1e-13); // rounding of a stable recursion
        }
    }

    #[test]
    fn filtered_regression_leaves_the_output_error() {
        for offset in [false, true] {
            let structure = Structure { offset, ..Structure::new(2, 2, 1, 1, 3) };
            let theta = [-1.2, 0.5, 0.4, -0.1, 0.3, 0.2];
            let theta = &theta[..structure.parameters()];
            let p = prefilter(&trace(), structure, theta);
            let left = &p.target - &p.measured * DVector::from_column_slice(theta);
            assert!((left - &p.output_error).amax() < 1e-13 && !p.reflected);
            // Central difference of the simulated output: its error is the third derivative times 1e-10.
            for k in 0..theta.len() {
                let moved = |step: f64| {
                    let mut theta = theta.to_vec();
                    theta[k] += step;
                    prefilter(&trace(), structure, &theta).output_error
                };
                let slope = (moved(-1e-5) - moved(1e-5)) / 2e-5;
                assert!((slope - p.simulated.column(k)).amax() < 1e-7, "parameter {k}, offset {offset}");
            }
        }
    }
}
