//! The settings as a whole.

use serde::{Deserialize, Serialize};

use super::alarm::Alarm;
use super::bearing::Bearing;
use super::data::Data;
use super::merge::{Given as _, merges};
use super::model::Model;
use super::signals::Signals;
use super::validation::Validation;

/// What a user says of a drive, its recordings and its model; only the fields that are given are set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// `[data]`.
    pub data: Data,
    /// `[channels]`.
    pub channels: Signals,
    /// `[bearing]`.
    pub bearing: Bearing,
    /// `[model]`.
    pub model: Model,
    /// `[validation]`.
    pub validation: Validation,
    /// `[alarm]`.
    pub alarm: Alarm,
}

merges!(Settings { data, channels, bearing, model, validation, alarm });

impl Settings {
    /// These settings, and those of `base` that they do not have. A setting here leaves out its rival there.
    #[must_use]
    pub fn over(self, mut base: Self) -> Self {
        if self.alarm.alarm_interval_h.is_some() || self.alarm.alarm_interval_segments.is_some() {
            (base.alarm.alarm_interval_h, base.alarm.alarm_interval_segments) = (None, None);
        }
        if self.model.discriminant.is_some() || !self.model.shrinkage.is_empty() {
            (base.model.discriminant, base.model.shrinkage) = (None, vec![]);
        }
        self.or_given(base)
    }
}
