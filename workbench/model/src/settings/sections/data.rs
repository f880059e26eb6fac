//! `[data]`: which recordings.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::merge::merges;
use crate::settings::faces::written_values::{above_zero, one_or_more};
use crate::trace::{Condition, Decimal, Separator, TextForm};

/// Which recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Data {
    /// Trace files or folders, with all folders below; without any, the folder of the labels
    #[serde(deserialize_with = "one_or_more", skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "TRACES", "x-file" = true, "x-positional" = true)))]
    pub traces: Vec<PathBuf>,
    /// CSV with the columns trace,class_name and any further columns for the selection
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FILE", "x-file" = true)))]
    pub labels: Option<PathBuf>,
    /// Only rows that meet this condition, e.g. load_kgf=20; may be repeated, all must hold
    #[serde(rename = "where", deserialize_with = "one_or_more", skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<String>", extend("x-value" = "CONDITION")))]
    pub conditions: Vec<Condition>,
    /// Only these classes, in this order
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "NAMES")))]
    pub classes: Vec<String>,
    /// Time column, in s or in the unit at the end of its name; by default the one with a usual name (`t_s`,
    /// `Time [ms]`, `timestamp` …). "none" leaves it out
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "COLUMN")))]
    pub time: Option<String>,
    /// Rows a second, for files without a time column
    #[serde(deserialize_with = "above_zero", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "HZ", "exclusiveMinimum" = 0)))]
    pub rate_hz: Option<f64>,
    /// Lines of a text file before its header; by default told by its content
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "LINES")))]
    pub skip: Option<usize>,
    /// The first line of a text file, behind those that are skipped, has names, and the next one units
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub units_row: bool,
    /// What separates the cells of a text file: a character, or tab, blank, comma, semicolon, bar
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "CHARACTER", "examples" = ["semicolon"])))]
    pub separator: Option<Separator>,
    /// The decimal mark of a text file; the other one then separates thousands
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<Decimal>,
    /// Recordings at the control rate pass this front end (TOML); it makes the columns current_a, velocity_rad_s and
    /// angle_rad, and decimates every other column. `simulate --rig ema` writes an example
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FILE", "x-file" = true)))]
    pub front_end: Option<PathBuf>,
}

merges!(Data { traces, labels, conditions, classes, time, rate_hz, skip, units_row, separator, decimal, front_end });

impl Data {
    /// The parts of the layout of text files that are given.
    #[must_use]
    pub const fn text_form(&self) -> TextForm {
        let Self { skip, units_row, separator, decimal, .. } = *self;
        TextForm { skip, units_row, separator, decimal }
    }
}
