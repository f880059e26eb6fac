//! What the training set supports: rates of the gate, and amplitudes of the bearing orders.

use serde_json::{Value, json};

use crate::Error;
use crate::trace::labels::LabelledTrace;
use crate::trace::{MotionTrace, median};
use crate::train::{Trained, compared_turns};

/// Healthy records in which the noise of the orders is measured.
const MOST: usize = 32;

/// What healthy records say about the orders.
#[derive(Debug)]
pub(crate) struct Orders {
    /// Median number of turns of a record.
    turns: f64,
    /// Turns over which phases are compared.
    coherent: f64,
    /// Number of harmonics of each order that training has chosen.
    harmonics: u8,
    /// Median deviation of each order's amplitude, A.
    deviations: Vec<(String, f64)>,
}

impl Orders {
    /// By the embedded detector on healthy records; `None` without tracked orders.
    ///
    /// # Errors
    /// The model cannot be embedded.
    pub(crate) fn of(trained: &Trained, prepared: &[LabelledTrace]) -> Result<Option<Self>, Error> {
        let (Some(plan), Some((layout, shaft))) = (&trained.recipe.shaft, &trained.parts.shaft) else {
            return Ok(None);
        };
        if plan.orders.is_empty() {
            return Ok(None);
        }
        let nominal = trained.recipe.estimation.nominal;
        let healthy: Vec<&LabelledTrace> = prepared.iter().filter(|own| own.class == nominal).take(MOST).collect();
        let detector = trained.embed()?;
        let (mut turns, mut deviations) = (vec![], vec![vec![]; plan.orders.len()]);
        for labelled in healthy {
            turns.extend(labelled.trace.motion.as_ref().map(MotionTrace::turns));
            let report = detector.whole(&labelled.trace);
            let Some(shaft) = report.shaft().filter(|shaft| shaft.orders_reason.is_none()) else { continue };
            for (own, order) in deviations.iter_mut().zip(shaft.orders()) {
                own.push(f64::from(order.deviation));
            }
        }
        let coherent = compared_turns(&shaft.tracking);
        let named = plan.names().into_iter().zip(deviations.iter().map(median)).collect();
        let harmonics = layout.harmonics;
        Ok(Some(Self { turns: median(&turns), coherent, harmonics, deviations: named }))
    }
}

/// A short paragraph; `None` if there is neither a gate nor an order.
pub(crate) fn text(trained: &Trained, orders: Option<&Orders>) -> Option<String> {
    let gate = trained.watch.gate.as_ref().map(|gate| {
        let rate = trained.recipe.alarms.false_alarm;
        let needed = gate.rows_needed;
        let enough = if gate.counted() >= needed as f64 { "They are enough" } else { "They are too few" };
        let runs = gate.runs.as_ref().map_or_else(
            || ", runs not given: the rate is that of records like these".to_owned(),
            |runs| {
                let counted = gate.counted();
                format!(
                    " of {} runs, which count as {counted:.0} independent ones: the rate is that of the next run",
                    runs.count
                )
            },
        );
        let counts = if gate.runs.is_some() { "runs" } else { "segments" };
        format!(
            "The gate rests on {} healthy segments{runs}. {enough} for {rate} a segment within a factor of three \
             ({needed} are needed); rates below {:.2e} rest on the fitted law and not on counted {counts}.",
            gate.rows,
            gate.least_counted_rate()
        )
    });
    let orders = orders.map(|own| {
        // The smallest amplitude that a record shows in most cases.
        let smallest = |(name, deviation): &(String, f64)| match deviation.is_finite() {
            true => format!("{name} {:.3}", 3.0 * deviation),
            false => format!("{name} not known (no healthy record has its amplitude)"),
        };
        let smallest: Vec<String> = own.deviations.iter().map(smallest).collect();
        format!(
            "A record has {:.0} turns, and phases are compared over {:.0}: orders closer than {:.3} cannot be told \
             apart. Smallest amplitude that stands out in one record (three deviations), A: {}. Of each order {} used.",
            own.turns,
            own.coherent.min(own.turns),
            1.0 / own.coherent.min(own.turns),
            smallest.join(", "),
            if own.harmonics == 1 { "one harmonic is".into() } else { format!("{} harmonics are", own.harmonics) },
        )
    });
    let looks_at_orders = trained.feature_names.iter().any(|name| name.starts_with("order_"));
    let unused = (orders.is_some() && !looks_at_orders).then(|| {
        "Warning: no order of the bearing is a feature, so a spall is not looked for. Leave the features out, or name \
         \"orders\" among them."
            .to_owned()
    });
    let parts: Vec<String> = [unused, gate, orders].into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join("\n"))
}

/// Turns and deviations; null without orders.
pub(crate) fn to_json(orders: Option<&Orders>) -> Value {
    orders.map_or(Value::Null, |own| {
        let each = |(name, deviation): &(String, f64)| json!({ "order": name, "amplitude_deviation_a": deviation });
        json!({
            "turns": own.turns,
            "coherent_turns": own.coherent,
            "harmonics": own.harmonics,
            "orders": own.deviations.iter().map(each).collect::<Vec<_>>(),
        })
    })
}
