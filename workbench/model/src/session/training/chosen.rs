//! What a training chose, and why: reports for those who want to know.

use crate::settings::{Settings, VelocityFrom};
use crate::train::{ShaftPlan, Trained, VelocitySource};

/// Reports the choices of a training.
pub(crate) fn report(trained: &Trained, settings: &Settings) {
    lines(trained, settings).iter().for_each(|line| log::info!("{line}"));
}

fn lines(trained: &Trained, settings: &Settings) -> Vec<String> {
    let recipe = &trained.recipe;
    let class = |place: usize| trained.classes.get(place).map_or("", String::as_str);
    let why = |given: bool, otherwise: &'static str| if given { "as given" } else { otherwise };
    let parts = recipe.estimation.segment.is_some();
    let usual = if parts { "equal parts of the longest training trace" } else { "the longest training trace" };
    let segments = why(settings.model.segment.is_some(), usual);
    let mut lines = vec![format!("segments: {} samples, {segments}", trained.segment_samples)];
    lines.push(match recipe.alarms.healthy {
        Some(place) if trained.classes.len() == 1 => format!("healthy class: {}, the only one", class(place)),
        Some(place) => {
            format!("healthy class: {}, {}", class(place), why(settings.alarm.healthy.is_some(), "by its name"))
        }
        None => "healthy class: none, since no class has the name healthy or normal".into(),
    });
    let nominal = recipe.estimation.nominal;
    let by = why(settings.model.nominal.is_some(), "the healthy class, or else the first");
    lines.push(format!("nominal model: the mean of {}, {by}", class(nominal)));
    lines.push(format!(
        "features: {} of {}, {}",
        trained.feature_names.len(),
        trained.candidates.features.len(),
        why(!settings.model.features.is_empty(), "every parameter")
    ));
    lines.extend(settings.bearing.bearing.words().map(|words| format!("bearing: {words}, as given")));
    if let (Some(plan), Some((layout, shaft))) = (&recipe.shaft, &trained.parts.shaft) {
        lines.push(velocity(plan, settings));
        let (current, other) = (shaft.lags.current, shaft.lags.velocity);
        let by = why(plan.current_delay.is_some(), "estimated from the nominal class");
        lines.push(format!(
            "lags: current {current:.2}, velocity {other:.2}, load {:.2} samples, {by}",
            shaft.lags.load
        ));
        let harmonics = layout.harmonics;
        let by = why(!settings.bearing.harmonics.is_empty(), "the number that finds most pulses");
        lines.push(format!("harmonics of an order: {harmonics}, {by}"));
        let by = why(settings.bearing.slip.is_some(), "the usual one");
        lines.push(format!("slip of the cage: up to {}, {by}", plan.slip));
    }
    if let Some(choice) = &trained.choice {
        let (lambda, gamma, count) = (choice.shrinkage.lambda, choice.shrinkage.gamma, choice.grid.len());
        lines.push(format!("shrinkage: {lambda}, {gamma}, the best log score of {count} in {} folds", choice.folds));
    }
    lines
}

/// Where the velocity comes from.
fn velocity(plan: &ShaftPlan, settings: &Settings) -> String {
    let source = match plan.velocity {
        VelocitySource::Angle => "the differences of the angle",
        VelocitySource::Channel | VelocitySource::Best => "its channel",
    };
    let by = match (settings.channels.velocity.is_some(), settings.model.velocity_from.unwrap_or_default()) {
        (false, _) => "since no channel is given",
        (true, VelocityFrom::Best) => "which leaves less noise at the bearing orders, or is the usual one without them",
        (true, _) => "as given",
    };
    format!("velocity: {source}, {by}")
}
