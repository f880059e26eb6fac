//! The forms of JSON that programs read most, key by key, for `bearing-watch schema`.
//!
//! Tests compare them with what the commands print.

use serde_json::{Map, Value, json};

use super::output::VERSION;

/// A key: name, type, and meaning. The type is one of JSON Schema; `?` behind it allows null.
pub(super) type Key = (&'static str, &'static str, &'static str);

/// A form of JSON.
#[derive(Debug)]
pub(super) struct Form {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    /// Whether it is a list of such objects.
    pub(super) list: bool,
    pub(super) keys: &'static [Key],
    /// Keys that are only there with some options.
    pub(super) optional: &'static [Key],
}

impl Form {
    /// Its JSON Schema.
    pub(super) fn schema(&self) -> Value {
        let name = format!("bearing-watch/{}", self.name);
        let fixed = [
            ("format", json!({ "const": name, "description": "Name of this form" })),
            ("version", json!({ "const": VERSION, "description": "Version of this form" })),
        ];
        let fixed = fixed.map(|(key, value)| (key.to_string(), value));
        let of_key = |(key, kind, about): &Key| {
            let kinds = match (kind.strip_suffix('?'), kind.split_once('|')) {
                (Some(kind), _) => json!([kind, "null"]),
                (None, Some((one, other))) => json!([one, other]),
                (None, None) => json!(kind),
            };
            (key.to_string(), json!({ "type": kinds, "description": about }))
        };
        let properties: Map<String, Value> =
            fixed.into_iter().chain(self.keys.iter().chain(self.optional).map(of_key)).collect();
        let required: Vec<&str> = ["format", "version"].into_iter().chain(self.keys.iter().map(|key| key.0)).collect();
        let object = json!({ "type": "object", "properties": properties, "required": required });
        let mut schema = json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": name,
            "description": self.about,
        });
        let own = if self.list { json!({ "type": "array", "items": object }) } else { object };
        if let (Some(schema), Value::Object(own)) = (schema.as_object_mut(), own) {
            schema.extend(own);
        }
        schema
    }
}

/// `train --json`.
pub(super) const TRAIN: Form = Form {
    name: "train",
    about: "The report of a training",
    list: false,
    keys: &[
        ("model", "string", "File of the model"),
        ("bytes", "integer", "Size of the model, bytes"),
        ("classes", "array", "Names of the classes, in the order of all lists by class"),
        ("training_traces", "array", "Number of training traces of each class"),
        ("left_out", "integer", "Training segments without any of the features"),
        ("missing_samples", "object", "Missing samples of the recordings: all, by gaps in the time, by empty rows"),
        ("features", "array", "Names of the features in use"),
        ("method", "string", "How the detector estimates: ls or instruments"),
        ("settle_samples", "integer?", "Samples for which the instruments settle"),
        ("segment_samples", "integer", "Samples of a segment"),
        ("covariates", "object?", "What covariates explain of the features"),
        ("shrinkage", "object?", "The shrinkage of the covariances that was chosen"),
        ("held_out", "object?", "Confusion matrix and rates on the traces of --test-where"),
        ("cross_validated", "object?", "Error and scores of the cross-validation"),
        (
            "cross_validated_false_alarms",
            "object?",
            "Healthy segments that models trained without their runs call novel",
        ),
        ("forward", "array", "Cross-validated error, if each run is judged by those before it"),
        ("ranking", "object?", "The ranking of the features, with --rank"),
        ("automatic", "object?", "Why these features, if the program chose them"),
        ("order_noise", "object?", "Noise at the bearing orders"),
        ("novelty", "object?", "Gate and alarm"),
    ],
    optional: &[],
};

/// `evaluate --json`.
pub(super) const EVALUATE: Form = Form {
    name: "evaluate",
    about: "Verdicts on labelled traces, counted; rates are objects with value, low and high (95 % interval)",
    list: false,
    keys: &[
        ("classes", "array", "Names of the classes, those of the model first"),
        ("confusion", "array", "Number of decisions: a row for each true class, a column for each decided one"),
        ("undetermined", "array", "Number without a verdict, by true class"),
        ("novel", "array", "Number of novel verdicts, by true class"),
        ("ambiguous", "array", "Number of ambiguous verdicts, by true class"),
        ("called_healthy", "array", "Rate of decisions for the healthy class, by true class"),
        ("error_rate", "object", "Rate of wrong decisions"),
        ("balanced_accuracy", "object", "Mean over the classes of the rate of right decisions"),
        ("trained_on", "integer", "Traces that the model was trained on"),
        ("missing_samples", "object", "Missing samples of the recordings: all, by gaps in the time, by empty rows"),
        ("covariates_out_of_range", "integer", "Segments with a covariate that is missing or outside its range"),
        ("untrained_not_called_healthy", "object", "Rate by class that the model was not trained on"),
        ("controls_not_called_healthy", "object", "Rate by class of --control-classes"),
        ("chance", "object?", "What chance alone gives"),
        ("roc_areas", "array", "Areas under ROC curves by class and score: within units, and pooled, with intervals"),
        ("controls", "array", "Negative controls of --controls"),
        ("by", "object", "Rates by the values of the columns of --by"),
        ("log_score", "object?", "Mean logarithm of the probability of the true class"),
        ("brier_score", "object?", "Mean squared error of the probabilities"),
        ("expected_calibration_error", "number?", "Mean difference of probability and frequency"),
    ],
    optional: &[
        ("false_alarms_by_run", "object", "False alarms by run, with --group or --unit"),
        ("features_by_run", "object", "Stability of the features over runs, with --group or --unit"),
    ],
};

/// `replay --json`.
pub(super) const REPLAY: Form = Form {
    name: "replay",
    about: "The verdict on each segment, in the order of the traces",
    list: true,
    keys: &[
        ("trace", "string", "Name of the trace"),
        ("segment", "integer", "Number of the segment in its trace"),
        ("start", "integer", "First sample"),
        ("length", "integer", "Number of samples"),
        ("class", "string?", "The class, if the verdict is one"),
        ("verdict", "string", "The class, novel, ambiguous or undetermined"),
        ("undetermined", "string?", "Why there is no verdict"),
        ("missing", "array", "Features that were missing"),
        ("missing_samples", "object", "Missing samples of the trace: all, by gaps in the time, by empty rows"),
        ("covariates_out_of_range", "array", "Covariates that were missing or outside their range"),
        ("posteriors", "object", "Probability of each class"),
        ("log_likelihoods", "object", "Logarithmic likelihood of each class"),
        ("distance", "number?", "Distance from the healthy class in its standard deviations"),
        ("surprise", "number?", "−ln of the probability that a healthy segment is as distant, nats"),
        ("score", "number?", "Evidence so far, nats"),
        ("alarm", "object?", "Segment and cause of the alarm, once it is raised"),
        ("run", "array?", "After the last segment of a run: deviations and score of each direction of the alarm"),
        ("most", "object?", "The coordinate that departs most from the healthy class, and whether it is too low"),
        ("smallest_found", "array", "The smallest amplitude or change of each defect that this segment would show"),
        ("growth", "object?", "Size in the direction of the alarm, its slope, and the time left, with 90 % intervals"),
        (
            "life",
            "object?",
            "After the last segment of a trace: load collective and nominal life of the bearing so far",
        ),
        ("parameters", "object?", "Parameters of the difference model"),
        ("variance", "number?", "Variance of its residuals"),
        ("friction", "object?", "Terms of the torque balance: names, values, deviations and scores"),
        ("orders", "array", "Prominence and amplitude (A) of each bearing order"),
        ("rows", "integer", "Rows of the regression"),
        ("rejected", "integer", "Samples that were rejected"),
        ("saturated", "integer", "Samples at the limit of a sensor"),
        ("downweighted", "integer", "Rows with less weight"),
        ("still", "integer", "Samples at rest"),
        ("stuck", "array", "Channels that are stuck"),
    ],
    optional: &[],
};

/// What a command prints if it fails.
pub(super) const ERROR: Form = Form {
    name: "error",
    about: "Why a command failed; its exit code is 2",
    list: false,
    keys: &[("error", "object", "kind (usage, file, content, trace, training or other) and message")],
    optional: &[],
};
