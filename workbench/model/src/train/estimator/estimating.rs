//! The part of a model that estimates, whose constants are trained before any feature is known.
//!
//! Segments of which no length is given: a trace is one segment, unless it is much longer than a verdict needs: then it
//! is cut into equal segments of at least ten seconds, a hundred turns and ten thousand samples. They have enough rows
//! for a feature's error to be small beside its spread between records, enough turns to tell the orders of a bearing
//! apart, and the drive has a verdict long before the end of such a trace. Without fading memory a segment has at most
//! [`MAX_SEGMENT_ROWS`].
//!
//! The source of the velocity that is better for a drive: its channel, or the differences of the angle. The noise of
//! the velocity, differentiated, hides small defects. A resolver resolves 2¹⁴ steps of a turn, whose differences have
//! less noise than most velocity channels; a channel is better if it is filtered, if its samples are averages, or if
//! the sampling instants vary. Both are tried with the core on healthy traces: the cost of [`super::filters`] is the
//! deviation of the orders' amplitudes.
//!
//! Without a load sensor most of that deviation is the load's, whatever the source, and a source whose noise makes the
//! residual smaller makes the defect smaller too. Then the second differences of both tell which has less noise.

use std::f64::consts::TAU;

use bearing_watch::model::{MAX_SEGMENT_ROWS, MAX_SEGMENT_SAMPLES};

use super::velocity_source::velocity_noise;
use super::{filters, period, regression, shaft};
use crate::Error;
use crate::core::Parts;
use crate::trace::labels::LabelledTrace;
use crate::trace::{MotionTrace, median, same_interval};
use crate::train::rows::core_features;
use crate::train::{Estimation, Recipe, ShaftPlan, VelocitySource};

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
    let (segment, recipe) = with_segment(traces, recipe);
    let interval_s = traces.iter().find_map(|t| t.trace.interval_s).unwrap_or(0.0);
    let recipe = with_axis(traces, interval_s, &with_velocity(traces, interval_s, &recipe));
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
    let regression = regression::regression(traces, classes, (recipe.structure, wiring.signals), estimation)?;
    let shaft = recipe.shaft.as_ref().map(|plan| {
        let sizes = (recipe.estimation.nominal, interval_s);
        shaft::model(traces, sizes, plan, &wiring)
    });
    let mut channels = wiring.core_channels(traces.iter().map(|t| &t.trace), LIMIT)?;
    regression::guard(&mut channels, wiring.signals, &recipe.estimation)?;
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

const SECONDS: f64 = 10.0;
const TURNS: f64 = 100.0;
const SAMPLES: f64 = 10_000.0;

/// Returns the number of samples in a segment, and the recipe with it if it was not given and traces are longer.
pub(crate) fn with_segment(traces: &[LabelledTrace], recipe: &Recipe) -> (usize, Recipe) {
    if let Some(samples) = recipe.estimation.segment {
        return (samples, recipe.clone());
    }
    let longest = traces.iter().map(|t| t.trace.y.len()).max().unwrap_or(0);
    let most = recipe.estimation.memory.map_or(MAX_SEGMENT_ROWS, |_| MAX_SEGMENT_SAMPLES) as usize;
    let samples = longest / (longest / least(traces)).max(longest.div_ceil(most)).max(1);
    let segment = (samples < longest).then_some(samples);
    (samples, Recipe { estimation: Estimation { segment, ..recipe.estimation.clone() }, ..recipe.clone() })
}

/// Returns the fewest samples of a part of a trace.
fn least(traces: &[LabelledTrace]) -> usize {
    let interval_s = traces.iter().find_map(|t| t.trace.interval_s).unwrap_or(0.0);
    let of_time = if interval_s > 0.0 { SECONDS / interval_s } else { 0.0 };
    let speeds: Vec<f64> = traces.iter().filter_map(mean_speed).collect();
    let turns_a_sample = if speeds.is_empty() { 0.0 } else { median(speeds) * interval_s / TAU };
    let of_turns = if turns_a_sample > 0.0 { TURNS / turns_a_sample } else { 0.0 };
    let least = SAMPLES.max(of_time).max(of_turns);
    if least < f64::from(MAX_SEGMENT_ROWS) { least.ceil() as usize } else { MAX_SEGMENT_ROWS as usize }
}

/// Mean magnitude of a trace's velocity, rad/s.
fn mean_speed(labelled: &LabelledTrace) -> Option<f64> {
    let motion = labelled.trace.motion.as_ref()?;
    let speeds = || motion.velocity_rad_s.iter().copied().filter(|speed| speed.is_finite());
    let count = speeds().count();
    (count > 0).then(|| speeds().map(f64::abs).sum::<f64>() / count as f64)
}

/// Returns start and end of each piece of a trace with `length` samples.
pub(crate) fn spans(length: usize, samples: usize) -> impl Iterator<Item = (usize, usize)> {
    let ends = (0..length).step_by(samples.max(1)).map(move |start| (start, (start + samples).min(length)));
    ends.filter(move |(start, end)| 2 * (end - start) > samples)
}

/// The angle has to be better by this factor, so that the choice does not depend on chance.
const BETTER: f64 = 0.9;

/// Returns the recipe with the source of the velocity chosen.
fn with_velocity(traces: &[LabelledTrace], interval_s: f64, recipe: &Recipe) -> Recipe {
    let Some(plan) = recipe.shaft.as_ref().filter(|plan| plan.velocity == VelocitySource::Best) else {
        return recipe.clone();
    };
    let plan_of = |velocity| ShaftPlan { velocity, ..plan.clone() };
    let with = |velocity| Recipe { shaft: Some(plan_of(velocity)), ..recipe.clone() };
    if recipe.columns.shaft.as_ref().is_some_and(|shaft| shaft.velocity.is_none()) {
        return with(VelocitySource::Angle);
    }
    if recipe.averages_velocity() || plan.orders.is_empty() {
        return with(VelocitySource::Channel);
    }
    let nominal = recipe.estimation.nominal;
    let healthy = traces.iter().filter(|own| own.class == nominal);
    let angle_is_better = if plan.load {
        let healthy: Vec<LabelledTrace> = healthy.take(filters::MOST_COMPARED).cloned().collect();
        let cost = |velocity| {
            let wiring = with(velocity).wiring(&recipe.columns);
            shaft::cost(&healthy, (nominal, interval_s), &plan_of(velocity), &wiring)
        };
        // A source with which training fails is not chosen; the other one tells why, if both fail.
        cost(VelocitySource::Angle)
            .is_ok_and(|angle| cost(VelocitySource::Channel).map_or(true, |channel| angle < channel + BETTER.ln()))
    } else {
        let motions: Vec<&MotionTrace> = healthy.filter_map(|own| own.trace.motion.as_ref()).collect();
        let noise = |velocity: VelocitySource| {
            let own: Vec<_> = motions.iter().map(|motion| velocity.motion(motion, interval_s)).collect();
            velocity_noise(&own.iter().map(AsRef::as_ref).collect::<Vec<_>>())
        };
        noise(VelocitySource::Angle) < BETTER * noise(VelocitySource::Channel)
    };
    with(if angle_is_better { VelocitySource::Angle } else { VelocitySource::Channel })
}

/// Returns the recipe with what the healthy traces say of an axis.
fn with_axis(traces: &[LabelledTrace], interval_s: f64, recipe: &Recipe) -> Recipe {
    let Some(plan) = recipe.shaft.as_ref().filter(|plan| !plan.load) else { return recipe.clone() };
    let healthy = traces.iter().filter(|own| own.class == recipe.estimation.nominal);
    let motions = healthy.filter_map(|own| own.trace.motion.as_ref());
    let motions: Vec<_> = motions.map(|motion| plan.velocity.motion(motion, interval_s)).collect();
    let healthy: Vec<&MotionTrace> = motions.iter().map(AsRef::as_ref).collect();
    let axis = period::of(plan, &healthy, interval_s);
    Recipe { shaft: Some(ShaftPlan { axis, ..plan.clone() }), ..recipe.clone() }
}

#[cfg(test)]
mod tests {
    use crate::identify::Structure;
    use crate::trace::{MotionTrace, Trace};

    use super::*;

    /// Returns the samples in a segment of traces at 500 Hz with these numbers of samples, and what the recipe has
    /// then.
    fn of(samples: &[usize], velocity_rad_s: f64) -> (usize, Option<usize>) {
        let trace = |&n: &usize| {
            let motion = MotionTrace { velocity_rad_s: vec![velocity_rad_s; n], ..MotionTrace::default() };
            let trace = Trace { interval_s: Some(0.002), y: vec![0.0; n], motion: Some(motion), ..Trace::default() };
            LabelledTrace { trace, class: 0 }
        };
        let traces: Vec<LabelledTrace> = samples.iter().map(trace).collect();
        let recipe = Recipe::new(Structure::new(1, 1, 1, 1, 1));
        let (samples, recipe) = with_segment(&traces, &recipe);
        (samples, recipe.estimation.segment)
    }

    #[test]
    fn long_traces_are_cut_into_equal_parts() {
        // Less than two parts of 10 000 samples: the whole trace.
        assert_eq!(of(&[5000, 4000], 40.0), (5000, None));
        assert_eq!(of(&[19_999], 40.0), (19_999, None));
        // 150 000 samples are 15 parts; a shorter trace is cut as well.
        assert_eq!(of(&[150_000, 30_000], 40.0), (10_000, Some(10_000)));
        assert_eq!(of(&[25_000], 40.0), (12_500, Some(12_500)));
        // At 2 rad/s a hundred turns take 314 s, 157 080 samples: more than the core sums.
        assert_eq!(of(&[100_000], 2.0), (100_000, None));
        assert_eq!(of(&[150_000], 2.0), (75_000, Some(75_000)));
        assert_eq!(of(&[290_000], 2.0), (96_666, Some(96_666)));
        assert_eq!(of(&[], 2.0), (0, None));
    }
}
