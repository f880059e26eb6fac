//! `[validation]`: which records train and which judge.

use serde::{Deserialize, Serialize};

use super::merge::merges;
use crate::settings::faces::written_values::one_or_more;
use crate::trace::Condition;

/// Folds of the cross-validation.
pub(crate) const FOLDS: usize = 10;
/// Seed of the split into folds.
pub(crate) const FOLD_SEED: u64 = 1;

/// Which records train and which judge, which are of one run or unit, and negative controls.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Validation {
    /// Train on the rows with this, e.g. 'run<=4'; may be repeated, all must hold
    #[serde(deserialize_with = "one_or_more", skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>", extend("x-value" = "CONDITION")))]
    pub train_where: Vec<Condition>,
    /// Then evaluate on the rows with this, e.g. 'run>4'; may be repeated, all must hold
    #[serde(deserialize_with = "one_or_more", skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>", extend("x-value" = "CONDITION")))]
    pub test_where: Vec<Condition>,
    /// Traces with the same value in this column of the labels are of one run: they stay in one fold, intervals count
    /// runs, the gate's false-alarm rate is that of the next run, and false alarms are given by run in the order of the
    /// labels. Without it, healthy traces are tested for dependence; "none" takes them for independent
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "COLUMN")))]
    pub group: Option<String>,
    /// Traces with the same value in this column of the labels are of one unit (drive): units stay in one fold and are
    /// not in both training and test, and intervals count units. Without a group, units are the runs
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "COLUMN")))]
    pub unit: Option<String>,
    /// Break the rates down by the values of these columns of the labels, e.g. load_kgf,level
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "COLUMNS")))]
    pub by: Vec<String>,
    /// Negative controls: columns of the labels that are unrelated to the bearing, e.g. session; verdicts on healthy
    /// traces should not depend on them
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "COLUMNS")))]
    pub controls: Vec<String>,
    /// Negative controls: classes without a defect that the model was not trained on, e.g. regreased; they should be
    /// called healthy
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CLASSES")))]
    pub control_classes: Vec<String>,
    /// Folds of the cross-validation
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N", "default" = FOLDS)))]
    pub folds: Option<usize>,
    /// Seed of the split into folds
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "SEED", "default" = FOLD_SEED)))]
    pub fold_seed: Option<u64>,
}

merges!(Validation { train_where, test_where, group, unit, by, controls, control_classes, folds, fold_seed });
