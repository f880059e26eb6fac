//! Structure selection: scores every structure `[na nb nc nkb nkc]` of a grid on given traces.
//!
//! ```text
//! θ      estimated from all training traces together, each from its own first complete row t₀
//! fit    Eq. 3.2 of the free-run simulation, mean over the validation traces, %
//! AIC    ln V + 2 d/N,   MDL   ln V + d ln N/N,   V = Σe²/N on the training rows, d parameters      (1)
//! ```
//!
//! The fit measures simulation on traces that were not used for estimation. AIC and MDL measure prediction on the
//! traces used for estimation and penalise the number of parameters instead. For iv4, e is the residual after its noise
//! filter. The start of the simulation and unstable poles are treated as in [`crate::identify`]; the estimates are the
//! same within rounding.
//!
//! Least squares factors the widest regressor once, O(N·M²); each structure then costs a triangularisation of a few
//! columns and one simulation (a few µs plus N·(n + latency) operations). Structures are processed in parallel.

mod grid;
mod shared;

use rayon::prelude::*;

use crate::Error;
use crate::identify::kernel::free_run::FreeRun;
use crate::identify::kernel::sums::{distance, dot, spread};
use crate::identify::methods::iv4::{self, four_stage};
use crate::identify::{Structure, Terms};
use crate::trace::Trace;
use shared::{Shared, Solution};

pub use grid::Grid;

/// How the structures are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Estimator {
    /// Least squares.
    Ls,
    /// The four-stage instrumental-variable method.
    Iv4,
}

/// An estimate before it is scored.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The estimated structure.
    pub structure: Structure,
    /// a₁…, b₁…, c₁…, constant.
    pub theta: Vec<f64>,
    /// Σe² of (1).
    pub residual_sum: f64,
    /// N of (1).
    pub rows: usize,
}

/// A structure with its scores.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The estimate.
    pub fitted: Fitted,
    /// Mean fit over the validation traces, %.
    pub fit_percent: f64,
    /// Whether every pole lies inside or on the unit circle; otherwise the fit is that of the reflected poles.
    pub stable: bool,
}

/// A structure that cannot be estimated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The structure.
    pub structure: Structure,
    /// The reason, in a few words.
    pub reason: String,
}

/// All structures of a search.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// Scored structures, in the given order.
    pub candidates: Vec<Candidate>,
    /// Structures without an estimate.
    pub refused: Vec<Refusal>,
}

impl Fitted {
    /// d of (1).
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.theta.len()
    }

    /// σ² with N − d degrees of freedom, as [`crate::identify::Estimate::variance`].
    #[must_use]
    pub fn variance(&self) -> f64 {
        self.residual_sum / (self.rows - self.parameters()) as f64
    }

    /// Akaike's criterion of (1).
    #[must_use]
    pub fn aic(&self) -> f64 {
        self.log_loss() + 2.0 * self.parameters() as f64 / self.rows as f64
    }

    /// Rissanen's minimum description length of (1).
    #[must_use]
    pub fn mdl(&self) -> f64 {
        let rows = self.rows as f64;
        self.log_loss() + self.parameters() as f64 * rows.ln() / rows
    }

    fn log_loss(&self) -> f64 {
        (self.residual_sum / self.rows as f64).ln()
    }
}

impl Search {
    /// The structure of best fit; if fits are equal, the one with fewer parameters.
    #[must_use]
    pub fn best_fit(&self) -> Option<&Candidate> {
        least(self.candidates.iter(), |c| -c.fit_percent)
    }

    /// The structure of least AIC.
    #[must_use]
    pub fn best_aic(&self) -> Option<&Candidate> {
        least(self.candidates.iter(), |c| c.fitted.aic())
    }

    /// The structure of least MDL.
    #[must_use]
    pub fn best_mdl(&self) -> Option<&Candidate> {
        least(self.candidates.iter(), |c| c.fitted.mdl())
    }

    /// The structure of best fit for each number of parameters, fewest first.
    #[must_use]
    pub fn best_by_count(&self) -> Vec<&Candidate> {
        let most = self.candidates.iter().map(|c| c.fitted.parameters()).max().unwrap_or(0);
        let of = |d: usize| self.candidates.iter().filter(move |c| c.fitted.parameters() == d);
        (1..=most).filter_map(|d| least(of(d), |c| -c.fit_percent)).collect()
    }

    /// The candidate of a structure.
    #[must_use]
    pub fn find(&self, structure: Structure) -> Option<&Candidate> {
        self.candidates.iter().find(|c| c.fitted.structure == structure)
    }

    /// Rank by fit, from 1.
    #[must_use]
    pub fn rank(&self, fit_percent: f64) -> usize {
        1 + self.candidates.iter().filter(|c| c.fit_percent > fit_percent).count()
    }
}

fn least<'a>(candidates: impl Iterator<Item = &'a Candidate>, key: fn(&Candidate) -> f64) -> Option<&'a Candidate> {
    candidates.min_by(|a, b| key(a).total_cmp(&key(b)).then_with(|| a.fitted.parameters().cmp(&b.fitted.parameters())))
}

/// Estimates every structure on the training traces and scores it on the validation traces.
///
/// # Errors
/// No structure or no trace; a trace shorter than the deepest structure requires, or with a constant signal.
pub fn search(
    train: &[Trace],
    validate: &[Trace],
    structures: &[Structure],
    estimator: Estimator,
) -> Result<Search, Error> {
    grid::check(train, validate, structures)?;
    let spreads: Vec<f64> = validate.iter().map(|trace| spread(&trace.y)).collect();
    let outcomes = each(train, structures, estimator, |fitted, output| {
        let model = FreeRun::new(fitted.structure, &fitted.theta);
        let mut sum = 0.0;
        for (trace, spread) in validate.iter().zip(&spreads) {
            model.simulate(trace, output);
            sum += 100.0 * (1.0 - (distance(&trace.y, output) / spread).sqrt());
        }
        let fit_percent = sum / validate.len() as f64;
        fit_percent.is_finite().then_some(Candidate { fitted, fit_percent, stable: model.stable })
    });
    let mut search = Search::default();
    for (outcome, &structure) in outcomes.into_iter().zip(structures) {
        match outcome {
            Ok(Some(candidate)) => search.candidates.push(candidate),
            Ok(None) => search.refused.push(Refusal { structure, reason: "its simulation has no finite fit".into() }),
            Err(reason) => search.refused.push(Refusal { structure, reason }),
        }
    }
    Ok(search)
}

/// Estimates every structure on the training traces without scoring it; the error of a structure is the reason why it
/// has no estimate.
///
/// # Errors
/// The errors of [`search`].
pub fn estimate_all(
    train: &[Trace],
    structures: &[Structure],
    estimator: Estimator,
) -> Result<Vec<Result<Fitted, String>>, Error> {
    grid::check(train, train, structures)?;
    Ok(each(train, structures, estimator, |fitted, _| fitted))
}

/// Estimates every structure, and passes each estimate and a buffer of the thread to `then`.
fn each<T: Send>(
    train: &[Trace],
    structures: &[Structure],
    estimator: Estimator,
    then: impl Fn(Fitted, &mut Vec<f64>) -> T + Sync,
) -> Vec<Result<T, String>> {
    let shared = Shared::new(train, structures);
    let memory = || (shared::Scratch::default(), iv4::Scratch::default(), Vec::new());
    let one = |(small, large, output): &mut (shared::Scratch, iv4::Scratch, Vec<f64>), &structure: &Structure| {
        let unexcited = |column: usize| format!("the signals do not excite {}", structure.names()[column]);
        let mut solution = shared.solve(structure, small).map_err(unexcited)?;
        if estimator == Estimator::Iv4 {
            let stages = four_stage(train, structure, &solution.theta, large).map_err(|failure| failure.to_string())?;
            solution.theta = stages.theta.as_slice().to_vec();
            solution.residual_sum = large.residuals.iter().map(|e| dot(e, e)).sum();
        }
        let Solution { theta, residual_sum, rows } = solution;
        Ok(then(Fitted { structure, theta, residual_sum, rows }, output))
    };
    if let [structure] = structures {
        // Starting other threads would take as long as the estimation itself.
        return vec![one(&mut memory(), structure)];
    }
    structures.par_iter().map_init(memory, one).collect()
}
