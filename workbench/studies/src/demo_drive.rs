//! A drive to play with: a simulated motor with the detector in it. The user sets what is wrong in each run.
//!
//! ```text
//! healthy runs of other drives ─► training ─► model ─┐
//! what is wrong ─► records of a run of this drive ───┴─► detector and alarm (the caller's)
//! ```
//!
//! The drives differ from one another and from run to run ([`Units`]); the reference is a sine whose amplitude and
//! frequency differ too. The sensor of the temperature is a covariate.

use std::str::FromStr;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::campaign::run::labelled;
use crate::campaign::{Cell, Purpose, Recording};
use crate::recipes;
use model::Error;
use model::core::Embedded;
use model::trace::Trace;
use model::trace::labels::LabelledTrace;
use model::train::{Alarms, Recipe, train};
use rig::bearing::ADDED_FRICTION_NM_S_PER_RAD;
use rig::field::{Drive, Field, Temperature, Units};
use rig::{Condition, Defect, DefectKind, Scenario, simulate};

/// Drives of training, their runs, and the records of each run.
const DRIVES: u32 = 20;
const RUNS: u32 = 3;
/// Records, each a segment, of a run.
const RECORDS: u32 = 2;
/// Records of training.
pub const TRAINING: u32 = DRIVES * RUNS * RECORDS;
/// The features that training chooses of this drive, which takes most of its time; and those that a defect only raises.
const FEATURES: [&str; 6] = ["inverse_kt", "load_friction", "viscous", "drag", "order_outer", "order_inner"];
const RISING: [&str; 2] = ["viscous", "drag"];
/// Coldest and hottest grease, °C, and part of this range within a run.
const COLD_C: f64 = 20.0;
const HOT_C: f64 = 100.0;
const WITHIN: f64 = 0.05;
/// Sizes of a defect have this step, for which each has seeds of its own; the largest one.
const STEP: f64 = 1.0 / 1920.0;
const LARGEST: f64 = 2.0;

/// What a sensor does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// All sensors work.
    #[default]
    None,
    /// The angle stays where it was.
    StuckAngle,
    /// The load sensor gives no number.
    NoLoad,
    /// The current has the opposite sign.
    ReversedCurrent,
    /// The current is read 1.5 times too large.
    CurrentGain,
}

impl Fault {
    const ALL: [(&'static str, Self); 5] = [
        ("none", Self::None),
        ("stuck-angle", Self::StuckAngle),
        ("no-load", Self::NoLoad),
        ("reversed-current", Self::ReversedCurrent),
        ("current-gain", Self::CurrentGain),
    ];
}

/// What is wrong with the drive in a run, and how it is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrong {
    /// Size of a spall of the outer race, and of the roughness of a dry bearing: 1 is the full defect of the rig.
    pub spall: f64,
    pub roughness: f64,
    /// Load, relative to the usual one.
    pub load: f64,
    /// Temperature of the grease at the begin of the run.
    pub temperature_c: f64,
    /// What a sensor does.
    pub fault: Fault,
}

impl Default for Wrong {
    fn default() -> Self {
        Self { spall: 0.0, roughness: 0.0, load: 1.0, temperature_c: 50.0, fault: Fault::None }
    }
}

impl FromStr for Wrong {
    type Err = Error;

    /// Words such as `spall=0.5 load=1 fault=stuck-angle`; what is not named is as in a healthy drive.
    fn from_str(line: &str) -> Result<Self, Error> {
        let mut wrong = Self::default();
        for word in line.split_whitespace() {
            let refused = |why: String| Error::Usage(format!("“{word}”: {why}"));
            let (key, value) = word.split_once('=').ok_or_else(|| refused("give a name, = and a value".into()))?;
            let number = |from: f64, to: f64| {
                let value = value.parse().ok().filter(|value| (from..=to).contains(value));
                value.ok_or_else(|| refused(format!("{key} is a number from {from} to {to}")))
            };
            match key {
                "spall" => wrong.spall = number(0.0, LARGEST)?,
                "roughness" => wrong.roughness = number(0.0, LARGEST)?,
                "load" => wrong.load = number(0.0, 3.0)?,
                "temperature" => wrong.temperature_c = number(COLD_C, HOT_C)?,
                "fault" => {
                    let fault = Fault::ALL.iter().find(|(name, _)| *name == value);
                    let names = Fault::ALL.map(|(name, _)| name).join(", ");
                    wrong.fault = fault.ok_or_else(|| refused(format!("a fault is one of {names}")))?.1;
                }
                _ => return Err(refused("the names are spall, roughness, load, temperature and fault".into())),
            }
        }
        Ok(wrong)
    }
}

/// The model that the drive has, trained on healthy runs of other drives; `done` is called once for each record.
///
/// # Errors
/// Simulation or training fails.
pub fn learn(done: impl Fn() + Sync) -> Result<Embedded, Error> {
    let named = |names: &[&str]| names.iter().map(ToString::to_string).collect();
    let recipe = Recipe { automatic: false, features: named(&FEATURES), rising: named(&RISING), ..recipe()? };
    train(&healthy(done)?, &["healthy".into()], &recipe)?.embed()
}

/// Drives and runs of training.
fn runs() -> Vec<(u32, u32)> {
    (0..DRIVES).flat_map(|unit| (0..RUNS).map(move |run| (unit, run))).collect()
}

/// The records of training.
fn healthy(done: impl Fn() + Sync) -> Result<Vec<LabelledTrace>, Error> {
    let of_run = |&(unit, run): &(u32, u32)| {
        let mut random = ChaCha8Rng::seed_from_u64(u64::from(unit * RUNS + run));
        let temperature_c = random.random_range(COLD_C..HOT_C);
        let records = records(Purpose::Training, (unit, run), &Wrong { temperature_c, ..Wrong::default() });
        (0..RECORDS).for_each(|_| done());
        records
    };
    let records: Vec<Vec<Trace>> = runs().par_iter().map(of_run).collect::<Result<_, _>>()?;
    Ok(records.into_iter().flatten().map(|trace| LabelledTrace { trace, class: 0 }).collect())
}

/// That of a user who names signals, bearing, temperature, drives and runs.
fn recipe() -> Result<Recipe, Error> {
    let mut settings = recipes::default_settings(true, 0.01);
    settings.model.covariates = vec!["mean_temperature_c".into()];
    let mut recipe = recipes::default_recipe(&settings, &["healthy".into()])?.with_averaged_columns();
    let of_record = |name: &dyn Fn(&(u32, u32)) -> String| {
        runs().iter().flat_map(|run| std::iter::repeat_n(name(run), RECORDS as usize)).collect::<Vec<String>>()
    };
    recipe.validation.units = of_record(&|(unit, _)| format!("drive {unit}"));
    recipe.validation.groups = of_record(&|(unit, run)| format!("drive {unit}/{run}"));
    recipe.alarms = Alarms { by_run: true, other_drive: true, ..recipe.alarms };
    Ok(recipe)
}

/// The records of a run of the drive, from power-up to power-up.
///
/// # Errors
/// More runs than there are seeds.
pub fn run(wrong: &Wrong, run: u32) -> Result<Vec<Trace>, Error> {
    let mut records = records(Purpose::Validation, (0, run), wrong)?;
    records.iter_mut().for_each(|trace| wrong.fault.damage(trace));
    Ok(records)
}

fn records(purpose: Purpose, (unit, run): (u32, u32), wrong: &Wrong) -> Result<Vec<Trace>, Error> {
    let condition = Condition::named("temperature").ok_or_else(|| Error::Usage("no temperature".into()))?;
    let severity = (wrong.spall / STEP).round() * STEP;
    let defect = if severity > 0.0 { Defect { kind: DefectKind::Spall, severity } } else { Defect::HEALTHY };
    let cell = Cell { purpose, repetition: 0, condition, defect };
    let state = ((wrong.temperature_c - COLD_C) / (HOT_C - COLD_C)).clamp(0.0, 1.0 - WITHIN);
    let one = |record: u32| {
        let number = (unit * 1000 + run) * RECORDS + record;
        let seed = cell.seed(number)?;
        let mut scenario = cell.scenario(&Scenario::WITH_RESOLVER, seed);
        scenario.load_amplitude_nm *= wrong.load;
        scenario.load_fluctuation_nm *= wrong.load;
        scenario.motor.b_nm_s_per_rad += ADDED_FRICTION_NM_S_PER_RAD * wrong.roughness;
        // The same grease in all runs: of the field's scatter a part.
        let wide = Temperature::FIELD;
        let temperature = Temperature {
            state: [state, state + WITHIN],
            viscous_scatter: wide.viscous_scatter / 4.0,
            coulomb_nm: wide.coulomb_nm / 4.0,
            ..wide
        };
        scenario.field = Field { temperature: Some(temperature), units: Some(Units::FIELD), ..scenario.field };
        scenario.drive = Some(Drive { set: u32::from(purpose == Purpose::Training), unit, session: run });
        let trace = simulate(&scenario, seed).map_err(Error::other)?;
        Ok(labelled(Recording { cell, number, seed, trace }, 0).trace)
    };
    (0..RECORDS).map(one).collect()
}

impl Fault {
    fn damage(self, trace: &mut Trace) {
        let Some(motion) = &mut trace.motion else { return };
        let currents = [&mut trace.y, &mut motion.current_a];
        let scaled = |factor: f64| move |column: &mut Vec<f64>| column.iter_mut().for_each(|x| *x *= factor);
        match self {
            Self::None => {}
            Self::StuckAngle => {
                let first = motion.angle_rad.first().copied().unwrap_or_default();
                motion.angle_rad.fill(first);
            }
            Self::NoLoad => [&mut trace.u2, &mut motion.load_nm].into_iter().for_each(|load| load.fill(f64::NAN)),
            Self::ReversedCurrent => currents.into_iter().for_each(scaled(-1.0)),
            Self::CurrentGain => currents.into_iter().for_each(scaled(1.5)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model::core::{AlarmState, Finding, SegmentReport};

    /// What the detector says in runs of these, one after another.
    fn watched(model: &Embedded, runs: &[(u32, &str)]) -> (Vec<SegmentReport>, AlarmState) {
        let mut stream = model.stream();
        let (mut segments, mut number, mut last) = (vec![], 0, None);
        for (count, line) in runs {
            for _ in 0..*count {
                let records = run(&line.parse().expect("words"), number).expect("a run");
                number += 1;
                for (k, trace) in records.iter().enumerate() {
                    for (segment, alarm) in stream.run(trace, k + 1 == records.len()) {
                        segments.push(segment);
                        last = Some(alarm);
                    }
                }
            }
        }
        (segments, last.expect("a segment"))
    }

    #[test]
    fn the_drive_is_healthy_until_something_is_set() {
        let model = learn(|| ()).expect("a model");
        let is_healthy = |own: &&SegmentReport| own.verdict == Ok(Finding::Class(0));
        let (segments, alarm) = watched(&model, &[(12, "")]);
        let healthy = segments.iter().filter(is_healthy).count();
        // At the set rate of 1 %, four of 24 have a chance of 9e-5.
        assert!(segments.len() == 24 && healthy >= 21, "{healthy}");
        assert!(alarm.alarm.is_none(), "{alarm:?}");
        let ill = ["spall=0.5", "roughness=1", "spall=0.25 temperature=90 load=1.2"];
        for line in ill {
            let (segments, alarm) = watched(&model, &[(2, ""), (2, line)]);
            let departing = segments[4..].iter().filter(|own| !is_healthy(own)).count();
            assert!(departing >= 3, "{line}: {departing} of 4");
            assert!(alarm.alarm.is_some(), "{line}: {alarm:?}");
        }
        for fault in ["stuck-angle", "no-load", "reversed-current"] {
            let (segments, _) = watched(&model, &[(1, &format!("fault={fault}"))]);
            assert!(segments.iter().all(|own| own.verdict.is_err()), "{fault}: {:?}", segments[0].verdict);
        }
        let (segments, _) = watched(&model, &[(1, "fault=current-gain")]);
        assert!(!segments.iter().any(|own| is_healthy(&own)), "{:?}", segments[0].verdict);
    }

    #[test]
    fn training_chooses_these_features() {
        let trained = train(&healthy(|| ()).expect("records"), &["healthy".into()], &recipe().expect("a recipe"));
        let recipe = trained.expect("trained").recipe;
        assert_eq!(
            (&recipe.features[..], &recipe.rising[..]),
            (&FEATURES.map(String::from)[..], &RISING.map(String::from)[..])
        );
    }

    #[test]
    fn words_that_set_nothing_are_refused() {
        let wrong: Wrong = "spall=0.5  fault=stuck-angle temperature=20".parse().expect("words");
        assert_eq!(wrong, Wrong { spall: 0.5, fault: Fault::StuckAngle, temperature_c: 20.0, ..Wrong::default() });
        for (line, word) in [("spall", "name"), ("spall=-1", "0 to 2"), ("load=NaN", "0 to 3"), ("x=1", "the names")] {
            let error = line.parse::<Wrong>().expect_err("refused").to_string();
            assert!(error.contains(word), "{error}");
        }
        assert!("fault=fire".parse::<Wrong>().expect_err("refused").to_string().contains("no-load"));
    }
}
