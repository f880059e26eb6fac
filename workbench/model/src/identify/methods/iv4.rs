//! The four-stage instrumental-variable method (thesis §2.1.2, B.1), used for all results of the source.
//!
//! Least squares → IV with instruments simulated by that model → AR(n) model L(q) of the residuals
//! `A y − B u1 − C u2` → y, u1, u2 and instruments simulated by the IV model, all filtered by L → IV again.
//!
//! ```text
//! cov θ = σ² (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹ on the filtered data        (1)  long records
//! ```
//!
//! All sums start at t₀; filters start from zero. With several traces each sum runs over all traces; filters and
//! simulations restart at the beginning of each trace.

use nalgebra::DVector;

use super::instruments::{System, autoregression};
use super::iv::{is_stable, lost};
use super::ls;
use crate::Error;
use crate::identify::kernel::filter::fir;
use crate::identify::kernel::free_run::FreeRun;
use crate::identify::kernel::triangle::Triangle;
use crate::identify::regression::{Signals, lags};
use crate::identify::result::{Finding, Noise};
use crate::identify::{Estimate, Structure};
use crate::trace::Trace;

/// Estimates by iv4.
///
/// # Errors
/// The errors of [`least_squares`](crate::identify::least_squares); also instruments that do not determine the
/// parameters.
pub fn iv4(trace: &Trace, structure: Structure) -> Result<Estimate, Error> {
    let first = ls::parameters(trace, structure)?;
    let mut scratch = Scratch::default();
    let stages = four_stage(std::slice::from_ref(trace), structure, first.as_slice(), &mut scratch);
    let Stages { second, shaping, system, theta } = stages.map_err(|failure| match failure {
        Failure::Undetermined(column) => lost(structure, trace, column),
        Failure::Regular => Error::trace(&trace.id, format!("{REGULAR}; record more, or use --method ls")),
    })?;
    let inverse = system.inverse().ok_or_else(|| lost(structure, trace, structure.parameters() - 1))?;
    let cofactor = &inverse * inverse.transpose(); // (1)
    let residuals = DVector::from_vec(scratch.residuals.swap_remove(0));
    let unstable = [first.as_slice(), &second].into_iter().filter(|theta| !is_stable(structure, theta));
    let (reflected, noise) = (unstable.count(), Noise::Autoregressive(shaping));
    let finding = Finding { theta, cofactor, residuals, noise, converged: true, iterations: 2, reflected };
    Ok(finding.estimate(trace, structure))
}

const REGULAR: &str = "the residuals are too few or too regular for a noise model";

/// Reason why iv4 has no estimate.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Failure {
    /// The instruments do not determine the parameters; index of the first.
    Undetermined(usize),
    /// No AR model can be fitted to the residuals.
    Regular,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::Undetermined(_) => "the instruments do not determine the parameters",
            Self::Regular => REGULAR,
        })
    }
}

/// Results of the stages.
pub(crate) struct Stages {
    /// Parameters of the second stage.
    second: Vec<f64>,
    /// Coefficients of L, including the leading 1.
    shaping: Vec<f64>,
    /// The linear system of the last stage.
    system: System,
    pub(crate) theta: DVector<f64>,
}

/// Working memory of [`four_stage`], one entry per trace.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    triangle: Triangle,
    block: Vec<f64>,
    /// Filtered y, u1, u2.
    filtered: Vec<[Vec<f64>; 3]>,
    instruments: Vec<Vec<f64>>,
    constant: Vec<f64>,
    work: Vec<f64>,
    /// Residuals of the last stage, from t₀.
    pub(crate) residuals: Vec<Vec<f64>>,
}

/// Stages two to four, starting from the least-squares parameters.
///
/// # Errors
/// Instruments that do not determine the parameters, or residuals to which no noise model can be fitted.
pub(crate) fn four_stage(
    traces: &[Trace],
    structure: Structure,
    first: &[f64],
    scratch: &mut Scratch,
) -> Result<Stages, Failure> {
    let Scratch { triangle, block, filtered, instruments, constant, work, residuals } = scratch;
    filtered.resize_with(traces.len(), Default::default);
    instruments.resize_with(traces.len(), Vec::new);
    residuals.resize_with(traces.len(), Vec::new);
    if structure.offset {
        constant.clear();
        constant.resize(traces.iter().map(|trace| trace.y.len()).max().unwrap_or(0), 1.0);
    }

    let model = FreeRun::new(structure, first);
    for (trace, instruments) in traces.iter().zip(instruments.iter_mut()) {
        model.simulate(trace, instruments);
    }
    let measured: Vec<Signals> = traces.iter().map(|trace| Signals::of(trace, constant)).collect();
    let (_, second) = stage(&measured, structure, instruments, triangle, block)?;
    for (signals, residuals) in measured.iter().zip(residuals.iter_mut()) {
        signals.residuals(structure, second.as_slice(), residuals);
    }

    let noise: Vec<&[f64]> = residuals.iter().map(Vec::as_slice).collect();
    let shaping = autoregression(&noise, structure.parameters()).ok_or(Failure::Regular)?;
    let model = FreeRun::new(structure, second.as_slice());
    for ((trace, [y, u1, u2]), instruments) in traces.iter().zip(filtered.iter_mut()).zip(instruments.iter_mut()) {
        fir(&shaping, &trace.y, y);
        fir(&shaping, &trace.u1, u1);
        fir(&shaping, &trace.u2, u2);
        model.simulate(trace, work);
        fir(&shaping, work, instruments);
    }
    constant.fill(shaping.iter().sum());

    let filtered: Vec<Signals> =
        filtered.iter().map(|[y, u1, u2]| Signals { y, u1, u2, constant }).take(traces.len()).collect();
    let (system, theta) = stage(&filtered, structure, instruments, triangle, block)?;
    for (signals, residuals) in filtered.iter().zip(residuals.iter_mut()) {
        signals.residuals(structure, theta.as_slice(), residuals);
    }
    Ok(Stages { second: second.as_slice().to_vec(), shaping, system, theta })
}

/// One stage of IV: Z has the lags of the instruments in place of those of y.
fn stage(
    signals: &[Signals],
    structure: Structure,
    instruments: &[Vec<f64>],
    triangle: &mut Triangle,
    block: &mut Vec<f64>,
) -> Result<(System, DVector<f64>), Failure> {
    let (t0, n, na) = (structure.depth(), structure.parameters(), structure.na);
    triangle.reset(n, n + usize::from(na) + 1);
    for (signals, instruments) in signals.iter().zip(instruments) {
        let mut columns = signals.columns(structure);
        // The lags of y follow those of Z; they are transformed but not eliminated.
        columns.rotate_left(na.into());
        columns.splice(n - usize::from(na)..n - usize::from(na), lags(instruments, t0, 1, na));
        columns.push(&signals.y[t0..]);
        triangle.absorb_columns(&columns, block);
    }
    let system = System::new(triangle, na.into(), true).map_err(Failure::Undetermined)?;
    let theta = system.theta().ok_or(Failure::Undetermined(n - 1))?;
    Ok((system, theta))
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::identify::result::tests::trace;
    use crate::identify::simulate::simulate;

    /// (ZᵀX) θ = Zᵀ y of rows 1 …, with the lags of y, u1, u2, and of z in place of y in Z.
    fn by_normal_equations(z: &[f64], [y, u1, u2]: &[Vec<f64>; 3]) -> DVector<f64> {
        let columns = |first: &[f64]| {
            let signals = [first, u1, u2];
            DMatrix::from_fn(y.len() - 1, 3, |row, k| if k == 0 { -signals[k][row] } else { signals[k][row] })
        };
        let (z, x) = (columns(z), columns(y));
        let right = z.tr_mul(&DVector::from_column_slice(&y[1..]));
        z.tr_mul(&x).lu().solve(&right).expect("regular")
    }

    #[test]
    fn the_four_stages_are_those_of_normal_equations() {
        let (trace, structure) = (trace(400, 0.0), Structure::new(1, 1, 1, 1, 1));
        let found = iv4(&trace, structure).expect("excited");
        let Noise::Autoregressive(shaping) = &found.noise else { panic!("{:?}", found.noise) };
        let filtered = |x: &[f64]| -> Vec<f64> {
            let sum = |t: usize| shaping.iter().zip(x[..=t].iter().rev()).map(|(l, x)| l * x).sum();
            (0..x.len()).map(sum).collect()
        };
        let simulated = |theta: &DVector<f64>| simulate(&trace, structure, theta.as_slice());
        let measured = [trace.y.clone(), trace.u1.clone(), trace.u2.clone()];
        let first = by_normal_equations(&trace.y, &measured);
        let second = by_normal_equations(&simulated(&first), &measured);
        let last = by_normal_equations(&filtered(&simulated(&second)), &measured.each_ref().map(|x| filtered(x)));
        // Rounding, squared by the normal equations.
        assert!((&found.theta - &last).amax() < 1e-10, "{} {last}", found.theta);
    }
}
