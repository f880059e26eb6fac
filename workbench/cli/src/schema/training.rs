//! The forms of JSON of training and evaluation.

use super::form::Form;

/// `train --json`.
pub(crate) const TRAIN: Form = Form {
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
        ("method", "string?", "How the detector estimates the difference model, if it does: ls or instruments"),
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
pub(crate) const EVALUATE: Form = Form {
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

/// `features --json`.
pub(crate) const FEATURES: Form = Form {
    name: "features",
    about: "A part of the features of labelled traces that was written",
    list: false,
    keys: &[
        ("part", "string", "File of the part"),
        ("rows", "integer", "Segments"),
        ("traces", "integer", "Traces"),
        ("features", "array", "Names of the features"),
        ("without_features", "integer", "Segments without any feature"),
        ("plan", "string", "The file with the plan beside the part"),
        ("units_ascend", "boolean", "Whether the units of the rows ascend"),
        ("seconds", "number", "Time that it took"),
    ],
    optional: &[],
};

/// `train-features --json`.
pub(crate) const TRAIN_FEATURES: Form = Form {
    name: "train-features",
    about: "The report of a training from features",
    list: false,
    keys: &[
        ("model", "string", "File of the model"),
        ("bytes", "integer", "Size of the model"),
        ("fingerprint", "string", "A number that differs between different models"),
        ("classes", "array", "Names of the classes"),
        ("segments", "array", "Number of segments of each class"),
        ("rows", "integer", "Segments of the parts"),
        ("left_out", "integer", "Segments without any of the features"),
        ("features", "array", "Names of the features in use"),
        ("method", "string?", "How the detector estimates the difference model, if it does: ls or instruments"),
        ("segment_samples", "integer", "Samples of a segment"),
        ("novelty", "object?", "Gate and alarm"),
        ("tails_from_segments", "boolean", "Whether the tails of the gate's law are those of segments"),
        ("seconds", "number", "Time that it took"),
        ("seconds_of_first_pass", "number", "Time of the first pass"),
        ("rows_a_second", "number", "Segments a second"),
        ("peak_memory_mb", "number?", "Largest resident memory"),
    ],
    optional: &[],
};
