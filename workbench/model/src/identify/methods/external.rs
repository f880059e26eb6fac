//! Instrumental variables from an external signal, as a rule the command of the control loop.
//!
//! ```text
//! Z  = lags 0 … L of the command, the regressor's terms of u2 and its constant                   (1)
//! X̂  = Z (ZᵀZ)⁻¹ Zᵀ X,   θ = (X̂ᵀX)⁻¹ X̂ᵀ y                                                      (2)
//! ```
//!
//! (2) is two-stage least squares. The command depends on no noise of the loop, so that θ is consistent for any noise
//! and any feedback, also if u1 is the difference of the command and a noisy measurement; u2 must not be part of the
//! loop. The command must move in as many ways as there are terms of a and b: one sine has two. Covariance as in
//! [`super::iv`], with X̂ as instruments.

use nalgebra::{DMatrix, DVector};

use super::iv::{coloured_cofactor, lost};
use crate::Error;
use crate::identify::filters::regressors;
use crate::identify::refused::complete_row;
use crate::identify::result::{Finding, Noise};
use crate::identify::{Estimate, Structure};
use crate::trace::Trace;

/// Lags of the command beyond the number of terms of a and b.
const FURTHER_LAGS: usize = 8;
/// Singular values below this part of the largest one count as zero; rounding leaves 1e-15, a slow command 1e-8.
const DEPENDENT: f64 = 1e-11;

/// Estimates by the instruments (1) of a command.
///
/// # Errors
/// Fewer rows than parameters; a command that does not determine the parameters.
pub fn external_instruments(trace: &Trace, structure: Structure, command: &[f64]) -> Result<Estimate, Error> {
    let lags = usize::from(structure.na) + usize::from(structure.nb) + FURTHER_LAGS;
    let t0 = complete_row(structure, trace)?;
    if let Some(place) = command.iter().position(|x| !x.is_finite()) {
        let problem = format!("the command misses sample {place}; cut the recording there, or resample it");
        return Err(Error::trace(&trace.id, problem));
    }
    let own = usize::from(structure.na) + usize::from(structure.nb);
    let x = regressors(structure, t0, &trace.y, &trace.u1, &trace.u2);
    let rows = x.nrows();
    let at = |row: usize, lag: usize| (t0 + row).checked_sub(lag).map_or(command[0], |place| command[place]);
    let mut z = DMatrix::zeros(rows, lags + 1 + x.ncols() - own);
    for (k, mut column) in z.column_iter_mut().enumerate() {
        if k <= lags {
            column.iter_mut().enumerate().for_each(|(row, cell)| *cell = at(row, k));
        } else {
            column.copy_from(&x.column(own + k - lags - 1));
        }
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    let refused = |column: usize| lost(structure, trace, column);
    let basis = basis(z);
    let projected = &basis * basis.tr_mul(&x);
    let qr = projected.clone().qr();
    let r = qr.r();
    let norms: Vec<f64> = x.column_iter().map(|column| column.norm()).collect();
    if let Some(column) = (0..r.ncols()).find(|&k| r[(k, k)].abs() <= 1e-9 * norms[k]) {
        return Err(refused(column));
    }
    let q = qr.q();
    let y = DVector::from_column_slice(&trace.y[t0..]);
    let theta = q.tr_mul(&x).lu().solve(&q.tr_mul(&y)).ok_or_else(|| refused(0))?;
    let residuals = &y - &x * &theta;
    let cofactor = coloured_cofactor(&x, projected, &residuals).ok_or_else(|| refused(0))?;
    let noise = Noise::Equation;
    let finding = Finding { theta, cofactor, residuals, noise, converged: true, iterations: 1, reflected: 0 };
    Ok(finding.estimate(trace, structure))
}

/// An orthonormal basis of the columns.
fn basis(z: DMatrix<f64>) -> DMatrix<f64> {
    let qr = z.qr();
    let svd = qr.r().svd(true, false);
    let least = DEPENDENT * svd.singular_values.max();
    let kept: Vec<usize> = (0..svd.singular_values.len()).filter(|&k| svd.singular_values[k] > least).collect();
    let u = svd.u.unwrap_or_default();
    qr.q() * u.select_columns(&kept)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::identify::least_squares;

    /// A loop u = 0.8 (r − y), y = 0.9 y(t−1) + 0.5 u(t−1) + coloured noise that passes the loop too.
    fn closed_loop(seed: u64) -> (Trace, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let (mut y, mut u, mut r) = (vec![0.0], vec![0.0], vec![0.0_f64]);
        let mut colour = 0.0;
        for k in 1..4000 {
            let command = if k % 40 == 0 { draw() } else { r[k - 1] };
            colour = 0.9 * colour + 0.1 * draw();
            y.push(0.9 * y[k - 1] + 0.5 * u[k - 1] + colour);
            r.push(command);
            u.push(0.8 * (command - y[k]));
        }
        let zeros = vec![0.0; y.len()];
        (Trace { id: "loop".into(), u1: u, u2: zeros, y, ..Trace::default() }, r)
    }

    #[test]
    fn coloured_noise_in_a_loop_does_not_bias() {
        let structure = Structure::new(1, 1, 0, 1, 1);
        let truth = [-0.9, 0.5];
        let (mut squares, mut worst) = ([0.0; 2], 0.0_f64);
        for seed in 0..30 {
            let (trace, command) = closed_loop(seed);
            let found = external_instruments(&trace, structure, &command).expect("a rich command");
            for k in 0..2 {
                squares[k] += ((found.theta[k] - truth[k]) / found.deviations()[k]).powi(2) / 30.0;
            }
            let biased = least_squares(&trace, structure).expect("regular");
            worst = worst.max((biased.theta[0] - truth[0]).abs() / biased.deviations()[0]);
        }
        // χ² of 30 draws divided by 30: 0.46 … 1.78 at 1 and 99 %.
        assert!(squares.iter().all(|square| (0.4..1.9).contains(square)), "{squares:?}");
        assert!(worst > 8.0, "least squares is biased: {worst}");
    }

    #[test]
    fn a_constant_command_is_refused() {
        let (trace, command) = closed_loop(1);
        let constant = vec![1.0; command.len()];
        let error = external_instruments(&trace, Structure::new(1, 1, 0, 1, 1), &constant).expect_err("no motion");
        assert!(error.to_string().contains("do not determine the parameters"), "{error}");
    }
}
