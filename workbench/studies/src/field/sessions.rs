//! Drives and days: gates and alarms of a fleet, judged on the sessions of other drives.
//!
//! Every constant of a drive differs from drive to drive and from day to day
//! ([`Units`](rig::field::Units)). For each draw, 20 drives of 10 sessions are recorded, one healthy record a
//! session, and gates are trained for the next session of another drive: groups are drives
//! ([`Alarms::by_run`](model::train::Alarms::by_run)). They are judged on 10 sessions of 20 other drives.
//!
//! The alarm of the first gate is judged on long sequences: each judged drive repeats its sessions in random order,
//! with one segment a session. A sequence ends with its first alarm; the mean time between false alarms is the number
//! of sessions by the number of alarms.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::recipe::recipe;
use super::render::percent;
use super::tally::{Tally, rate};
use crate::campaign::render::grid;
use crate::campaign::run::labelled;
use crate::campaign::{Cell, Purpose, Recording};
use model::Error;
use model::core::{Embedded, Finding, SegmentReport};
use model::evaluate::Rate;
use model::trace::labels::LabelledTrace;
use model::train::{AlarmInterval, Alarms, Recipe, train};
use rig::field::Drive;
use rig::{Condition, Defect, Scenario, simulate};

/// Set false-alarm rates; the alarm is that of the first gate.
pub const RATES: [f64; 2] = [1e-2, 1e-3];
/// Set mean number of sessions between false alarms.
pub const INTERVAL: f64 = 1000.0;
/// Number of sessions after which a sequence ends without an alarm.
const LENGTH: usize = 500;

/// Size of a fleet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fleet {
    /// Number of drives.
    pub units: u32,
    /// Number of sessions of each drive.
    pub sessions: u32,
}

impl Fleet {
    /// 20 drives of 10 sessions.
    pub const STANDARD: Self = Self { units: 20, sessions: 10 };
}

/// The conditions: MIX with units and sessions, and all effects of the field.
#[must_use]
pub fn conditions() -> Vec<Condition> {
    Condition::all().filter(|condition| ["units", "field-sine"].contains(&condition.name)).collect()
}

/// What one draw of one condition gives.
#[derive(Clone, Debug, PartialEq)]
struct Draw {
    /// False alarms of the gate of each rate, or why training refused it.
    gates: Vec<Result<Tally, String>>,
    /// Alarms and sessions until them.
    alarms: [usize; 2],
}

/// False alarms of one condition over all draws.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The condition.
    pub condition: &'static str,
    /// For each of [`RATES`] the false alarms a session, or why training refused the gate.
    pub gates: Vec<Result<Rate, String>>,
    /// Number of false alarms of all sequences.
    pub alarms: usize,
    /// Number of their sessions.
    pub sessions: usize,
}

/// Trains and judges fleets under this condition, one for each of `draws`.
///
/// # Errors
/// Returns an error if simulation fails.
pub fn found(condition: Condition, fleet: Fleet, draws: std::ops::Range<u32>) -> Result<Found, Error> {
    let all = draws.map(|draw| one_draw(condition, fleet, draw)).collect::<Result<Vec<_>, _>>()?;
    let gate = |k: usize| {
        let tallies: Result<Vec<Tally>, String> = all.iter().map(|own| own.gates[k].clone()).collect();
        tallies.map(|own| rate(&own))
    };
    let sum = |k: usize| all.iter().map(|own| own.alarms[k]).sum();
    Ok(Found {
        condition: condition.name,
        gates: (0..RATES.len()).map(gate).collect(),
        alarms: sum(0),
        sessions: sum(1),
    })
}

fn one_draw(condition: Condition, fleet: Fleet, draw: u32) -> Result<Draw, Error> {
    let training = records(condition, fleet, (Purpose::Training, draw))?;
    let judged = records(condition, fleet, (Purpose::Validation, draw))?;
    let trained = |rate: f64| -> Result<Embedded, String> {
        let trained = train(&training, &["healthy".into()], &recipe_of(condition, fleet, rate));
        trained.and_then(|trained| trained.embed()).map_err(|error| error.to_string())
    };
    let gates = RATES.map(trained);
    let mut own = Draw { gates: vec![], alarms: [0, 0] };
    for (k, gate) in gates.into_iter().enumerate() {
        own.gates.push(gate.map(|gate| {
            let reports: Vec<_> = judged.par_iter().map(|record| gate.run(&record.trace)).collect();
            if k == 0 {
                own.alarms = sequences(&gate, &reports, fleet, draw);
            }
            let novel = |report: &Vec<_>| gate.combine(report).map(|(finding, _)| finding != Finding::Class(0));
            // A healthy session without a verdict also counts as an alarm.
            Tally::of(reports.iter().map(novel)).undetermined_counted()
        }));
    }
    Ok(own)
}

/// The recipe of the field's table for the next session of another drive.
pub(super) fn recipe_of(condition: Condition, fleet: Fleet, rate: f64) -> Recipe {
    let mut recipe = recipe(&condition, &[]);
    recipe.validation.groups = drives(fleet).map(|(unit, _)| format!("drive {unit}")).collect();
    recipe.alarms = Alarms {
        false_alarm: rate,
        by_run: true,
        other_drive: true,
        segments_a_run: Some(1),
        interval: AlarmInterval::Segments(INTERVAL),
        ..recipe.alarms
    };
    recipe
}

/// Unit and session of each record.
fn drives(fleet: Fleet) -> impl Iterator<Item = (u32, u32)> {
    (0..fleet.units).flat_map(move |unit| (0..fleet.sessions).map(move |session| (unit, session)))
}

/// Number of the set of drives: another one for training and validation of each draw.
pub(super) fn set_of(purpose: Purpose, draw: u32) -> u32 {
    2 * draw + u32::from(purpose == Purpose::Training)
}

/// One healthy record a session. Drives of training and validation are of different sets.
pub(super) fn records(
    condition: Condition,
    fleet: Fleet,
    (purpose, draw): (Purpose, u32),
) -> Result<Vec<LabelledTrace>, Error> {
    let cell = Cell { purpose, repetition: draw, condition, defect: Defect::HEALTHY };
    let numbered: Vec<(u32, (u32, u32))> = (0..).zip(drives(fleet)).collect();
    numbered.par_iter().map(|&(number, (unit, session))| record_of(cell, number, (unit, session))).collect()
}

/// The record of a session of a drive.
pub(super) fn record_of(cell: Cell, number: u32, (unit, session): (u32, u32)) -> Result<LabelledTrace, Error> {
    let seed = cell.seed(number)?;
    let drive = Some(Drive { set: set_of(cell.purpose, cell.repetition), unit, session });
    let trace =
        simulate(&Scenario { drive, ..cell.scenario(&Scenario::WITH_RESOLVER, seed) }, seed).map_err(Error::other)?;
    Ok(labelled(Recording { cell, number, seed, trace }, 0))
}

/// Alarms and sessions of the sequences of all drives, from the segments of each of their sessions.
fn sequences(gate: &Embedded, judged: &[Vec<SegmentReport>], fleet: Fleet, draw: u32) -> [usize; 2] {
    let sessions = fleet.sessions as usize;
    let of_drive = |(unit, records): (usize, &[Vec<SegmentReport>])| {
        let own = records.concat();
        let mut random = ChaCha8Rng::seed_from_u64(u64::from(draw) << 32 | unit as u64);
        let sequence: Vec<SegmentReport> =
            (0..LENGTH).map(|_| own[random.random_range(0..own.len())].clone()).collect();
        let alarm = gate.watch(&sequence).iter().position(|state| state.alarm.is_some());
        [usize::from(alarm.is_some()), alarm.map_or(LENGTH, |k| k + 1)]
    };
    let all: Vec<[usize; 2]> = judged.par_chunks(sessions).enumerate().map(of_drive).collect();
    [0, 1].map(|k| all.iter().map(|own| own[k]).sum())
}

/// The table as plain text.
#[must_use]
pub fn text(all: &[Found], fleet: Fleet, draws: u32) -> String {
    let title = format!(
        "False alarms a session of {0} drives of {1} sessions, after training with {0} others, % [95 % interval]; {draws} \
         draws; alarm set to one in {INTERVAL} sessions",
        fleet.units, fleet.sessions
    );
    let head = ["", "set to 1 %", "set to 0.1 %", "alarms", "sessions", "sessions an alarm"];
    let row = |own: &Found| {
        let gate = |gate: &Result<Rate, String>| gate.as_ref().map_or_else(|_| "refused".into(), |rate| percent(*rate));
        let mean = match own.alarms {
            0 if own.sessions == 0 => "–".into(),
            0 => format!("> {}", own.sessions),
            alarms => format!("{:.0}", own.sessions as f64 / alarms as f64),
        };
        let mut row = vec![own.condition.to_string()];
        row.extend(own.gates.iter().map(gate));
        row.extend([own.alarms.to_string(), own.sessions.to_string(), mean]);
        row
    };
    let mut text = grid(&title, &head, &all.iter().map(row).collect::<Vec<_>>());
    for own in all {
        for (rate, gate) in RATES.iter().zip(&own.gates) {
            if let Err(reason) = gate {
                text += &format!("{}, {rate}: {reason}\n", own.condition);
            }
        }
    }
    text
}

/// Key `rows`, one for each condition.
#[must_use]
pub fn to_json(all: &[Found]) -> Value {
    let gate = |(set, gate): (&f64, &Result<Rate, String>)| match gate {
        Ok(rate) => json!({ "set": set, "false_alarms": rate.to_json() }),
        Err(reason) => json!({ "set": set, "refused": reason }),
    };
    let row = |own: &Found| {
        json!({
            "condition": own.condition,
            "gates": RATES.iter().zip(&own.gates).map(gate).collect::<Vec<_>>(),
            "alarms": own.alarms,
            "sessions": own.sessions,
        })
    };
    json!({ "rows": all.iter().map(row).collect::<Vec<_>>() })
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn no_drive_is_in_training_and_in_validation() {
        let sets: Vec<u32> = (0..900)
            .flat_map(|draw| [Purpose::Training, Purpose::Validation].map(|purpose| set_of(purpose, draw)))
            .collect();
        assert_eq!(sets.iter().collect::<HashSet<_>>().len(), sets.len());
        assert_eq!(conditions().len(), 2);
    }

    fn of(fleet: Fleet) -> (Found, String) {
        let found = found(conditions()[1], fleet, 0..1).expect("simulates");
        let text = text(std::slice::from_ref(&found), fleet, 1);
        println!("{text}");
        (found, text)
    }

    #[test]
    fn a_small_fleet_is_refused_with_the_rate_that_it_supports() {
        let (found, text) = of(Fleet { units: 12, sessions: 2 });
        let reason = found.gates[1].as_ref().expect_err("12 drives do not support 0.1 %");
        assert!(reason.contains("12 runs support a false-alarm rate of"), "{reason}");
        assert!(text.matches("refused").count() == 2 && text.contains(reason), "{text}");
        assert_eq!(found.sessions, 0);
    }

    #[test]
    fn a_fleet_has_about_the_set_rate() {
        let fleet = Fleet { units: 20, sessions: 3 };
        let (found, text) = of(fleet);
        let common = found.gates[0].as_ref().expect("20 drives are enough for 1 %");
        // 60 sessions: six alarms at a rate of 1 % have a probability of 1e-5.
        assert!(common.value < 0.1 && text.contains("units"), "{text}");
        // Each sequence has at most 500 sessions; an alarm a thousand sessions ends few of them.
        assert!((20 * LENGTH / 2..=20 * LENGTH).contains(&found.sessions), "{text}");
    }
}
