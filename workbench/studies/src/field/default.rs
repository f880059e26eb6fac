//! The recipe of a user who names his signals, the bearing and the false-alarm rate, and nothing else.

use super::recipe::{FALSE_ALARM, TEMPERATURE, has_load_sensor};
use super::rows::Row;
use crate::by_default;
use model::Error;
use model::settings::Settings;
use model::train::Recipe;

/// Returns the settings for a row.
#[must_use]
pub fn settings(row: &Row) -> Settings {
    let mut settings = by_default::settings(has_load_sensor(&row.trained), FALSE_ALARM);
    if row.known {
        settings.model.covariates = vec![TEMPERATURE.into()];
    }
    settings
}

/// Returns the recipe for these classes.
///
/// # Errors
/// Settings that do not go together.
pub fn recipe(row: &Row, classes: &[String]) -> Result<Recipe, Error> {
    by_default::recipe(&settings(row), classes)
}
