//! Difference models by instrumental variables with a recorded command as the external instrument.
//!
//! Input: output, measured input and the command of that input (free of measurement noise and feedback). Output: θ of
//! `A(q) y = B(q) u + constant + e`.
//!
//! ```text
//! θ₀ = least squares;   ŷ = simulation of θ_{p−1} driven by the command
//! Z = regressors of (ŷ, command);   θ_p = (ZᵀX)⁻¹ Zᵀ y,   p = 1 … passes                     (1)
//! ```
//!
//! Least squares is biased if the measured input contains noise or depends on the output through a controller; the
//! command is correlated with neither the noise nor the disturbance.

use nalgebra::{DMatrix, DVector};

use super::regression;
use crate::Error;
use crate::identify::{Structure, Terms, simulate};
use crate::trace::Trace;

/// Parameters with their covariance.
#[derive(Clone, Debug)]
pub struct External {
    /// a₁…, b₁…, constant.
    pub theta: DVector<f64>,
    /// Covariance, valid for correlated residuals too.
    pub covariance: DMatrix<f64>,
    /// Whether the last pass changed every parameter by less than a tenth of its standard deviation.
    pub converged: bool,
}

/// Estimates (1) with the trace's first input as u and its second as the command; zero passes return least squares.
///
/// # Errors
/// A structure with terms in the second input; too few samples; signals or instruments that do not excite the model.
pub fn by_command(trace: &Trace, structure: Structure, passes: usize) -> Result<External, Error> {
    if structure.nc != 0 {
        return Err(Error::Usage("the command is the instrument here and no second input; set nc to 0".into()));
    }
    let (t0, n) = (structure.depth(), structure.parameters());
    if n == 0 || trace.y.len() <= t0 + 2 * n {
        let problem = format!("{} samples for {n} parameters; record more or reduce the order", trace.y.len());
        return Err(Error::trace(&trace.id, problem));
    }
    let x = regressors(structure, t0, &trace.y, &trace.u1);
    let y = DVector::from_column_slice(&trace.y[t0..]);
    let lags = (4.0 * (x.nrows() as f64 / 100.0).powf(2.0 / 9.0)).ceil() as usize;
    let solve = |z: &DMatrix<f64>| {
        regression::solve(&x, z, &y, lags).map_err(|column| {
            let name = &structure.names()[column];
            let problem = format!("signals and command do not excite parameter {name}; use a richer command");
            Error::trace(&trace.id, problem)
        })
    };
    let mut solution = solve(&x)?;
    let mut converged = true;
    let driven = Trace { u1: trace.u2.clone(), ..trace.clone() };
    for _ in 0..passes {
        let simulated = simulate(&driven, structure, solution.theta.as_slice());
        let next = solve(&regressors(structure, t0, &simulated, &trace.u2))?;
        let moved = (&next.theta - &solution.theta).abs();
        converged = moved.iter().zip(next.covariance.diagonal().iter()).all(|(d, v)| *d < 0.1 * v.sqrt());
        solution = next;
    }
    Ok(External { theta: solution.theta, covariance: solution.covariance, converged })
}

/// −y(t−1)…, u(t−nkb)…, 1 for t ≥ t₀.
fn regressors(structure: Structure, t0: usize, y: &[f64], u: &[f64]) -> DMatrix<f64> {
    let (na, nb) = (structure.na as usize, structure.nb as usize);
    let delay = structure.nkb as usize;
    DMatrix::from_fn(y.len() - t0, structure.parameters(), |row, column| {
        let t = t0 + row;
        match column {
            k if k < na => -y[t - 1 - k],
            k if k < na + nb => u[t - delay - (k - na)],
            _ => 1.0,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::Structure;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    #[test]
    fn noise_on_the_measured_input_biases_least_squares_only() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut white = || -> f64 { StandardNormal.sample(&mut rng) };
        let (mut y, mut measured, mut command) = (vec![0.0], vec![0.0], vec![0.0]);
        for t in 1..20_000 {
            y.push(0.9 * y[t - 1] + 0.5 * command[t - 1]);
            command.push(white());
            measured.push(command[t] + 0.7 * white());
        }
        let trace = Trace {
            id: "x".into(),
            interval_s: None,
            irregular_steps: 0,
            y,
            u1: measured,
            u2: command,
            motion: None,
            ..Trace::default()
        };
        let structure = Structure::new(1, 1, 0, 1, 1);
        let ls = by_command(&trace, structure, 0).expect("excited");
        let iv = by_command(&trace, structure, 3).expect("excited");
        // Least squares reduces b by the factor 1/(1 + 0.49) = 0.67.
        assert!((ls.theta[1] - 0.5 / 1.49).abs() < 0.02, "{}", ls.theta);
        for (k, truth) in [-0.9, 0.5].into_iter().enumerate() {
            let sd = iv.covariance[(k, k)].sqrt();
            assert!((iv.theta[k] - truth).abs() < 4.0 * sd && sd < 0.01, "{} ± {sd}", iv.theta[k]); // 4 sd: 1e-4
        }
        assert!(iv.converged);
        let second = Structure::new(1, 1, 1, 1, 1);
        assert!(by_command(&trace, second, 1).is_err());
    }
}
