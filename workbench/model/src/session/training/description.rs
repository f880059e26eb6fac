//! Describes a trained model in words: estimator, gate, alarm, and the input of the detector.

use bearing_watch::model::EvidenceConstants;
use bearing_watch::plan::Method;
use serde_json::{Value, json};

use crate::trace::{Channels, Preparation, ShaftChannels};
use crate::train::directions::{Direction, Levels};
use crate::train::novelty::runs::{RunSpread, Slope};
use crate::train::novelty::{Gate, baseline};
use crate::train::{
    Axis, Coefficient, Dependence, Doubted, Explained, NextToRotor, Remedy, ShaftPlan, Trained, label, next_to_rotor,
};

/// The estimator of the difference model as a word for `--method`; `None` if the detector does not estimate it.
#[must_use]
pub fn method(trained: &Trained) -> Option<&'static str> {
    trained.identifies().then_some(match trained.recipe.estimation.method {
        Method::LeastSquares => "ls",
        Method::Instruments => "instruments",
    })
}

/// How the detector estimates and decides; the number of bytes of the model file follows.
#[must_use]
pub fn built(trained: &Trained, bytes: usize, place: &str) -> [String; 2] {
    let (kind, coordinates) = (trained.kind_name(), trained.core_projection.matrix.nrows());
    let segments = trained.segment_samples;
    [
        format!("estimated by {}", estimated_by(trained)),
        format!(
            "{kind} discriminant, coordinates: {coordinates}, segments of {segments} samples; {bytes} bytes{place}"
        ),
    ]
}

/// Describes the estimation method and its memory in words.
pub(crate) fn estimated_by(trained: &Trained) -> String {
    let Some((layout, regression)) = trained.parts.regression.as_ref().filter(|_| trained.identifies()) else {
        let orders = trained.recipe.shaft.as_ref().map(ShaftPlan::names).unwrap_or_default();
        let of_orders = if orders.is_empty() { String::new() } else { format!("; orders {}", orders.join(", ")) };
        return format!("the torque balance{of_orders}; no feature reads the difference model");
    };
    let nominal = &trained.classes[trained.recipe.estimation.nominal];
    let method = match layout.method {
        Method::LeastSquares => "least squares".to_string(),
        Method::Instruments => {
            format!("instrumental variables from the mean of {nominal}, settling for {} samples", regression.settle)
        }
    };
    match trained.recipe.estimation.memory {
        None => method,
        Some(_) => format!("{method}, forgetting by {} a sample", regression.forgetting.lambda),
    }
}

/// Returns the comment lines at the head of the exported constants: channels, features, estimator, and the detector's
/// input.
#[must_use]
pub fn lines(trained: &Trained, channels: &Channels, host: Preparation) -> Vec<String> {
    let Preparation { block_mean, decimate } = host;
    let step_s = trained.interval_s as f32;
    let mut fed = match (block_mean, decimate) {
        (1, 1) if channels.front_end.is_some() => "Feed every sample of the front end".to_string(),
        (1, 1) => "Feed every sample as recorded".to_string(),
        (_, 1) => format!("Feed means of {block_mean} recorded samples"),
        (1, _) => format!("Feed every {decimate}-th recorded sample behind an anti-alias filter"),
        _ => format!("Feed every {decimate}-th mean of {block_mean} recorded samples behind an anti-alias filter"),
    };
    fed += &if step_s > 0.0 { format!(", one every {step_s} s.") } else { ".".into() };
    let Channels { y, u1, u2, shaft, .. } = channels;
    let inputs = match (trained.identifies(), trained.recipe.structure.nc > 0) {
        (true, true) => format!("y = {y}, u1 = {u1}, u2 = {u2}; "),
        (true, false) => format!("y = {y}, u1 = {u1}; "),
        (false, _) => String::new(),
    };
    let mut lines = vec![
        format!("{inputs}classes {}.", trained.classes.join(", ")),
        format!("Features {}; {} discriminant.", trained.feature_names.join(", "), trained.kind_name()),
        format!("Estimated by {}.", estimated_by(trained)),
        fed,
    ];
    if let (Some(ShaftChannels { current, velocity, load, angle, .. }), Some(plan)) = (shaft, &trained.recipe.shaft) {
        let orders: Vec<String> = plan.orders.iter().map(|(name, order)| format!("{name} {order:.5}")).collect();
        let load = match (load, plan.axis.turns()) {
            (Some(load), _) => load.clone(),
            (None, Some(turns)) => format!("a weight on an axis of one turn in {turns:.4} of the motor, estimated"),
            (None, None) => "not measured, 0".into(),
        };
        let velocity = velocity.as_deref().unwrap_or("the differences of the angle");
        lines.push(format!(
            "Motion: current {current}, velocity {velocity}, load {load}, angle {angle}; orders {}.",
            if orders.is_empty() { "none".into() } else { orders.join(", ") }
        ));
    }
    let covariates = trained.explained.iter().flat_map(Explained::lines);
    lines.into_iter().chain(covariates).chain(gate(trained)).collect()
}

/// What is uncertain about a model.
#[must_use]
pub fn doubts(trained: &Trained) -> Vec<String> {
    let own = trained.left_out.summary().into_iter().chain(trained.watch.warning.clone());
    let unwatched = trained.watch.directions.iter().filter_map(|own| own.unwatched(&trained.coordinate_names));
    let lasting = trained.watch.directions.iter().filter_map(|own| own.unordered(&trained.coordinate_names));
    let doubted = trained.doubted.iter().flat_map(Doubted::lines);
    let dependence = trained.dependence.iter().map(Dependence::line);
    let cut = label::cut(&trained.classes);
    let axis = trained.recipe.shaft.as_ref().and_then(|plan| match plan.axis {
        Axis::Carries(weight) => weight.doubt(),
        _ => None,
    });
    own.chain(unwatched)
        .chain(lasting)
        .chain(dependence)
        .chain(doubted)
        .chain(rotor_warnings(trained))
        .chain(axis)
        .chain(cut)
        .collect()
}

/// Warns if the host prepares what the detector cannot.
#[must_use]
pub fn of_host(host: Preparation, description: &[String]) -> Option<String> {
    (host != Preparation::NONE).then(|| format!("the detector does not decimate: {}", description[3]))
}

/// Tells which bearing orders cannot be told from what turns with the rotor.
fn rotor_warnings(trained: &Trained) -> Vec<String> {
    let Some((_, shaft)) = &trained.parts.shaft else { return vec![] };
    let names = trained.recipe.shaft.as_ref().map(ShaftPlan::names).unwrap_or_default();
    let line = |NextToRotor { place, order, rotor, remedy }: &NextToRotor| {
        let remedy = match remedy {
            Remedy::Turns(turns) => format!("records of {turns} turns and more tell them apart"),
            Remedy::Slip { slip, turns } => {
                let searched = 100.0 * shaft.tracking.blocks.slip;
                format!(
                    "with slips of up to {searched:.2} % no record tells them apart; --slip {slip:.4} and records of \
                     {turns} turns and more do"
                )
            }
            Remedy::None => "they are too near for any record".into(),
        };
        format!(
            "order {} of {order:.4} cannot be told from cogging, unbalance and errors of the angle at order {rotor}: \
             {remedy}",
            names.get(*place).map_or("", String::as_str)
        )
    };
    next_to_rotor(&shaft.tracking).iter().map(line).collect()
}

/// Describes the gate and the alarm in words.
#[must_use]
pub fn gate(trained: &Trained) -> Option<String> {
    let gate = trained.watch.gate.as_ref()?;
    let by_run = gate.runs.as_ref().map_or_else(String::new, |runs| by_run(trained, gate, runs));
    let rising = match &gate.rising {
        Some(rising) => format!(
            ", or by one of {} alone",
            trained.coordinate_names[trained.coordinate_names.len() - rising.laws.len()..].join(", ")
        ),
        None => String::new(),
    };
    Some(format!(
        "Novel beyond distance {:.2} from {}{rising}: false-alarm rate {} a segment by {} segments (Gaussian with probability \
         {:.2}, else heavier tails); {}.{by_run}",
        gate.law.squared_at(gate.limit).sqrt(),
        trained.classes[gate.class],
        trained.recipe.alarms.false_alarm,
        gate.rows,
        gate.law.gaussian_probability(),
        alarm(trained),
    ))
}

/// Describes the alarm.
fn alarm(trained: &Trained) -> String {
    let EvidenceConstants { limit, cap, segments_a_run, log_mean, .. } = trained.watch.evidence;
    if limit.is_infinite() {
        return "no alarm".into();
    }
    if let Some(directions) = &trained.watch.directions {
        let words = directions.words(&trained.coordinate_names);
        return format!("alarm: {words}; {} between false alarms", interval(trained));
    }
    let runs = match segments_a_run {
        1 => "segments count as independent".into(),
        segments => format!("a run ends after {segments} segments, or where the firmware ends it"),
    };
    format!(
        "false alarms every {:.3e} segments for {:.0} % of such training sets; {runs}; each adds at most {:.1} of {limit:.1} \
         nats",
        trained.watch.segments,
        100.0 * baseline::COVERED,
        cap - log_mean,
    )
}

/// The mean time between false alarms; in segments if their duration is not known.
fn interval(trained: &Trained) -> String {
    let segments = trained.watch.segments;
    let segment_s = trained.interval_s * (trained.segment_samples * trained.block_mean) as f64;
    if segment_s > 0.0 {
        return format!("{:.4} h", segments * segment_s / 3600.0).replace(".0000 h", " h");
    }
    format!("{segments:.3e} segments")
}

/// Describes the spread of the runs on which the rate rests.
fn by_run(trained: &Trained, gate: &Gate, runs: &RunSpread) -> String {
    let RunSpread { count, between, freedom, slopes, drift, .. } = runs;
    let drift = drift.as_ref().map_or_else(String::new, |drift| {
        let each = |&k: &usize| {
            let Slope { value, error } = slopes[k];
            format!("{} by {value:.2} ± {error:.2} deviations a run", trained.coordinate_names[k])
        };
        let each: Vec<String> = drift.coordinates.iter().map(each).collect();
        let left = drift.runs_to(gate.law.squared_at(gate.limit).sqrt(), *count);
        format!(
            " The runs drift: {}. The next one is expected {:.1} deviations from their mean, which the covariance \
             covers; if the drift goes on, healthy segments reach the gate in {left:.0} runs: train again before.",
            each.join(", "),
            drift.distance,
        )
    });
    let next = if trained.recipe.alarms.other_drive {
        "another drive, for normally distributed drives"
    } else {
        "the next run, for normally distributed runs"
    };
    let unit = if trained.recipe.alarms.other_drive { "drives" } else { "runs" };
    format!(
        " The rate is that of {next}: {count} {unit}, {:.0} % of the variance between them, {freedom:.1} degrees of \
         freedom.{drift}",
        100.0 * between
    )
}

/// Returns the covariates and what they explain as JSON; null without covariates.
pub(crate) fn covariates_to_json(trained: &Trained) -> Value {
    let Some(explained) = &trained.explained else { return Value::Null };
    let coefficient = |own: &Coefficient| json!({ "value": own.value, "standard_error": own.error });
    let feature = |(k, name): (usize, &String)| {
        let terms = explained.covariates.iter().zip(&explained.map[k]);
        let terms = terms
            .map(|(own, [a, b])| json!({ "covariate": own.name, "linear": coefficient(a), "square": coefficient(b) }));
        json!({ "feature": name, "explained": explained.parts[k], "terms": terms.collect::<Vec<_>>() })
    };
    let range = |own: &crate::train::Explaining| {
        let [low, high] = own.range;
        json!({ "name": own.name, "mean": own.centre, "low": low, "high": high, "at_ends": own.at_ends })
    };
    json!({
        "covariates": explained.covariates.iter().map(range).collect::<Vec<_>>(),
        "features": explained.features.iter().enumerate().map(feature).collect::<Vec<_>>(),
        "healthy_segments": explained.rows,
    })
}

/// Returns what the alarm watches as JSON; null without directions.
fn directions_to_json(trained: &Trained) -> Value {
    let Some(found) = &trained.watch.directions else { return Value::Null };
    let names = &trained.coordinate_names;
    let form = |direction: &Direction| {
        let Levels { centre, between, run, record, skewness, correlation, freedom } = direction.levels;
        json!({
            "name": direction.words(names),
            "coordinate": names[direction.coordinate],
            "background": direction
                .background
                .iter()
                .map(|(k, weight)| json!({ "coordinate": names[*k], "weight": weight }))
                .collect::<Vec<_>>(),
            "mean": centre,
            "variance_between_drives": between,
            "variance_between_runs": run,
            "variance_of_records": record,
            "skewness": skewness,
            "correlation_of_successive_runs": correlation,
            "degrees_of_freedom": freedom,
        })
    };
    json!({
        "list": found.list.iter().map(form).collect::<Vec<_>>(),
        "drives": found.drives,
        "runs": found.runs,
        "segments_a_run": found.usual,
        "left_out": found.left_out.iter().map(|&k| &names[k]).collect::<Vec<_>>(),
    })
}

/// Returns the gate and the alarm as JSON; null without a gate.
#[must_use]
pub fn gate_to_json(trained: &Trained) -> Value {
    let Some(gate) = &trained.watch.gate else { return Value::Null };
    json!({
        "healthy": trained.classes[gate.class],
        "false_alarm": trained.recipe.alarms.false_alarm,
        "distance": gate.law.squared_at(gate.limit).sqrt(),
        "gaussian_probability": gate.law.gaussian_probability(),
        "segments": gate.rows,
        "segments_needed": gate.rows_needed,
        "next_run": gate.runs.as_ref().map(|runs| json!({
            "runs": runs.count,
            "between": runs.between,
            "degrees_of_freedom": runs.freedom,
            "slopes": runs.slopes.iter().map(|slope| json!({ "value": slope.value, "error": slope.error }))
                .collect::<Vec<_>>(),
            "drift": runs.drift.as_ref().map(|drift| json!({
                "coordinates": drift.coordinates.iter().map(|&k| &trained.coordinate_names[k]).collect::<Vec<_>>(),
                "distance": drift.distance,
                "runs_to_gate": drift.runs_to(gate.law.squared_at(gate.limit).sqrt(), runs.count),
            })),
        })),
        "alarm_directions": directions_to_json(trained),
        "alarm_interval_segments": trained.watch.segments,
        "alarm_limit_nats": trained.watch.evidence.limit,
        "alarm_cap_nats": trained.watch.evidence.cap,
        "alarm_segments_a_run": trained.watch.evidence.segments_a_run,
        "alarm_log_mean": trained.watch.evidence.log_mean,
        "alarm_defect_log_mean": trained.watch.evidence.defect_log_mean,
    })
}
