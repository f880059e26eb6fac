//! The one configuration of all rows. To try other features, change [`GATE_FEATURES`] and [`FEATURES`], or pass others
//! in [`Settings::features`](super::Settings::features).

use super::rows::Row;
use crate::recipes;
use model::Error;
use model::identify::Structure;
use model::train::{Alarms, Recipe, ShaftPlan};
use rig::field::LoadMeasurement;
use rig::{Condition, Scenario};

/// Features of the detector: the torque constant, the friction that varies with load and with velocity, that at a usual
/// velocity and load, and the order of the outer race.
///
/// On one scale each: what a value adds to its logarithm is skewed, while the laws of runs are symmetric; and defects
/// of half size would not lie on the line from healthy to full size, as the classes assume.
pub const FEATURES: [&str; 5] = ["inverse_kt", "load_friction", "viscous", "drag", "order_outer"];

/// Features of a gate of records, whose laws may be skewed. The friction that varies with velocity is there as its
/// logarithm too: the viscosity of grease falls by the same factor for each degree, so that the logarithm scatters
/// alike in cold and in warm grease; but an error of the estimate scatters alike on the plain scale.
pub const GATE_FEATURES: [&str; 6] = ["inverse_kt", "load_friction", "viscous_log", "viscous", "drag", "order_outer"];

/// The friction that a defect only raises, as it only raises the order, on any scale.
pub const RISING: [&str; 2] = ["viscous", "drag"];

/// The covariate of a row that knows the temperature.
pub const TEMPERATURE: &str = "mean_temperature_c";

/// Terms that do not exist if the load is not measured, and friction, which then contains the load.
const NEED_LOAD: [&str; 4] = ["inverse_kt", "load_friction", "viscous", "drag"];

/// Largest slip that is searched: the rig's bearings slip by up to 2 %.
const SLIP: f64 = 0.022;

/// Set false-alarm rate of the gate.
pub const FALSE_ALARM: f64 = 0.01;

/// Structure of the regression if the load is not measured: no terms of u2.
const WITHOUT_LOAD: Structure = Structure::new(2, 1, 0, 1, 1);

/// Returns the recipe for the drives of a condition; [`FEATURES`] if `features` is empty.
///
/// The recipe is the same for all conditions, except that a drive without a load sensor has no channel of the load,
/// and none of the features that need it.
#[must_use]
pub fn recipe(condition: &Condition, features: &[String]) -> Recipe {
    let alarms = Alarms { healthy: Some(0), false_alarm: FALSE_ALARM, required: true, ..Alarms::default() };
    let mut features = chosen(features, &FEATURES);
    let load = has_load_sensor(condition);
    features.retain(|name| load || !NEED_LOAD.contains(&term(name)));
    let rising = features.iter().filter(|name| RISING.contains(&term(name))).cloned().collect();
    let mut base = Recipe { rising, size_spread: recipes::SIZE_SPREAD, ..recipes::shaft() };
    if let Some(shaft) = &mut base.shaft {
        shaft.slip = SLIP;
    }
    if load {
        return Recipe { features, alarms, ..base };
    }
    let shaft = base.shaft.clone().map(|plan| ShaftPlan { load: false, ..plan });
    Recipe { features, alarms, shaft, structure: WITHOUT_LOAD, ..base }
}

/// Returns the features that are asked for, or the usual ones if there are none.
#[must_use]
pub fn chosen(asked: &[String], usual: &[&str]) -> Vec<String> {
    if asked.is_empty() { usual.iter().map(ToString::to_string).collect() } else { asked.to_vec() }
}

/// The term of a feature, which may also be its logarithm or its score.
fn term(feature: &str) -> &str {
    let mut scales = ["_log", "_score"].into_iter();
    scales.find_map(|scale| feature.strip_suffix(scale)).unwrap_or(feature)
}

/// Returns the recipe for a row's gate of healthy records; [`GATE_FEATURES`] if `features` is empty.
#[must_use]
pub fn of_gate(row: &Row, features: &[String]) -> Recipe {
    of_row(row, features, &GATE_FEATURES)
}

/// Returns the recipe for a row's classes; [`FEATURES`] if `features` is empty.
#[must_use]
pub fn of_classes(row: &Row, features: &[String]) -> Recipe {
    of_row(row, features, &FEATURES)
}

fn of_row(row: &Row, features: &[String], usual: &[&str]) -> Recipe {
    let recipe = recipe(&row.trained, &chosen(features, usual));
    if !row.known {
        return recipe;
    }
    Recipe { covariates: vec![TEMPERATURE.into()], ..recipe }.with_averaged_columns()
}

/// Returns the recipe of a user who names his signals, the bearing and the false-alarm rate, and nothing else.
///
/// # Errors
/// Settings that do not go together.
pub fn by_default(row: &Row, classes: &[String]) -> Result<Recipe, Error> {
    let mut settings = recipes::default_settings(has_load_sensor(&row.trained), FALSE_ALARM);
    if row.known {
        settings.model.covariates = vec![TEMPERATURE.into()];
    }
    recipes::default_recipe(&settings, classes)
}

/// Returns whether the drives of a condition measure the load.
#[must_use]
pub fn has_load_sensor(condition: &Condition) -> bool {
    condition.apply(Scenario::STANDARD, 0).field.load != LoadMeasurement::Absent
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::rows::named;

    #[test]
    fn only_the_load_differs_between_conditions() {
        let mix = recipe(&Condition::MIX, &[]);
        assert_eq!(mix.features, FEATURES);
        for condition in Condition::FIELD {
            let own = recipe(&condition, &[]);
            let load = has_load_sensor(&condition);
            assert_eq!(load, condition.name != "no-load-sensor");
            assert_eq!(own.shaft.as_ref().map(|plan| plan.load), Some(load));
            if load {
                assert_eq!(format!("{own:?}"), format!("{mix:?}"), "{}", condition.name);
            } else {
                assert_eq!(own.features, ["order_outer"]);
                assert!(own.rising.is_empty());
            }
        }
        assert!(Condition::AXES.iter().all(|condition| !has_load_sensor(condition)));
        let known = of_gate(&named(&["temperature-known".into()]).expect("a row")[0], &[]);
        assert_eq!(known.features, GATE_FEATURES);
        assert_eq!((known.rising, known.covariates), (chosen(&[], &GATE_FEATURES[2..5]), chosen(&[], &[TEMPERATURE])));
        let classes = of_classes(&named(&["field-sine".into()]).expect("a row")[0], &[]);
        assert_eq!((classes.features, classes.rising), (chosen(&[], &FEATURES), chosen(&[], &FEATURES[2..4])));
        let asked = ["order_outer".to_string()];
        assert_eq!(recipe(&Condition::MIX, &asked).features, asked);
        let asked = ["viscous".to_string(), "drag_score".into(), "inverse_kt_log".into()];
        let known = of_gate(&named(&["temperature-known".into()]).expect("a row")[0], &asked);
        assert_eq!((&known.features[..], &known.rising[..]), (&asked[..], &asked[..2]));
        let none = named(&["no-load-sensor".into()]).expect("a row")[0];
        assert!(of_gate(&none, &asked).features.is_empty());
    }
}
