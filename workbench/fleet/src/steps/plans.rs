//! The constants of the detector that computes the features of parts.

use std::path::Path;

use crate::plan_files::read_plan;
use crate::{Origin, Part, Plan};
use model::Error;
use model::session::{Selection, prepare};
use model::settings::Settings;
use model::trace::{Channels, Preparation};
use model::train::{self, Recipe, ShaftPlan};

/// The plan of another part, or of the file beside one, for the same channels and structure.
pub(super) fn known(
    settings: &Settings,
    path: &Path,
    (channels, preparation): (&Channels, Preparation),
    shaft: Option<&ShaftPlan>,
) -> Result<Plan, Error> {
    let is_beside = path.extension().is_some_and(|end| end == "json");
    let plan = if is_beside { read_plan(path)? } else { Part::open(path)?.plan };
    let (model, by) = (&settings.model, &settings.validation);
    let differs = [
        ("the channels", plan.channels != *channels),
        ("the order", plan.structure() != model.structure()?),
        ("--block-mean or --decimate", plan.preparation() != preparation),
        ("the orders of the bearing", !are_alike(plan.recipe().shaft.as_ref(), shaft)),
        ("--segment", model.segment.is_some_and(|segment| segment != plan.segment_samples())),
        ("--method", plan.recipe().estimation.method != model.method.unwrap_or_default().core()),
        ("--unit", plan.unit != by.unit),
        ("--group", plan.group != by.group),
    ];
    match differs.iter().find(|(_, differs)| *differs) {
        Some((what, _)) => {
            Err(Error::content(path, "plan", format!("{what} of this command are others than the plan's")))
        }
        None => Ok(plan),
    }
}

/// The plan with constants from these traces.
pub(super) fn new_plan(
    settings: &Settings,
    (selection, classes, some): (&Selection, &[String], &[(String, String)]),
    (channels, preparation): (Channels, Preparation),
    shaft: Option<ShaftPlan>,
) -> Result<Plan, Error> {
    let traces = selection.read(classes, some)?;
    let recorded_interval_s = traces.iter().find_map(|own| own.trace.interval_s).unwrap_or(0.0);
    let prepared = prepare(&traces, preparation)?;
    let (model, structure) = (&settings.model, settings.model.structure()?);
    let recipe = Recipe {
        columns: channels.clone(),
        park: settings.channels.park(&channels)?,
        shaft,
        estimation: model.estimation(structure, classes, settings.alarm.healthy_class(classes)?)?,
        features: model.features.clone(),
        covariates: model.covariates.clone(),
        ..Recipe::new(structure)
    };
    let found = train::estimating(&prepared, classes, &recipe)?;
    let (unit, group) = (settings.validation.unit.clone(), settings.validation.group.clone());
    let origin = Origin { channels, preparation, recorded_interval_s, unit, group };
    let mut plan = Plan::new(&found, classes, origin)?;
    plan.usual = train::usual_errors(&prepared, classes, &found)?;
    Ok(plan)
}

/// Whether the orders are the same but for the last digits, which a number as text may lose.
fn are_alike(one: Option<&ShaftPlan>, other: Option<&ShaftPlan>) -> bool {
    let alike = |((one, own), (other, order)): (&(String, f64), &(String, f64))| {
        one == other && (own - order).abs() <= 1e-9 * order.abs()
    };
    match one.zip(other) {
        Some((one, other)) => one.orders.len() == other.orders.len() && one.orders.iter().zip(&other.orders).all(alike),
        None => one.is_none() && other.is_none(),
    }
}
