//! The one configuration for the actuator.

use bearing_watch::Park;
use bearing_watch::plan::Kind;

use super::sets::class_names;
use crate::recipes;
use model::Error;
use model::identify::Structure;
use model::trace::Channels;
use model::train::{Alarms, Recipe, ShaftPlan, Shrink, Shrinkage};
use rig::BearingGeometry;

/// Friction at a usual speed and load, and the orders of both races.
pub const FEATURES: [&str; 3] = ["drag_log", "order_inner", "order_outer"];

/// Set false-alarm rate of the gate.
pub const FALSE_ALARM: f64 = 0.01;

/// Structure of the regression, none of whose parameters is a feature.
const STRUCTURE: Structure = Structure::new(2, 1, 2, 1, 1);

/// Features [`FEATURES`], quadratic discriminant with halved correlations, without a gate.
#[must_use]
pub fn classes_alone() -> Recipe {
    let orders = BearingGeometry::THESIS.orders();
    let races = vec![("inner".into(), orders.inner), ("outer".into(), orders.outer)];
    Recipe {
        columns: Channels::new("current_a", "velocity_ref_rad_s", "load_torque_nm"),
        park: Some(Park::Standard),
        shaft: Some(ShaftPlan::new(races)),
        features: FEATURES.map(String::from).to_vec(),
        discriminant: Kind::Quadratic,
        shrink: Shrink::To(Shrinkage { lambda: 0.0, gamma: 0.5 }),
        ..Recipe::new(STRUCTURE)
    }
}

/// The same with a spread of sizes, and a novelty gate at [`FALSE_ALARM`].
#[must_use]
pub fn recipe() -> Recipe {
    let alarms = Alarms { healthy: Some(0), false_alarm: FALSE_ALARM, required: true, ..Alarms::default() };
    Recipe { alarms, size_spread: recipes::SIZE_SPREAD, ..classes_alone() }
}

/// What a user gets who names his signals, the bearing and the false-alarm rate.
///
/// # Errors
/// None that is known: the settings go together.
pub fn by_default() -> Result<Recipe, Error> {
    recipes::default_recipe(&recipes::default_settings(true, FALSE_ALARM), &class_names())
}
