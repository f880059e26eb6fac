//! Batch identification of `A(q) y = B(q) u1 + C(q) u2 [+ constant] + e` in double precision.
//!
//! Parameters are ordered a₁…, b₁…, c₁…, constant; the terms of `a` have + sign on the left side (thesis Eq. 2.4). Sums
//! start at t₀ = [`Structure::depth`], the first sample with a complete regressor. A missing sample is NaN: least
//! squares leave out the rows that it is in, and the other methods, which filter or simulate the signals, refuse the
//! trace.

mod factor;
pub(crate) mod filters;
mod gauss_newton;
pub(crate) mod kernel;
pub(crate) mod methods;
mod poles;
mod refused;
mod regression;
mod result;
mod simulate;
mod terms;

use crate::Error;
use crate::trace::Trace;
pub use bearing_watch::plan::Structure;

pub use methods::armax::armax;
pub use methods::external::external_instruments;
pub use methods::iv::instrumental_variables;
pub use methods::iv4::iv4;
pub use methods::ls::least_squares;
pub use methods::output_error::output_error;
pub use methods::robust::robust;
pub use methods::sriv::sriv;
pub use methods::steiglitz_mcbride::steiglitz_mcbride;
pub use poles::{poles, reflect_unstable};
pub use result::{Convergence, Estimate, Noise};
pub use simulate::{fit_percent, simulate};
pub use terms::{Terms, parse_order};

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
/// Fewer rows than parameters, columns that the signals do not excite, or missing samples. An iteration that does not
/// converge is not an error: see [`Convergence`].
pub fn estimate(trace: &Trace, structure: Structure, method: Method) -> Result<Estimate, Error> {
    estimate_with(trace, structure, method, Options::default())
}

/// Estimates one trace. The command of [`Method::IvCommand`] is the first further column of the trace.
///
/// # Errors
/// The errors of [`estimate`], and a missing command.
pub fn estimate_with(trace: &Trace, structure: Structure, method: Method, options: Options) -> Result<Estimate, Error> {
    if method != Method::Ls {
        refused::complete_row(structure, trace)?;
    }
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
