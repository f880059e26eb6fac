//! Gates that are learned on the drive, beside the one of the test bench alone.
//!
//! The constants of a drive differ from those of others, and from day to day ([`Units`](rig::field::Units)). A
//! gate is trained on the bench for the next session of another drive, as in [`super::sessions`]. Each judged drive
//! then gathers healthy records, one a session, and merges them with this gate by the core's commissioning, on its
//! single-precision reports. Both gates judge later sessions of the drive: healthy ones, and ones with defects. A drive
//! whose commissioning is refused keeps the gate of the bench, as in service.

use bearing_watch::Commissioning;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::sessions::{Fleet, recipe_of, record_of, records};
use super::tally::{Tally, rate};
use crate::campaign::render::grid;
use crate::campaign::{Cell, Purpose};
use model::Error;
use model::core::{Embedded, Finding};
use model::train::train;
use rig::{Condition, Defect, DefectKind};

/// Judged records: healthy ones, and defects below those that the bench's gate finds in every record.
const COLUMNS: [Defect; 7] = [
    Defect::HEALTHY,
    sized(DefectKind::Spall, 1.0 / 8.0),
    sized(DefectKind::Spall, 1.0 / 16.0),
    sized(DefectKind::Spall, 1.0 / 32.0),
    sized(DefectKind::Roughness, 1.0 / 32.0),
    sized(DefectKind::Roughness, 1.0 / 64.0),
    sized(DefectKind::Roughness, 1.0 / 128.0),
];

const fn sized(kind: DefectKind, severity: f64) -> Defect {
    Defect { kind, severity }
}

/// Size of the study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Drives of the test bench.
    pub bench: Fleet,
    /// Set false-alarm rate of the gates.
    pub rate: f64,
    /// Number of judged drives a draw.
    pub drives: u32,
    /// Number of records that a drive gathers.
    pub gathered: u32,
    /// Number of healthy records that are judged a drive.
    pub healthy: u32,
    /// Number of records of each defect that are judged a drive.
    pub defects: u32,
}

impl Settings {
    /// The fleet of [`super::sessions`] on the bench, and eight drives that gather 30 records.
    pub const STANDARD: Self =
        Self { bench: Fleet::STANDARD, rate: 0.01, drives: 8, gathered: 30, healthy: 50, defects: 10 };
}

/// Verdicts of one draw: of each kind of record those of the bench's gate and of the commissioned one.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// The tallies.
    pub columns: Vec<[Tally; 2]>,
    /// Why drives were refused.
    pub refused: Vec<String>,
}

/// Drives with other constants, and other ones each day.
fn condition() -> Result<Condition, Error> {
    let named = Condition::all().find(|condition| condition.name == "units");
    named.ok_or_else(|| Error::Usage("there is no condition units".into()))
}

/// Trains, commissions and judges one draw.
///
/// # Errors
/// Returns an error if simulation or training fails.
pub fn draw(settings: &Settings, draw: u32) -> Result<Draw, Error> {
    let condition = condition()?;
    let bench = records(condition, settings.bench, (Purpose::Training, draw))?;
    let trained = train(&bench, &["healthy".into()], &recipe_of(condition, settings.bench, settings.rate))?;
    let gate = trained.watch.gate.as_ref().ok_or_else(|| Error::Training("no gate".into()))?;
    let constants = gate.commissioning(settings.gathered, trained.watch.evidence)?;
    let bench = trained.embed()?;
    let mut found = Draw { columns: vec![[Tally::default(); 2]; COLUMNS.len()], refused: vec![] };
    for unit in 0..settings.drives {
        let first = unit * settings.sessions();
        let record = |defect: Defect, session: u32| {
            let cell = Cell { purpose: Purpose::Validation, repetition: draw, condition, defect };
            record_of(cell, first + session, (unit, session))
        };
        let healthy: Vec<_> = (0..settings.offered())
            .into_par_iter()
            .map(|session| record(Defect::HEALTHY, session))
            .collect::<Result<_, _>>()?;
        let mut commissioning = Commissioning::new(bench.model(), constants).map_err(refused)?;
        for own in &healthy {
            if commissioning.gathered() >= settings.gathered {
                break;
            }
            // A record that is refused is not used; what matters is the end.
            let _ = commissioning.take(&bench.whole(&own.trace));
        }
        let commissioned = match commissioning.model() {
            Ok(model) => Embedded::new(model).map_err(|error| Error::Training(error.to_string()))?,
            Err(error) => {
                found.refused.push(error.to_string());
                bench.clone()
            }
        };
        for (tallies, defect) in found.columns.iter_mut().zip(COLUMNS) {
            let count = if defect == Defect::HEALTHY { settings.healthy } else { settings.defects };
            let sessions = settings.offered()..settings.offered() + count;
            let judged = |session: u32| {
                let own = record(defect, session)?;
                Ok([&bench, &commissioned].map(|gate| detected(gate, &own.trace)))
            };
            let all = sessions.into_par_iter().map(judged).collect::<Result<Vec<_>, Error>>()?;
            for (k, tally) in tallies.iter_mut().enumerate() {
                *tally = sum(*tally, Tally::of(all.iter().map(|own| own[k])));
            }
        }
    }
    Ok(found)
}

impl Settings {
    /// Number of sessions of a judged drive.
    const fn sessions(&self) -> u32 {
        let judged = if self.healthy > self.defects { self.healthy } else { self.defects };
        self.offered() + judged
    }

    /// Number of healthy sessions from which a drive can gather: some are refused.
    const fn offered(&self) -> u32 {
        self.gathered + self.gathered / 2
    }
}

fn refused(error: bearing_watch::alarm::CommissioningError) -> Error {
    Error::Training(error.to_string())
}

/// Whether a gate calls a record anything but healthy; `None` without a verdict.
fn detected(gate: &Embedded, trace: &model::trace::Trace) -> Option<bool> {
    gate.combine(&gate.run(trace)).map(|(finding, _)| finding != Finding::Class(0))
}

const fn sum(a: Tally, b: Tally) -> Tally {
    Tally {
        counted: a.counted + b.counted,
        opposite: a.opposite + b.opposite,
        undetermined: a.undetermined + b.undetermined,
    }
}

fn name(defect: Defect) -> String {
    match defect.kind {
        DefectKind::Healthy => "healthy: false alarms".into(),
        kind => format!("{} at 1/{:.0}", kind.name(), 1.0 / defect.severity),
    }
}

/// Rates of both gates in a column.
fn rates(all: &[Draw], column: usize) -> [model::evaluate::Rate; 2] {
    [0, 1].map(|k| rate(&all.iter().map(|draw| draw.columns[column][k]).collect::<Vec<_>>()))
}

/// The table as plain text.
#[must_use]
pub fn text(all: &[Draw], settings: &Settings) -> String {
    let Settings { bench, drives, gathered, .. } = settings;
    let title = format!(
        "Records found not healthy, % [95 % interval]: gate of the bench ({} drives of {} sessions, set to {} %), and \
         merged with {gathered} sessions of the drive; {} draws of {drives} drives",
        bench.units,
        bench.sessions,
        100.0 * settings.rate,
        all.len()
    );
    let row = |(column, defect): (usize, &Defect)| {
        let [bench, own] = rates(all, column).map(super::render::percent);
        vec![name(*defect), bench, own]
    };
    let rows: Vec<Vec<String>> = COLUMNS.iter().enumerate().map(row).collect();
    let mut text = grid(&title, &["", "bench", "commissioned"], &rows);
    for reason in all.iter().flat_map(|draw| &draw.refused) {
        text += &format!("a drive is refused: {reason}\n");
    }
    text
}

/// Key `rows`, one for each defect, and the number of refused drives.
#[must_use]
pub fn to_json(all: &[Draw]) -> Value {
    let row = |(column, defect): (usize, &Defect)| {
        let [bench, own] = rates(all, column);
        json!({ "defect": name(*defect), "bench": bench.to_json(), "commissioned": own.to_json() })
    };
    let refused: Vec<&String> = all.iter().flat_map(|draw| &draw.refused).collect();
    json!({ "rows": COLUMNS.iter().enumerate().map(row).collect::<Vec<_>>(), "refused": refused })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_commissioned_gate_keeps_its_rate_and_finds_what_is_large_enough() {
        let bench = Fleet { units: 20, sessions: 3 };
        let settings = Settings { bench, rate: 0.05, drives: 3, gathered: 24, healthy: 30, defects: 5 };
        let found = draw(&settings, 0).expect("simulates");
        println!("{}", text(std::slice::from_ref(&found), &settings));
        assert_eq!(found.refused, Vec::<String>::new());
        let [_, own] = found.columns[0];
        // 90 records at a set rate of 5 %: 15 or more have a probability of 3e-5, with the spread of three gates less
        // than 1 %; none at all has one of 1 %.
        assert!((1..15).contains(&(own.counted + own.undetermined)), "{found:?}");
        // The campaign finds every spall of 1/8 and one in sixteen of 1/32 at a rate of 1 %.
        assert_eq!(found.columns[1][1].counted, 15, "{found:?}");
        assert!(found.columns[3][1].counted < 8, "{found:?}");
    }
}
