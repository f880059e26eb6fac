//! Labelled traces → a trained model.
//!
//! The steps are features, their projection, and the discriminant; the result is then converted to the form that the
//! core runs ([`Trained`]). If the core computes batch least squares in single precision, the features are those of
//! batch least squares in double precision, else those that the core estimates on the training traces. A feature
//! without a result is missing in its row, and features of the torque balance have errors of known variance; means and
//! covariances account for both (`moments`). Rows without any of the chosen features are left out. The quality of the
//! model is measured by running the core on other traces ([`crate::evaluate`]), not here.

mod automatic;
pub(crate) mod classifier;
pub mod directions;
pub(crate) mod distribution;
mod estimates;
pub(crate) mod estimator;
pub(crate) mod model;
pub mod novelty;
mod recipe;
pub(crate) mod rows;
pub(crate) mod sources;

use crate::Error;
use crate::trace::labels::LabelledTrace;

pub use automatic::{Automatic, Detected, Rival, Temperature};
pub use classifier::{
    Bin, Choice, Decomposition, Forward, Gain, GaussianClasses, GridPoint, Keep, Matrix, Prediction, ProjectionKind,
    Ranked, Ranking, RowClassifier, RowGate, Score, Scores, Shrink, Shrinkage, discriminant, predict, projection, rank,
};
pub use distribution::{ClassStatistics, covariance, moments, statistics};
use estimates::Estimates;
pub use estimator::{
    Axis, Estimating, Estimation, NextToRotor, Remedy, ShaftPlan, VelocitySource, Weight, compared_turns, estimating,
    next_to_rotor, usual_errors, weight_in,
};
pub use model::{OrderSight, Sight, Trained, compose, label};
pub use novelty::{ACCEPTABLE, AlarmInterval, Alarms, Watch};
pub use recipe::Recipe;
pub use rows::{
    AffineMap, Candidates, Coefficient, Dependence, Doubted, Explained, Explaining, FeatureTable, Folds, LeftOut,
    Validation, features_of,
};
pub use sources::{c_header, export, front_end_header, front_end_source};

/// Judges which of the covariates of a recipe, means of temperatures, explain the features of healthy traces.
///
/// # Errors
/// As [`train`].
pub fn temperatures(traces: &[LabelledTrace], classes: &[String], recipe: &Recipe) -> Result<Vec<Temperature>, Error> {
    let mut estimates = Estimates::of(traces, classes, recipe)?;
    let watched = automatic::watched(&estimates);
    estimates.take_runs(&watched)?;
    automatic::temperature::judged(&estimates)
}

/// Trains on prepared traces.
///
/// # Errors
/// Estimation errors, if they leave fewer than two traces of a class; fewer than two classes, unless the only one is
/// the healthy one; a class without traces; features that are constant or collinear within classes; priors or costs
/// that do not match the classes.
pub fn train(traces: &[LabelledTrace], classes: &[String], recipe: &Recipe) -> Result<Trained, Error> {
    let mut estimates = Estimates::of(traces, classes, recipe)?;
    let watched = if recipe.automatic { automatic::watched(&estimates) } else { estimates.chosen()? };
    let dependence = estimates.take_runs(&watched)?;
    let trained = || {
        if !recipe.automatic {
            return estimates.train(&estimates.recipe);
        }
        let (chosen, why) = automatic::choose(&estimates)?;
        Ok(Trained { automatic: Some(why), ..estimates.train(&chosen)? })
    };
    match (trained(), &dependence) {
        (Ok(trained), _) => {
            let sight = estimates.sight(&trained)?;
            Ok(Trained { dependence, sight, ..trained })
        }
        (Err(Error::Training(problem)), Some(found)) => Err(Error::Training(format!("{}; {problem}", found.line()))),
        (Err(problem), _) => Err(problem),
    }
}
