//! Reasons and counts as text.

use bearing_watch::model::{Feature, TrackedOrder};
use bearing_watch::plan::RunTime;
use bearing_watch::shaft::OrderStrength;
use bearing_watch::{ChannelSet, Counts, Implausible, Model, Obstacle, Reason, Report};

use super::features::{MEAN, RMS};
use crate::identify::Terms;

/// The reason as text, with the channel names of this model.
pub(super) fn explain(reason: Reason, report: &Report<RunTime>, model: &Model<RunTime>) -> String {
    let channels = &model.constants().channels;
    match reason {
        Reason::TooFewRows { .. } | Reason::ShortSegment { .. } => {
            let denied = denied(&report.counts, &names(model));
            if denied.is_empty() { reason.to_string() } else { format!("{reason}: {denied}") }
        }
        Reason::ParameterNotExcited(place) => {
            let names = model.plan().layout().regression.map_or_else(Vec::new, |layout| layout.structure.names());
            names.get(place as usize).map_or(reason.to_string(), |name| {
                format!("the signals do not excite parameter {name} (constant, or dependent on the ones before)")
            })
        }
        Reason::OutOfRange { covariate } => {
            let covariates = &model.constants().classifier.covariates.list;
            let name = |feature: Feature| match feature {
                Feature::ChannelMean(channel) | Feature::ChannelRms(channel) => {
                    let kind = if matches!(feature, Feature::ChannelMean(_)) { MEAN } else { RMS };
                    let channel = channels.get(channel as usize).map_or("", |channel| channel.name.as_str());
                    format!("{kind}{channel}")
                }
                other => format!("{other:?}"),
            };
            let name = covariates.get(covariate as usize).map_or_else(String::new, |own| name(own.feature));
            format!("covariate {name} is outside the range of the training records")
        }
        Reason::Implausible(Implausible::VelocityScale) => {
            let ratio = report.shaft().and_then(|shaft| shaft.velocity_ratio);
            ratio.map_or(reason.to_string(), |ratio| format!("{reason}; it is {ratio:.4} times the slope of the angle"))
        }
        Reason::LostSamples { channel } => {
            let name = channels.get(channel as usize).map_or("", |channel| channel.name.as_str());
            format!("more samples of {name} were refused than used")
        }
        Reason::Stuck { channel } => {
            let name = channels.get(channel as usize).map_or("", |channel| channel.name.as_str());
            format!("the sensor of {name} is stuck")
        }
        Reason::Unseen(obstacle) => match times(obstacle, report, model) {
            Some(times) => format!("{reason}: the smallest defect found would be {times:.1} times an acceptable one"),
            None => reason.to_string(),
        },
        _ => reason.to_string(),
    }
}

/// The smallest defect that an order shows over the acceptable one, of the order that shows most.
fn times(obstacle: Obstacle, report: &Report<RunTime>, model: &Model<RunTime>) -> Option<f32> {
    let orders = &model.constants().shaft.first()?.tracking.orders;
    let ratio = |(own, order): (&OrderStrength, &TrackedOrder)| match obstacle {
        Obstacle::TooLittleMotion => own.smallest_relative / order.most_relative,
        Obstacle::TooNoisy => own.smallest / order.most_a,
    };
    let all = report.shaft()?.orders().iter().zip(orders).map(ratio);
    all.filter(|times| times.is_finite() && *times > 0.0).min_by(f32::total_cmp)
}

/// Names of the channels of a model.
fn names(model: &Model<RunTime>) -> Vec<&str> {
    model.constants().channels.iter().map(|channel| channel.name.as_str()).collect()
}

/// The rejected samples and rows of a segment, and its stuck channels, as text; empty if there are none. `names` are
/// the names of the model's channels.
#[must_use]
pub fn denied(counts: &Counts, names: &[&str]) -> String {
    let Counts { rejected, saturated, resting, stuck, .. } = *counts;
    let counted = [(rejected, "samples rejected"), (saturated, "samples saturated"), (resting, "rows at rest")];
    let mut parts: Vec<String> =
        counted.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    parts.extend(stuck_channels(stuck, names).iter().map(|name| format!("{name} stuck")));
    parts.join(", ")
}

/// Names of the channels whose sensor was stuck.
#[must_use]
pub fn stuck_channels<'a>(stuck: ChannelSet, names: &[&'a str]) -> Vec<&'a str> {
    names.iter().enumerate().filter(|(place, _)| stuck.contains(*place)).map(|(_, name)| *name).collect()
}
