//! Batch identification of `A(q) y = B(q) u1 + C(q) u2 [+ constant] + e` in double precision.
//!
//! Parameters are ordered a₁…, b₁…, c₁…, constant; the terms of `a` have + sign on the left side (thesis Eq. 2.4). Sums
//! start at t₀ = [`Structure::depth`], the first sample with a complete regressor.

mod armax;
mod autoregression;
mod external;
pub(crate) mod filters;
mod gauss_newton;
mod instruments;
mod iv;
pub(crate) mod iv4;
pub(crate) mod kernel;
mod ls;
mod output_error;
mod poles;
mod regression;
mod result;
mod robust;
mod simulate;
mod sriv;
mod steiglitz_mcbride;

use crate::Error;
use crate::trace::Trace;
pub use bearing_watch::Structure;

pub use armax::armax;
pub use external::external_instruments;
pub use iv::instrumental_variables;
pub use iv4::iv4;
pub use ls::least_squares;
pub use output_error::output_error;
pub use poles::{poles, reflect_unstable};
pub use result::{Convergence, Estimate, Noise};
pub use robust::robust;
pub use simulate::{fit_percent, simulate};
pub use sriv::sriv;
pub use steiglitz_mcbride::steiglitz_mcbride;

/// How parameters are estimated. What the noise is taken to be decides whether a method is consistent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Method {
    /// Least squares (Eq. 2.17): white equation error
    Ls,
    /// Basic instrumental variables (Eq. 2.22): any noise, not efficient
    Iv,
    /// Instrumental variables from the command of the loop (--instruments): any noise, any feedback
    IvCommand,
    /// The four-stage instrumental-variable method of the source: autoregressive equation error
    Iv4,
    /// Refined instrumental variables (Young): white output noise
    Sriv,
    /// Steiglitz-McBride, the source's output-error method (B.3): white output noise
    Sm,
    /// Least output error by Gauss-Newton, from sm: white output noise
    Oe,
    /// Multi-stage least squares, then Gauss-Newton on the prediction error: moving-average equation error
    Armax,
}

/// Options that apply only to some methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Passes of basic instrumental variables.
    pub passes: usize,
    /// Number of terms of ARMAX's noise polynomial; `None` means na, but at least one.
    pub noise_order: Option<usize>,
}

impl Default for Options {
    fn default() -> Self {
        Self { passes: 3, noise_order: None }
    }
}

/// Estimates one trace with default [`Options`].
///
/// # Errors
/// Fewer rows than parameters, or columns that the signals do not excite. An iteration that does not converge is not an
/// error: see [`Convergence`].
pub fn estimate(trace: &Trace, structure: Structure, method: Method) -> Result<Estimate, Error> {
    estimate_with(trace, structure, method, Options::default())
}

/// Estimates one trace. The command of [`Method::IvCommand`] is the first further column of the trace.
///
/// # Errors
/// The errors of [`estimate`], and a missing command.
pub fn estimate_with(trace: &Trace, structure: Structure, method: Method, options: Options) -> Result<Estimate, Error> {
    match method {
        Method::Ls => least_squares(trace, structure),
        Method::Iv => instrumental_variables(trace, structure, options.passes),
        Method::IvCommand => match trace.further.first() {
            Some(command) => external_instruments(trace, structure, command),
            None => {
                Err(Error::Usage("--method iv-command needs the command: give its channel by --instruments".into()))
            }
        },
        Method::Iv4 => iv4(trace, structure),
        Method::Sriv => sriv(trace, structure),
        Method::Sm => steiglitz_mcbride(trace, structure),
        Method::Oe => output_error(trace, structure),
        Method::Armax => armax(trace, structure, options.noise_order),
    }
}

/// Names and polynomials of a model structure.
pub trait Terms {
    /// Names of the parameters: a1…, b1…, c1…, offset.
    fn names(&self) -> Vec<String>;

    /// A, B and C of a parameter vector, and the constant. A is monic from q⁰; B and C have their delays as leading
    /// zeros.
    fn polynomials(&self, theta: &[f64]) -> ([Vec<f64>; 3], f64);
}

impl Terms for Structure {
    fn names(&self) -> Vec<String> {
        let group = |letter: char, count: u8| (1..=count).map(move |k| format!("{letter}{k}"));
        let offset = self.offset.then(|| "offset".to_string());
        group('a', self.na).chain(group('b', self.nb)).chain(group('c', self.nc)).chain(offset).collect()
    }

    fn polynomials(&self, theta: &[f64]) -> ([Vec<f64>; 3], f64) {
        let Self { na, nb, nc, nkb, nkc, .. } = *self;
        let (a, rest) = theta.split_at(na as usize);
        let (b, rest) = rest.split_at(nb as usize);
        let (c, rest) = rest.split_at(nc as usize);
        let delayed = |delay: u8, terms: &[f64]| [vec![0.0; delay as usize], terms.to_vec()].concat();
        ([[&[1.0], a].concat(), delayed(nkb, b), delayed(nkc, c)], rest.first().copied().unwrap_or(0.0))
    }
}

/// Returns the first usable row t₀ of a record.
fn first_row(structure: Structure, trace: &Trace) -> Result<usize, Error> {
    let (t0, n, samples) = (structure.depth(), structure.parameters(), trace.y.len());
    if structure.terms() == 0 {
        return Err(Error::Usage("--order has no terms; give at least one of na, nb, nc".into()));
    }
    if samples <= t0 + n {
        let problem =
            format!("{samples} samples for {n} parameters from sample {t0} on; record more or reduce the order");
        return Err(Error::trace(&trace.id, problem));
    }
    if trace.y.iter().all(|y| *y == trace.y[0]) {
        return Err(Error::trace(&trace.id, "the output is constant: there is nothing to model; check --y"));
    }
    Ok(t0)
}

/// Error for the parameter whose column is zero or, within rounding, a linear combination of the `partners` before it.
fn unexcited(structure: Structure, trace: &Trace, column: usize, partners: &[usize]) -> Error {
    let names = structure.names();
    let reason = match partners {
        [] => "its column is zero".to_string(),
        some => format!("its column depends on {}", some.iter().map(|&k| &names[k][..]).collect::<Vec<_>>().join(", ")),
    };
    let offset = if structure.offset { ", or leave out --offset" } else { "" };
    let column = &names[column];
    let problem = format!(
        "the signals do not excite parameter {column} ({reason}); use a richer command or a lower order{offset}"
    );
    Error::trace(&trace.id, problem)
}

/// Parses `2,2,2,1,1`.
///
/// # Errors
/// A message that describes the format.
pub fn parse_order(text: &str) -> Result<Structure, String> {
    let wrong = || format!("\"{text}\" is no order; write na,nb,nc,nkb,nkc, e.g. 2,2,2,1,1");
    let trimmed = text.trim().trim_start_matches('[').trim_end_matches(']');
    let numbers = trimmed.split([',', ' ']).filter(|part| !part.is_empty()).map(str::parse::<u8>);
    let numbers: Vec<u8> = numbers.collect::<Result<_, _>>().map_err(|_| wrong())?;
    let numbers: [u8; 5] = numbers.try_into().map_err(|_| wrong())?;
    let order = Structure::from_orders(numbers);
    if order.terms() == 0 {
        return Err(format!("order {text} has no terms; give at least one of na, nb, nc"));
    }
    if numbers.iter().any(|&x| x > 32) {
        return Err(format!("order {text} has a number above 32; the detector cannot hold it"));
    }
    Ok(order)
}
