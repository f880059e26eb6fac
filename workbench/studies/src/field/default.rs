//! The recipe of a user who names his signals, the bearing and the false-alarm rate, and nothing else.

use super::recipe::{FALSE_ALARM, TEMPERATURE, has_load_sensor};
use super::rows::Row;
use model::Error;
use model::settings::{Alarm, Bearing, Reading, Settings, Signals};
use model::train::Recipe;
use rig::BearingGeometry;

/// Returns the settings for a row.
#[must_use]
pub fn settings(row: &Row) -> Settings {
    let name = |name: &str| Some(name.to_string());
    let load = has_load_sensor(&row.trained).then(|| "load_torque_nm".to_string());
    let channels = Signals {
        current: name("current_a"),
        velocity: name("velocity_rad_s"),
        velocity_ref: name("velocity_ref_rad_s"),
        angle: name("angle_rad"),
        load,
        ..Signals::default()
    };
    let BearingGeometry { balls, ball_diameter_mm, pitch_diameter_mm, contact_angle_rad } = BearingGeometry::THESIS;
    let bearing = Bearing {
        bearing: vec![f64::from(balls), ball_diameter_mm, pitch_diameter_mm, contact_angle_rad],
        ..Bearing::default()
    };
    let alarm = Alarm { false_alarm: Some(FALSE_ALARM), ..Alarm::default() };
    let mut settings = Settings { channels, bearing, alarm, ..Settings::default() };
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
    let settings = settings(row);
    let Reading { channels, shaft, .. } = settings.reading(None)?;
    let recipe = settings.recipe(classes, shaft)?;
    Ok(Recipe { columns: channels, ..recipe })
}
