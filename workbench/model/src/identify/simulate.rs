//! Free-run simulation and its fit.

use super::kernel::free_run::FreeRun;
use super::kernel::sums::{distance, spread};
use super::{Structure, refused};
use crate::trace::Trace;

/// Output of the model from the inputs alone; unstable poles are reflected into the unit circle. Starts from zero. If a
/// constant term is estimated, zero is not an operating point; the simulation then starts from the first t₀ measured
/// outputs. Where a sample is missing, the last one goes on.
#[must_use]
pub fn simulate(trace: &Trace, structure: Structure, theta: &[f64]) -> Vec<f64> {
    let mut output = Vec::new();
    if !refused::is_complete(trace) {
        return simulate(&refused::held(trace), structure, theta);
    }
    FreeRun::new(structure, theta).simulate(trace, &mut output);
    output
}

/// Thesis Eq. 3.2: 100 (1 − ‖ŷ − y‖/‖y − mean y‖).
#[must_use]
pub fn fit_percent(measured: &[f64], simulated: &[f64]) -> f64 {
    fit_of_error(distance(measured, simulated), measured)
}

/// Eq. 3.2 from the squared norm ‖ŷ − y‖².
pub(super) fn fit_of_error(error: f64, measured: &[f64]) -> f64 {
    100.0 * (1.0 - (error / spread(measured)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fit_of_truth_and_of_the_mean() {
        let y = [1.0, 2.0, 3.0];
        assert_eq!(fit_percent(&y, &y), 100.0);
        assert_eq!(fit_percent(&y, &[2.0; 3]), 0.0);
    }
}
