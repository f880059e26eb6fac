//! The source's method on recordings of the actuator: iv4, the a-parameters (a and b if there is one a only, thesis
//! §3.3), two principal components of all classes, linear discriminants.

use bearing_watch::plan::Kind;
use rayon::prelude::*;

use crate::literal::{Judged, Rule, principal};
use crate::tables::chapter5::published::{Input, Published};
use model::Error;
use model::core::features;
use model::identify::{Method, Structure, estimate};
use model::trace::Trace;
use model::trace::prepare::decimate;
use model::train::FeatureTable;
use rig::ema::EmaTrace;

/// Rows of the control rate per row of the log at Moog, and rows for which a value is held there.
const LOGGED: (usize, usize) = (10, 3);

/// u1 of a recording.
#[must_use]
pub fn first_input(recorded: &EmaTrace, input: Input) -> Vec<f64> {
    let EmaTrace { position_ref_m, position_m, velocity_ref_rad_s, .. } = recorded;
    match input {
        Input::Position => position_ref_m.clone(),
        Input::Error => position_ref_m.iter().zip(position_m).map(|(command, measured)| command - measured).collect(),
        Input::Velocity => velocity_ref_rad_s.clone(),
    }
}

/// A recording at the control rate as the source had it from Moog: logged at 1200 Hz with values held for three rows,
/// of which one is kept behind an anti-alias filter.
#[must_use]
pub fn logged(recorded: &EmaTrace, input: Input) -> Trace {
    let (every, hold) = LOGGED;
    let each = |column: &[f64]| {
        let held = (0..column.len().div_ceil(every)).map(|row| column[(row - row % hold) * every]);
        decimate(&held.collect::<Vec<_>>(), hold)
    };
    let [y, u1, u2] =
        [&recorded.current_a, &first_input(recorded, input), &recorded.load_torque_nm].map(|column| each(column));
    Trace { y, u1, u2, ..Trace::default() }
}

/// Features of a set, and the fits of its healthy traces, in ascending order.
#[derive(Clone, Debug)]
pub struct Estimated {
    /// All raw features.
    pub table: FeatureTable,
    /// Fits (Eq. 3.2) of the healthy traces, %.
    pub fits: Vec<f64>,
}

/// Estimates a set; a trace has its class, 0 for healthy.
///
/// # Errors
/// Returns an error if a trace cannot be estimated.
pub fn estimated(
    set: &[(usize, Trace)],
    names: &[String],
    (order, method): (Structure, Method),
) -> Result<Estimated, Error> {
    // The results are collected first, so that the returned error is always that of the first bad trace.
    let all: Vec<_> = set.par_iter().map(|(_, trace)| estimate(trace, order, method)).collect();
    let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
    let classes: Vec<usize> = set.iter().map(|(class, _)| *class).collect();
    let healthy = all.iter().zip(&classes).filter(|(_, class)| **class == 0);
    let mut fits: Vec<f64> = healthy.map(|(estimate, _)| estimate.fit_percent).collect();
    fits.sort_by(f64::total_cmp);
    let table = FeatureTable::exact(all.iter().map(features::vector).collect(), classes, names.to_vec());
    Ok(Estimated { table, fits })
}

/// The groups of parameters that are features in the source.
#[must_use]
pub const fn groups(order: Structure) -> &'static [&'static str] {
    if order.na == 1 { &["a", "b"] } else { &["a"] }
}

/// Names and places of features of a structure; of no group, all parameters.
///
/// # Errors
/// Returns an error for an unknown group.
pub fn choose(order: Structure, groups: &[&str]) -> Result<(Vec<String>, Vec<usize>), Error> {
    let asked: Vec<String> = groups.iter().map(ToString::to_string).collect();
    let places = features::choose(order, &asked)?;
    let all = features::all_names(order);
    Ok((places.iter().map(|&k| all[k].clone()).collect(), places))
}

/// Decisions of the source's method on a validation set.
///
/// # Errors
/// Returns an error if a trace cannot be estimated or features are singular.
pub fn judge(
    [training, validation]: [&[(usize, Trace)]; 2],
    classes: &[String],
    model: &Published,
) -> Result<Judged, Error> {
    let of = |set| estimated(set, classes, (model.order, Method::Iv4));
    let (names, places) = choose(model.order, groups(model.order))?;
    let [training, validation] = [of(training)?, of(validation)?].map(|own| own.table.select(&places));
    Ok(Rule::train(&training, &names, principal(names.len()), Kind::Linear)?.judge(&validation))
}
