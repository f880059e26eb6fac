//! The report of a training, as lines and as JSON.

use bearing_watch::plan::Method;
use serde_json::{Map, Value, json};

use super::description;
use super::evidence;
use super::held_out::{Found, HeldOut};
use super::result::Training;
use crate::evaluate::Rate;
use crate::train::{Automatic, Choice, Explained, Forward, Ranking, Scores};

impl Training {
    /// Number of training traces of each class.
    fn counts(&self) -> Vec<usize> {
        (0..self.trained.classes.len()).map(|k| self.training.iter().filter(|t| t.class == k).count()).collect()
    }
}

/// Returns the report as a JSON object.
#[must_use]
pub fn to_json(own: &Training, found: &Found) -> Map<String, Value> {
    let trained = &own.trained;
    let value = json!({
        "bytes": own.bytes.len(),
        "classes": trained.classes,
        "training_traces": own.counts(),
        "left_out": trained.left_out.count,
        "missing_samples": own.missing().sum().to_json(),
        "features": trained.feature_names,
        "automatic": trained.automatic.as_ref().map(Automatic::to_json),
        "method": description::method(trained),
        "settle_samples": trained.parts.regression.as_ref().filter(|_| trained.identifies()).and_then(
            |(layout, regression)| (layout.method == Method::Instruments).then_some(regression.settle)
        ),
        "segment_samples": trained.segment_samples,
        "covariates": description::covariates_to_json(trained),
        "shrinkage": trained.choice.as_ref().map(Choice::to_json),
        "held_out": found.held_out.as_ref().map(HeldOut::to_json),
        "cross_validated": found.cross_validated.as_ref().and_then(|v| v.as_ref().ok()).map(Scores::to_json),
        "cross_validated_false_alarms":
            found.false_alarms.as_ref().and_then(|v| v.as_ref().ok()).map(|own| own.rate().to_json()),
        "forward": found.forward.iter().map(Forward::to_json).collect::<Vec<_>>(),
        "ranking": found.ranking.as_ref().map(Ranking::to_json),
        "order_noise": evidence::to_json(own.orders.as_ref()),
        "novelty": description::gate_to_json(trained),
    });
    match value {
        Value::Object(object) => object,
        _ => Map::new(),
    }
}

/// Returns the report as lines; `place` follows the number of bytes.
#[must_use]
pub fn lines(own: &Training, found: &Found, place: &str) -> Vec<String> {
    let trained = &own.trained;
    let traces = trained.classes.iter().zip(own.counts()).map(|(name, n)| format!("{n} {name}"));
    let traces: Vec<String> = traces.collect();
    let mut lines =
        vec![format!("trained on {} traces; features {}", traces.join(", "), trained.feature_names.join(", "))];
    lines.extend(own.missing().line());
    lines.extend(trained.automatic.iter().flat_map(Automatic::lines));
    lines.extend(description::built(trained, own.bytes.len(), place));
    lines.extend(trained.explained.iter().flat_map(Explained::lines));
    lines.extend(description::gate(trained));
    lines.extend(evidence::text(trained, own.orders.as_ref()));
    match &found.cross_validated {
        // Of one class there is nothing to confuse.
        Some(Ok(_)) if trained.classes.len() < 2 => {}
        Some(Ok(scores)) => {
            let error = 100.0 * scores.error;
            let interval = scores.error_by_group.map_or_else(String::new, |Rate { low, high, .. }| {
                format!(" [{:.1}, {:.1}]", 100.0 * low, 100.0 * high)
            });
            lines.push(format!("cross-validated: error {error:.1} %{interval}, {}", scores.summary()));
        }
        Some(Err(reason)) => lines.push(format!("not cross-validated: {reason}")),
        None => {}
    }
    match &found.false_alarms {
        Some(Ok(own)) => lines.push(format!(
            "cross-validated: healthy segments that are novel for a gate of the others {} ({} of {})",
            own.rate(),
            own.total().0,
            own.total().1
        )),
        Some(Err(reason)) => lines.push(format!("false alarms not cross-validated: {reason}")),
        None => {}
    }
    lines.extend(Forward::lines(&found.forward));
    if let Some(HeldOut { confusion, scores, false_alarms, .. }) = &found.held_out {
        let scores = scores.summary();
        lines.push(format!("held-out traces, through the embedded detector:\n{confusion}\n{scores}"));
        lines.extend(false_alarms.as_ref().map(|found| format!("false alarms {found}")));
    }
    lines.extend(found.ranking.as_ref().map(ToString::to_string));
    lines
}
