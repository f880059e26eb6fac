//! The settings of a user who names his signals, the bearing and the false-alarm rate, and nothing else.

use model::Error;
use model::settings::{Alarm, Bearing, Dimensions, Geometry, Reading, Settings, Signals};
use model::train::Recipe;
use rig::BearingGeometry;

/// Returns the settings for the rigs' signals, with or without a load sensor.
#[must_use]
pub fn settings(load: bool, false_alarm: f64) -> Settings {
    let name = |name: &str| Some(name.to_string());
    let channels = Signals {
        current: name("current_a"),
        velocity: name("velocity_rad_s"),
        velocity_ref: name("velocity_ref_rad_s"),
        angle: name("angle_rad"),
        load: load.then(|| "load_torque_nm".to_string()),
        ..Signals::default()
    };
    let BearingGeometry { balls, ball_diameter_mm, pitch_diameter_mm, contact_angle_rad } = BearingGeometry::THESIS;
    let dimensions = Dimensions {
        balls: u8::try_from(balls).unwrap_or(u8::MAX),
        ball: ball_diameter_mm,
        pitch: pitch_diameter_mm,
        contact_deg: contact_angle_rad.to_degrees(),
    };
    let bearing = Bearing { bearing: Geometry::of(dimensions), ..Bearing::default() };
    let alarm = Alarm { false_alarm: Some(false_alarm), ..Alarm::default() };
    Settings { channels, bearing, alarm, ..Settings::default() }
}

/// Returns the recipe of these settings for these classes.
///
/// # Errors
/// Settings that do not go together.
pub fn recipe(settings: &Settings, classes: &[String]) -> Result<Recipe, Error> {
    let Reading { channels, shaft, .. } = settings.reading(None)?;
    let recipe = settings.recipe(classes, shaft)?;
    Ok(Recipe { columns: channels, ..recipe })
}
