//! What the faces share: a field by its name, and what is refused.

use serde_json::{Map, Value};

use super::fields::section_of;
use super::written_values::{Refused, from_value, shown};
use crate::Error;
use crate::settings::sections::merge::Given as _;
use crate::settings::sections::settings::Settings;

impl Settings {
    /// Settings with this field alone; `None` if there is no such field.
    ///
    /// # Errors
    /// The value does not fit.
    #[must_use]
    pub fn of(key: &str, value: Value) -> Option<Result<Self, Refused>> {
        let section = section_of(key)?;
        let (key, text) = (key.to_string(), shown(&value));
        // The sections go by as tables, so that the lists of names stay in serde's hands.
        let table = Map::from_iter([(key.clone(), value)]);
        let all = Value::Object(Map::from_iter([(section.name.to_string(), Value::Object(table))]));
        Some(from_value(all).map_err(|problem| Refused { key, value: text, problem: problem.plain() }))
    }

    /// Sets a field; returns whether there is one of this name.
    ///
    /// # Errors
    /// The value does not fit.
    pub fn set(&mut self, key: &str, value: Value) -> Result<bool, Refused> {
        let Some(one) = Self::of(key, value).transpose()? else { return Ok(false) };
        *self = one.or_given(std::mem::take(self));
        Ok(true)
    }

    /// Whether a field is given.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        serde_json::to_value(self)
            .ok()
            .and_then(|all| all.as_object().map(|all| all.values().any(|section| section.get(key).is_some())))
            .unwrap_or(false)
    }

    /// Returns an error if settings are out of range whatever the classes are, or one lacks another.
    ///
    /// # Errors
    /// They are.
    pub fn check(&self) -> Result<(), Error> {
        if self.alarm.other_drive && self.validation.group.is_none() && self.validation.unit.is_none() {
            let problem = "--other-drive takes units or groups as drives: name their column by --unit, and that of \
                           their runs by --group";
            return Err(Error::Usage(problem.into()));
        }
        self.model.check()
    }

    /// Returns an error if one face gives settings that exclude each other.
    ///
    /// # Errors
    /// It does.
    pub fn refuse_rivals(&self) -> Result<(), Error> {
        let rivals = [
            (
                self.alarm.alarm_interval_h.is_some() && self.alarm.alarm_interval_segments.is_some(),
                "--alarm-interval-h cannot be used with --alarm-interval-segments",
            ),
            (
                self.model.discriminant.is_some() && !self.model.shrinkage.is_empty(),
                "--shrinkage cannot be used with --discriminant",
            ),
        ];
        rivals.iter().find(|(both, _)| *both).map_or(Ok(()), |(_, what)| Err(Error::Usage((*what).into())))
    }
}
