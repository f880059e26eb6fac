//! Least squares of a trace with missing samples, NaN: the rows of which a sample is missing are left out.
//!
//! The fit of the simulation is that of the measured samples; where an input is missing, the last one goes on in it.

use nalgebra::DVector;

use crate::Error;
use crate::identify::factor::Factor;
use crate::identify::refused::{held, unexcited};
use crate::identify::regression::{Signals, constant, subtract};
use crate::identify::result::{Finding, Noise};
use crate::identify::simulate::{fit_of_error, fit_percent, simulate};
use crate::identify::{Estimate, Structure};
use crate::trace::Trace;

/// Least squares of the rows from t₀ of which no sample is missing.
pub(crate) fn least_squares(trace: &Trace, structure: Structure, t0: usize) -> Result<Estimate, Error> {
    let Rows { columns, target } = Rows::of(trace, structure, t0)?;
    let (columns, negative): (Vec<&[f64]>, _) = (columns.iter().map(Vec::as_slice).collect(), structure.na.into());
    let factor = Factor::new(columns.clone(), negative, &target);
    let factor = factor.map_err(|own| unexcited(structure, trace, own.column, &own.partners))?;
    let mut residuals = target.clone();
    subtract(&columns, negative, factor.theta.as_slice(), &mut residuals);
    let error: f64 = residuals.iter().map(|e| e * e).sum();
    let (cofactor, theta) = (factor.cofactor(), factor.theta);
    let (residuals, noise) = (DVector::from_vec(residuals), Noise::Equation);
    let finding = Finding { theta, cofactor, residuals, noise, converged: true, iterations: 1, reflected: 0 };
    let estimate = finding.estimate(&held(trace), structure);
    let simulated = simulate(trace, structure, estimate.theta.as_slice());
    let (measured, simulated): (Vec<f64>, Vec<f64>) =
        trace.y.iter().zip(simulated).filter(|(y, _)| y.is_finite()).unzip();
    Ok(Estimate {
        fit_percent: fit_percent(&measured, &simulated),
        prediction_fit_percent: fit_of_error(error, &target),
        ..estimate
    })
}

/// The rows of which no sample is missing.
struct Rows {
    columns: Vec<Vec<f64>>,
    target: Vec<f64>,
}

impl Rows {
    fn of(trace: &Trace, structure: Structure, t0: usize) -> Result<Self, Error> {
        let constant = constant(structure, 1.0, trace.y.len());
        let columns = Signals::of(trace, &constant).columns(structure);
        let measured = &trace.y[t0..];
        let is_whole = |row: &usize| columns.iter().all(|own| own[*row].is_finite()) && measured[*row].is_finite();
        let rows: Vec<usize> = (0..measured.len()).filter(is_whole).collect();
        let (whole, all, n) = (rows.len(), measured.len(), structure.parameters());
        if whole <= n {
            let problem =
                format!("{whole} of {all} rows miss no sample, for {n} parameters; record more or reduce the order");
            return Err(Error::trace(&trace.id, problem));
        }
        let of = |own: &[f64]| -> Vec<f64> { rows.iter().map(|row| own[*row]).collect() };
        Ok(Self { columns: columns.into_iter().map(of).collect(), target: of(measured) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::{Method, estimate};

    /// y(t) = 1.5 y(t−1) − 0.6 y(t−2) + 0.8 u1(t−1) − 0.3 u2(t−1) without noise.
    fn record(rows: usize) -> Trace {
        let u = |k: usize, prime: usize| ((k * prime) % 97) as f64 / 40.0 - 1.2;
        let mut y = vec![0.0; rows];
        for k in 2..rows {
            y[k] = 1.5 * y[k - 1] - 0.6 * y[k - 2] + 0.8 * u(k - 1, 31) - 0.3 * u(k - 1, 53);
        }
        let [u1, u2] = [31, 53].map(|prime| (0..rows).map(|k| u(k, prime)).collect());
        Trace { id: "r".into(), y, u1, u2, ..Trace::default() }
    }

    const STRUCTURE: Structure = Structure::new(2, 1, 1, 1, 1);

    #[test]
    fn rows_that_miss_a_sample_are_left_out() {
        let mut trace = record(400);
        (trace.y[50], trace.u1[120], trace.u2[120]) = (f64::NAN, f64::NAN, f64::NAN);
        let found = estimate(&trace, STRUCTURE, Method::Ls).expect("most rows");
        let truth = [-1.5, 0.6, 0.8, -0.3];
        // Without noise the parameters are exact but for rounding.
        assert!(found.theta.iter().zip(truth).all(|(p, t)| (p - t).abs() < 1e-10), "{}", found.theta);
        // y(50) is missing in three rows, both inputs of 120 in one.
        assert_eq!((found.rows, found.residuals.len()), (398 - 4, 398 - 4));
        assert!(found.prediction_fit_percent > 99.9 && found.fit_percent > 90.0, "{}", found.fit_percent);
        assert_eq!(found.undetermined(&trace), Vec::<String>::new());
    }

    #[test]
    fn other_methods_name_what_is_missing_and_the_remedy() {
        let mut trace = record(400);
        trace.u1[7] = f64::NAN;
        for method in [Method::Iv, Method::Iv4, Method::Sriv, Method::Sm, Method::Oe, Method::Armax] {
            let problem = estimate(&trace, STRUCTURE, method).expect_err("missing").to_string();
            assert!(problem.starts_with("trace r: u1 misses 1 of 400 samples, the first is 7"), "{problem}");
            assert!(problem.contains("--method ls"), "{problem}");
        }
        trace.y.iter_mut().step_by(3).for_each(|y| *y = f64::NAN);
        let problem = estimate(&trace, STRUCTURE, Method::Ls).expect_err("no row").to_string();
        assert!(problem.contains("0 of 398 rows miss no sample"), "{problem}");
    }
}
