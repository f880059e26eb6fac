//! Labelled traces → a trained model.
//!
//! The steps are features, their projection, and the discriminant; the result is then converted to the form that the
//! core runs ([`Trained`]). If the core computes batch least squares in single precision, the features are those of
//! batch least squares in double precision, else those that the core estimates on the training traces. A feature
//! without a result is missing in its row, and features of the torque balance have errors of known variance; means and
//! covariances account for both (`moments`). Rows without any of the chosen features are left out. The quality of the
//! model is measured by running the core on other traces ([`crate::evaluate`]), not here.

mod automatic;
mod bench;
pub mod c_header;
mod c_text;
mod cell;
mod compose;
mod contamination;
mod core_features;
mod core_form;
pub mod covariance;
mod covariates;
mod cross_validation;
mod dependence;
pub mod directions;
pub mod discriminant;
mod drive_header;
mod estimates;
mod estimating;
mod estimation;
pub mod export;
mod fewer_harmonics;
mod filters;
mod fit;
mod folds;
mod forward;
pub mod front_end_header;
pub mod front_end_source;
pub mod label;
mod lags;
mod largest_change;
mod least_covariance;
mod left_out;
mod matrix;
pub mod moments;
mod nominal;
pub mod novelty;
mod pieces;
pub mod projection;
mod pulses;
mod ranking;
mod recipe;
mod reference_instruments;
#[cfg(test)]
mod reference_values;
mod refused;
mod rotor;
mod scores;
mod segment;
mod shaft;
mod shaft_plan;
mod shrinkage;
mod shrinkage_search;
mod sight;
mod sizes;
pub mod statistics;
mod table;
mod trained;
mod velocity_choice;
mod velocity_source;

use crate::Error;
use crate::trace::labels::LabelledTrace;

pub use automatic::{Automatic, Detected, Rival, Temperature};
pub use compose::compose;
pub use contamination::Doubted;
pub use core_features::row as features_of;
pub use covariates::{Coefficient, Explained, Explaining};
pub use cross_validation::predict;
pub use dependence::Dependence;
pub use discriminant::GaussianClasses;
use estimates::Estimates;
pub use estimating::{Estimating, estimating, usual_errors};
pub use estimation::Estimation;
pub use folds::{Candidates, Folds, Validation};
pub use forward::Forward;
pub use left_out::LeftOut;
pub use matrix::{Matrix, RowClassifier, RowGate};
pub use novelty::{ACCEPTABLE, AlarmInterval, Alarms, Watch};
pub use projection::{Keep, ProjectionKind};
pub use ranking::{Gain, Ranked, Ranking, rank};
pub use recipe::Recipe;
pub use rotor::{NextToRotor, Remedy, compared_turns, next_to_rotor};
pub use scores::{Bin, Decomposition, Prediction, Score, Scores};
pub use shaft_plan::ShaftPlan;
pub use shrinkage::{Shrink, Shrinkage};
pub use shrinkage_search::{Choice, GridPoint};
pub use sight::{OrderSight, Sight};
pub use statistics::ClassStatistics;
pub use table::{AffineMap, FeatureTable};
pub use trained::Trained;
pub use velocity_source::VelocitySource;

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
