//! The configurations that the studies train, and that of a user who names no features.

use bearing_watch::plan::Kind;

use model::Error;
use model::identify::Structure;
use model::settings::{Alarm, Bearing, Dimensions, Geometry, Reading, Settings, Signals};
use model::trace::Channels;
use model::train::{Keep, ProjectionKind, Recipe, ShaftPlan, Shrink, Shrinkage};
use rig::BearingGeometry;

/// Velocity reference as input, current as output: thesis Table 4.1.
pub const REFERENCE_ORDER: Structure = Structure::new(2, 1, 2, 1, 1);

/// Spread of the sizes of a defect. In the logarithm of the drag, half the trained size is 1.4 deviations away.
pub const SIZE_SPREAD: f64 = 0.15;

/// Least squares, all of a, b, c, no projection, linear discriminant.
#[must_use]
pub fn all_parameters() -> Recipe {
    Recipe {
        columns: Channels::new("current_a", "velocity_ref_rad_s", "load_torque_nm"),
        ..Recipe::new(REFERENCE_ORDER)
    }
}

/// Logarithm of the drag and torque constant by the torque balance, and the order of the outer race; quadratic
/// discriminant with halved correlations; no gate.
///
/// Correlations estimated from twenty traces per class are uncertain. With full correlations the recipe fails under a
/// square reference in one of fifteen draws, with halved correlations in one of thirty draws of
/// [`Selection`](super::campaign::Purpose::Selection) traces.
#[must_use]
pub fn shaft() -> Recipe {
    let outer = BearingGeometry::THESIS.orders().outer;
    Recipe {
        shaft: Some(ShaftPlan::new(vec![("outer".into(), outer)])),
        features: ["drag_log", "inverse_kt", "order_outer"].map(String::from).to_vec(),
        discriminant: Kind::Quadratic,
        shrink: Shrink::To(Shrinkage { lambda: 0.0, gamma: 0.5 }),
        ..all_parameters()
    }
}

/// Least squares, only the a-parameters, PCA to two components, linear discriminant.
#[must_use]
pub fn a_only() -> Recipe {
    let projection = ProjectionKind::Pca { keep: Keep::Components(2), standardised: false };
    Recipe { features: vec!["a".into()], projection, ..all_parameters() }
}

/// Returns the settings of a user who names the rig's signals, with or without a load sensor, the bearing and the
/// false-alarm rate, and nothing else.
#[must_use]
pub fn default_settings(load: bool, false_alarm: f64) -> Settings {
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
pub fn default_recipe(settings: &Settings, classes: &[String]) -> Result<Recipe, Error> {
    let Reading { channels, shaft, .. } = settings.reading(None)?;
    let recipe = settings.recipe(classes, shaft)?;
    Ok(Recipe { columns: channels, ..recipe })
}
