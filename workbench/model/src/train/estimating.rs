//! The part of a model that estimates, whose constants are trained before any feature is known.

use super::{Recipe, core_features, estimation, segment, shaft, velocity_choice};
use crate::Error;
use crate::core::Parts;
use crate::trace::labels::LabelledTrace;
use crate::trace::same_interval;

/// The part of a model that estimates, whose constants are trained before any feature is known.
#[expect(missing_debug_implementations, reason = "its parts have none")]
pub struct Estimating {
    /// The recipe with the source of the velocity chosen.
    pub recipe: Recipe,
    /// Its channels, regression and shaft, with their constants.
    pub parts: Parts,
    /// Samples in a segment.
    pub segment: usize,
    /// Sampling interval, s; 0 if unknown.
    pub interval_s: f64,
}

/// Trains the part of a model that estimates.
///
/// # Errors
/// Traces of several rates, or of which no nominal model can be estimated.
pub fn estimating(traces: &[LabelledTrace], classes: &[String], recipe: &Recipe) -> Result<Estimating, Error> {
    check_intervals(traces)?;
    let (segment, recipe) = segment::resolved(traces, recipe);
    let interval_s = traces.iter().find_map(|t| t.trace.interval_s).unwrap_or(0.0);
    let recipe = velocity_choice::resolved(traces, interval_s, &recipe);
    let parts = parts(traces, classes, &recipe, (segment, interval_s))?;
    Ok(Estimating { recipe, parts, segment, interval_s })
}

/// Returns the usual variance of the error of each feature in these traces.
pub fn usual_errors(traces: &[LabelledTrace], classes: &[String], found: &Estimating) -> Result<Vec<f64>, Error> {
    let catalogue = found.recipe.catalogue();
    let (table, ..) = core_features::run(traces, classes, (&found.parts, &catalogue), found.segment)?;
    Ok(table.usual.iter().copied().collect())
}

/// Returns the core's channels, regression and shaft with their trained constants.
fn parts(
    traces: &[LabelledTrace],
    classes: &[String],
    recipe: &Recipe,
    (segment, interval_s): (usize, f64),
) -> Result<Parts, Error> {
    /// Range of the channels, in multiples of the largest magnitude in training: a margin for other conditions.
    const LIMIT: f64 = 10.0;
    let wiring = recipe.wiring(&recipe.columns);
    let estimation = (&recipe.estimation, segment);
    let regression = estimation::regression(traces, classes, (recipe.structure, wiring.signals), estimation)?;
    let shaft = recipe.shaft.as_ref().map(|plan| {
        let sizes = (recipe.estimation.nominal, interval_s);
        shaft::model(traces, sizes, plan, &wiring)
    });
    let mut channels = wiring.core_channels(traces.iter().map(|t| &t.trace), LIMIT)?;
    estimation::guard(&mut channels, wiring.signals, &recipe.estimation)?;
    let averaged = recipe.catalogue().averaged.iter().fold(0, |mask, (_, place)| mask | 1 << place);
    Ok(Parts { channels, regression: Some(regression), shaft: shaft.transpose()?, averaged })
}

/// Returns an error if the sampling intervals of a training set differ: a model is valid for one rate only.
fn check_intervals(traces: &[LabelledTrace]) -> Result<(), Error> {
    let mut known = traces.iter().filter_map(|t| t.trace.interval_s.map(|step| (t.trace.id.as_str(), step)));
    let Some((first, interval)) = known.next() else { return Ok(()) };
    known.try_for_each(|(id, step)| {
        if same_interval(step, interval) {
            return Ok(());
        }
        // Single precision prints without the digits of rounding errors.
        let (step, interval) = (step as f32, interval as f32);
        let problem =
            format!("sampled every {step} s, but {first} every {interval} s; train on one rate (convert --to-hz)");
        Err(Error::trace(id, problem))
    })
}
