//! What one record can tell: the rate at which an ideal detector, which knows the distribution of the rig's parameters,
//! finds a spall at 1 % false alarms, beside what the detector finds. [`roughness`] does the same for roughness.
//!
//! ```text
//! P = P(χ²(2H, λ) > χ²₀.₉₉),   λ = Σ_h λ_h over H harmonics, H the number that detects most                (1)
//! P = Φ(√μ − 2.33),   1/μ = 1/μ_noise + 1/μ_healthy                                                       (2)
//! P = P(χ²(2H + 1, λ + μ) > χ²₀.₉₉)                                                                        (3)
//! μ_noise = Σ_k m²/S(0),   μ_healthy = Δᵀ C⁻¹ Δ                                                           (4)
//! ```
//!
//! (1) is the order alone: the matched filter of pulses whose phases are not known, with the non-centrality of
//! [`energy`]. If the balls slip, 1 % is divided by the number of slips that the record can tell apart. (2) is friction
//! alone: the mean drag m of the pulses, whose sign is known, against what noise and healthy drives do to it. C is the
//! covariance of B, Tc and the flux of healthy drives, Δ what the spall adds to them. (3) is both as independent
//! evidence. The bound is the largest of the three, averaged over records. It assumes that the detector knows every
//! parameter of the record but friction, phase and slip, and loses no sample; a load that is measured is exact. Under
//! cogging, angle errors, a bad load sensor, compliance or a current chain the noise at the bearing's order is not that
//! of the sensors: it is what the core finds there in other healthy records, with the filters that training has chosen.
//!
//! A detector that searches the slip, compares phases over a few blocks and does not know the noise finds less than
//! (1): the module `search` simulates its statistic. [`classes`] bounds the error of three classes.

pub mod classes;
pub mod energy;
mod power;
pub mod render;
pub mod roughness;
mod search;

use bearing_watch::FrictionTerm;
use bearing_watch::model::{Balance, ShaftConstants};
use bearing_watch::plan::RunTime;
use bearing_watch::shaft::ShaftEstimate;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};
use statrs::statistics::Statistics;

use super::Settings;
use super::recipe::{FALSE_ALARM, SHARE, recipe};
use super::rows::{CLASS_SIZES, COLUMNS, Row};
use super::run::{self, Draw};
use super::tally::{Tally, rate};
use crate::campaign::run::traces;
use classes::ClassBound;
use energy::Spall;
use model::Error;
use model::evaluate::Rate;
use model::trace::labels::LabelledTrace;
use model::train::train;
use power::{by_harmonics, order_power};
use rig::field::LoadMeasurement;
use rig::{Condition, Defect, DefectKind, Scenario, simulate};
use roughness::{Population, RoughnessBound};
use search::Search;

/// Rows that are bounded by default: those that find little, and MIX for comparison.
pub const ROWS: [&str; 19] = [
    "mix",
    "temperature",
    "temperature-known",
    "load-friction",
    "stribeck",
    "cogging",
    "angle-errors",
    "bad-load-sensor",
    "no-load-sensor",
    "payload",
    "current-chain",
    "slip",
    "slip-300-turns",
    "duty-one-way",
    "duty-constant",
    "field-sine",
    "field-stiff",
    "field-duties",
    "field-any",
];

/// Healthy records over which a bound is averaged, and by which the noise of the field is measured.
const RECORDS: u32 = 60;
/// Healthy drives from which C of (4) is estimated.
const DRIVES: u64 = 2000;

/// The bound and what is found, for one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Size of the spall.
    pub severity: f64,
    /// Mean non-centrality of three harmonics.
    pub non_centrality: f64,
    /// (1), (2), and the largest of (1) to (3), each averaged over records.
    pub order: f64,
    /// The order alone by the statistic of the detector, averaged over records.
    pub searched: f64,
    /// (2).
    pub friction: f64,
    /// The largest of (1) to (3).
    pub all: f64,
    /// Found by the gate with the order alone.
    pub found_by_order: Option<Rate>,
    /// Found by the detector of the table.
    pub found: Option<Rate>,
}

/// A row with its bounds, one a size.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounded {
    /// Name of the row.
    pub row: String,
    /// Deviation of an amplitude of the first harmonic, N·m.
    pub floor_nm: f64,
    /// The same as the core measures it with trained filters.
    pub core_floor_nm: f64,
    /// One for each spall of [`COLUMNS`].
    pub bounds: Vec<Bound>,
    /// Standard deviation of the core's error of the viscous friction in healthy records, root mean square, N·m·s/rad.
    pub viscous_error: f64,
    /// One for each roughness of [`COLUMNS`]; none if no temperature changes the friction.
    pub roughness: Vec<RoughnessBound>,
    /// One for each of [`CLASS_SIZES`]; none if the row has no discriminant.
    pub classes: Vec<ClassBound>,
}

/// Bounds a row, and judges the gate with the order alone and that of the recipe.
///
/// # Errors
/// Returns an error if simulation or training fails.
pub fn bound(row: &Row, settings: &Settings) -> Result<Bounded, Error> {
    let order = Settings { features: vec!["order_outer".into()], ..settings.clone() };
    let by_order = found(&Row { classes: false, ..*row }, &order)?;
    let by_all = found(row, settings)?;
    let (ShaftConstants { tracking, balance, .. }, healthy) = healthy_estimates(row, settings.healthy_training)?;
    let core_floors = measured_floors(&healthy);
    let core_floor_nm = root_mean_square(&core_floors);
    let spalls = spalls(row, if is_disturbed(&row.judged) { &core_floors } else { &[] })?;
    let population = healthy_precision(row);
    let search = Search::new(&tracking, &spalls);
    let pooled = |tallies: Vec<Tally>| (!tallies.is_empty()).then(|| rate(&tallies));
    let of = |draws: &[Draw], kind: DefectKind, severity: f64| {
        let column = COLUMNS.iter().position(|own| *own == Defect { kind, severity })?;
        pooled(draws.iter().filter_map(|own| own.gate.as_ref().ok()).map(|own| own[column]).collect())
    };
    let each = |severity: f64| {
        let parts: Vec<[f64; 3]> = spalls.par_iter().map(|spall| powers(spall, population, severity)).collect();
        let mean = |k: usize| parts.iter().map(|own| own[k]).sum::<f64>() / parts.len() as f64;
        let energies = spalls.iter().map(|spall| spall.energy(severity, 3)).sum::<f64>();
        Bound {
            severity,
            non_centrality: energies / spalls.len() as f64,
            order: mean(0),
            searched: search.as_ref().map_or(f64::NAN, |own| own.powers(severity, &[FALSE_ALARM])[0]),
            friction: mean(1),
            all: mean(2),
            found_by_order: of(&by_order, DefectKind::Spall, severity),
            found: of(&by_all, DefectKind::Spall, severity),
        }
    };
    let floor_nm = root_mean_square(&spalls.iter().map(|spall| spall.floor_nm).collect::<Vec<_>>());
    let viscous_errors = viscous_errors(row, &healthy, &balance)?;
    let drives = Population::of(row);
    let rough = |drives: &Population, severity: f64| {
        let with_error = drives.powers(severity, &viscous_errors, &[FALSE_ALARM, SHARE]);
        RoughnessBound {
            severity,
            exact: drives.powers(severity, &[0.0], &[FALSE_ALARM])[0],
            with_error: with_error[0],
            at_share: with_error[1],
            found: of(&by_all, DefectKind::Roughness, severity),
        }
    };
    let roughness = drives.iter().flat_map(|own| sizes(DefectKind::Roughness).into_iter().map(|size| rough(own, size)));
    let classes = |(place, severity): (usize, f64)| {
        let known = by_all.iter().filter_map(|own| own.classes.as_ref()?.as_ref().ok());
        let found = pooled(known.map(|own| own[place]).collect());
        let friction = drives.as_ref().map(|own| (own, &viscous_errors[..]));
        search.as_ref().map(|search| ClassBound::of(severity, (&spalls, search), friction, found))
    };
    let sizes_of_classes = CLASS_SIZES.into_iter().enumerate().filter(|_| row.classes);
    Ok(Bounded {
        row: row.name(),
        floor_nm,
        core_floor_nm,
        bounds: sizes(DefectKind::Spall).into_iter().map(each).collect(),
        viscous_error: root_mean_square(&viscous_errors),
        roughness: roughness.collect(),
        classes: sizes_of_classes.filter_map(classes).collect(),
    })
}

/// The sizes of a defect in [`COLUMNS`].
fn sizes(kind: DefectKind) -> Vec<f64> {
    COLUMNS.iter().filter(|own| own.kind == kind).map(|own| own.severity).collect()
}

/// Whether more than the noise of the sensors disturbs the bearing's order under a condition.
fn is_disturbed(condition: &Condition) -> bool {
    condition.field.is_some_and(|field| {
        matches!(field.load, LoadMeasurement::Sensor(_))
            || field.magnetics.is_some()
            || field.resolver.is_some()
            || field.mechanics.is_some()
            || field.current_chain.is_some()
    })
}

/// All draws of a row.
fn found(row: &Row, settings: &Settings) -> Result<Vec<Draw>, Error> {
    (settings.first..settings.first + settings.draws).map(|number| run::draw(row, number, settings)).collect()
}

fn root_mean_square(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

/// What full-size spalls would add to healthy records of the row; `floors_nm` are those measured in them, if they are
/// to replace the noise of the sensors.
fn spalls(row: &Row, floors_nm: &[f64]) -> Result<Vec<Spall>, Error> {
    let cell = row.validation(0, Defect::HEALTHY);
    let each = |number: u32| -> Result<Spall, Error> {
        let seed = cell.seed(number)?;
        let (scenario, values) = row.drive(seed);
        let floor_nm = floors_nm.get(number as usize).copied();
        Ok(Spall::of(&scenario, &values, &simulate(&scenario, seed).map_err(Error::other)?, floor_nm))
    };
    (0..RECORDS).into_par_iter().map(each).collect()
}

/// Constants of a detector that was trained on so many healthy records, and what the core estimates with it in
/// others.
fn healthy_estimates(row: &Row, count: u32) -> Result<(ShaftConstants<RunTime>, Vec<ShaftEstimate<RunTime>>), Error> {
    let own = recipe(&row.trained, &["order_outer".into()]);
    let healthy = traces(&[(row.training(0, Defect::HEALTHY), 0)], count)?;
    let detector = train(&healthy, &["healthy".into()], &own)?;
    let not_watched = || Error::Training("the detector does not watch the shaft".into());
    let constants = detector.parts.shaft.as_ref().map(|(_, shaft)| shaft.clone()).ok_or_else(not_watched)?;
    let detector = detector.embed()?;
    let records = traces(&[(row.validation(0, Defect::HEALTHY), 0)], RECORDS)?;
    let estimate = |record: &LabelledTrace| {
        let report = detector.whole(&record.trace);
        report.shaft().cloned().ok_or_else(|| Error::trace(&record.trace.id, "the shaft was not watched"))
    };
    Ok((constants, records.par_iter().map(estimate).collect::<Result<_, _>>()?))
}

/// Deviation of the outer order's amplitude in each healthy record, as the core measures it, N·m.
fn measured_floors(healthy: &[ShaftEstimate<RunTime>]) -> Vec<f64> {
    let orders = || healthy.iter().map(|own| own.orders().first().copied().unwrap_or_default());
    // The prominence is the noise at the order itself, relative to that of the control orders.
    let excess = orders().map(|order| f64::from(order.prominence)).sum::<f64>() / healthy.len() as f64;
    let scale = Scenario::STANDARD.motor.kt_nm_per_a * excess.max(1.0).sqrt();
    orders().map(|order| scale * f64::from(order.deviation).max(1e-6)).collect()
}

/// Standard deviation of the error of the core's viscous friction in each record: as it is stated, times what the
/// errors of all records exceed that, but for their mean difference.
fn viscous_errors(row: &Row, healthy: &[ShaftEstimate<RunTime>], balance: &Balance) -> Result<Vec<f64>, Error> {
    let cell = row.validation(0, Defect::HEALTHY);
    let (mut stated, mut relative) = (vec![], vec![]);
    for (number, estimate) in (0..).zip(healthy) {
        let (scenario, values) = row.drive(cell.seed(number)?);
        let kt = values.motor(&scenario.motor).kt_nm_per_a;
        let (value, variance) = balance.without_prior(&estimate.friction, FrictionTerm::Viscous);
        if variance > 0.0 {
            let deviation = kt * f64::from(variance).sqrt();
            relative.push((kt * f64::from(value) - roughness::mean_viscous(&scenario, &values)) / deviation);
            stated.push(deviation);
        }
    }
    let excess = relative.population_std_dev();
    Ok(stated.into_iter().map(|deviation| excess * deviation).collect())
}

/// C⁻¹ of (4), by healthy drives; `None` if friction does not vary.
fn healthy_precision(row: &Row) -> Option<Matrix3<f64>> {
    let of = |seed: u64| {
        let (scenario, values) = row.drive(seed);
        let motor = values.motor(&scenario.motor);
        let coulomb = values.temperature.map_or(0.0, |own| own.coulomb_nm)
            + values.stribeck.map_or(0.0, |own| own.coulomb_nm)
            // At the mean magnitude of the load's sine.
            + values.load_friction.map_or(0.0, |own| own.coefficient * scenario.load_amplitude_nm * 0.64);
        Vector3::new(1e3 * motor.b_nm_s_per_rad, coulomb, motor.kt_nm_per_a)
    };
    let drives: Vec<Vector3<f64>> = (0..DRIVES).map(of).collect();
    let mean = drives.iter().sum::<Vector3<f64>>() / DRIVES as f64;
    let spread = drives.iter().map(|own| (own - mean) * (own - mean).transpose()).sum::<Matrix3<f64>>() / DRIVES as f64;
    // A part in 10⁴ keeps what does not vary invertible.
    let least = Matrix3::from_diagonal(&Vector3::new(1e-5, 1e-6, 5e-6).map(|x| x * x));
    (spread[(1, 1)] > 1e-12).then(|| (spread + least).try_inverse()).flatten()
}

/// (1), (2), and the largest of (1) to (3).
fn powers(spall: &Spall, population: Option<Matrix3<f64>>, severity: f64) -> [f64; 3] {
    let square = severity * severity;
    let added = Vector3::new(0.0, severity * energy::MEAN_NM, 0.0);
    let healthy = population.map_or(0.0, |inverse| 1.0 / (added.transpose() * inverse * added)[(0, 0)]);
    let friction = 1.0 / (1.0 / (square * spall.drag) + healthy); // (2)
    let normal = Normal::standard();
    let by_friction = normal.cdf(friction.sqrt() - normal.inverse_cdf(1.0 - FALSE_ALARM));
    let order = order_power(spall, severity, FALSE_ALARM); // (1)
    let law = |harmonics: usize| (2 * harmonics + 1, spall.energy(severity, harmonics) + friction);
    let both = by_harmonics(spall, FALSE_ALARM, law); // (3)
    [order, by_friction, order.max(by_friction).max(both)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::rows::named;

    /// Slow samples have less noise than those at the usual speed, at which an eighth of the pulses has an energy of
    /// a hundred.
    #[test]
    fn a_sixteenth_of_a_spall_under_mix_is_not_hidden_by_the_sensors() {
        let row = named(&["mix".into()]).expect("known")[0];
        let spalls = spalls(&row, &[]).expect("simulates");
        let energy = spalls.iter().map(|own| own.harmonics[..3].iter().sum::<f64>()).sum::<f64>() / 64.0 / 60.0;
        println!("non-centrality {energy}");
        assert!((100.0..300.0).contains(&energy), "{energy}");
        assert!(healthy_precision(&row).is_none());
        let rate = |severity| spalls.iter().map(|own| powers(own, None, severity)[0]).sum::<f64>() / 60.0;
        assert!(rate(0.0625) > 0.8 && rate(0.0625) < 1.0 && rate(1.0 / 64.0) < 0.3, "{}", rate(0.0625));
    }

    #[test]
    fn what_disturbs_the_order_is_told_by_the_effects() {
        let found: Vec<&str> = Condition::all().filter(is_disturbed).map(|own| own.name).collect();
        let single = ["cogging", "angle-errors", "bad-load-sensor", "payload", "current-chain"];
        let all = ["field-sine", "field-duties", "field-any", "field-stiff"];
        assert_eq!(found, [&single[..], &all[..]].concat());
    }

    #[test]
    fn friction_that_varies_hides_the_drag() {
        let row = named(&["temperature".into()]).expect("known")[0];
        let precision = healthy_precision(&row).expect("varies");
        // Tc is uniform up to 20 mN·m and independent of the rest: a deviation of 5.8 mN·m.
        assert!((precision[(1, 1)].recip().sqrt() / 5.77e-3 - 1.0).abs() < 0.05, "{precision}");
    }
}
