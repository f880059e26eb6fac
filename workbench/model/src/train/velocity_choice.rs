//! Which source of the velocity is better for a drive: its channel, or the differences of the angle.
//!
//! The noise of the velocity, differentiated, hides small defects. A resolver resolves 2¹⁴ steps of a turn, whose
//! differences have less noise than most velocity channels; a channel is better if it is filtered, if its samples are
//! averages, or if the sampling instants vary. Both are tried with the core on healthy traces: the cost of
//! [`super::filters`] is the deviation of the orders' amplitudes.
//!
//! Without a load sensor most of that deviation is the load's, whatever the source, and a source whose noise makes the
//! residual smaller makes the defect smaller too. Then the second differences of both tell which has less noise.

use super::{Recipe, ShaftPlan, VelocitySource, filters, shaft};
use crate::trace::MotionTrace;
use crate::trace::labels::LabelledTrace;

/// The angle has to be better by this factor, so that the choice does not depend on chance.
const BETTER: f64 = 0.9;

/// Returns the recipe with the source of the velocity chosen.
pub(super) fn resolved(traces: &[LabelledTrace], interval_s: f64, recipe: &Recipe) -> Recipe {
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
            shaft::velocity_noise(&own.iter().map(AsRef::as_ref).collect::<Vec<_>>())
        };
        noise(VelocitySource::Angle) < BETTER * noise(VelocitySource::Channel)
    };
    with(if angle_is_better { VelocitySource::Angle } else { VelocitySource::Channel })
}
