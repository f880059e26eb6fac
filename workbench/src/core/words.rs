//! Reasons and denials in words.

use bearing_watch::{Counts, Reason, Report, ShaftEstimate};

use super::motion::MAX_ORDERS;
use crate::identify::Structure;

/// The reason with what it means in this model.
pub(super) fn explain<const M: usize, const P: usize, const C: usize>(
    reason: Reason,
    report: &Report<M, P, C, MAX_ORDERS>,
) -> String {
    if report.accepted
        && let Some(ShaftEstimate { reason, orders_reason, counts, .. }) = &report.shaft
        && let Some(reason) = reason.or(*orders_reason)
    {
        return match reason {
            Reason::NotExcited(place) => {
                let name = super::features::FRICTION.get(place as usize).unwrap_or(&"the torque balance");
                format!("shaft: the motion does not excite {name} (constant, or depending on the ones before)")
            }
            _ if !denied(counts).is_empty() => format!("shaft: {reason}: {}", denied(counts)),
            _ => format!("shaft: {reason}"),
        };
    }
    let estimate = &report.estimate;
    match reason {
        Reason::TooFewRows if !denied(&estimate.counts).is_empty() => format!("{reason}: {}", denied(&estimate.counts)),
        Reason::NotExcited(place) => {
            let names = Structure { order: estimate.order, offset: estimate.offset }.names();
            names.get(place as usize).map_or(reason.to_string(), |name| {
                format!("the signals do not excite parameter {name} (constant, or depending on the ones before)")
            })
        }
        _ => reason.to_string(),
    }
}

/// What a segment was denied, in words; empty where nothing was.
#[must_use]
pub fn denied(counts: &Counts) -> String {
    let Counts { rejected, saturated, downweighted, still, stuck, .. } = *counts;
    let counted = [
        (rejected, "samples rejected"),
        (saturated, "samples saturated"),
        (downweighted, "rows weighed less"),
        (still, "rows still"),
    ];
    let mut parts: Vec<String> =
        counted.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    parts.extend(stuck_signals(stuck).iter().map(|name| format!("{name} stuck")));
    parts.join(", ")
}

/// Names of the signals whose sensor was stuck.
#[must_use]
pub fn stuck_signals(stuck: [bool; 3]) -> Vec<&'static str> {
    ["y", "u1", "u2"].into_iter().zip(stuck).filter(|(_, stuck)| *stuck).map(|(name, _)| name).collect()
}
