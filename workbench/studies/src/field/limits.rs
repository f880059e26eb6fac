//! What a healthy verdict would have seen: defects as large as the limit that their own record states, and how many of
//! them are called.
//!
//! For each row the default recipe is trained on healthy records. Healthy records of the validation set state their
//! limits; defects of these sizes are recorded, and those whose own record states a limit near their size are counted.
//! The limit promises that nine in ten are called. A defect raises other features besides the one with the limit, so
//! that more may be.

use std::f64::consts::PI;

use serde_json::{Value, json};

use super::recipe::{by_default, has_load_sensor};
use super::render::percent;
use super::rows::Row;
use super::tally::{Tally, rate};
use crate::campaign::render::grid;
use crate::campaign::run::{class_names, labelled, traces};
use crate::campaign::{Cell, Recording, map_traces};
use model::Error;
use model::core::{Embedded, Finding, SegmentReport};
use model::evaluate::Rate;
use model::train::train;
use rig::bearing::{ADDED_FRICTION_NM_S_PER_RAD, PULSE_DUTY, PULSE_NM};
use rig::{Defect, DefectKind, Scenario};

/// Healthy records that train a gate, that state limits, and records of each size of a defect.
const RECORDS: [u32; 3] = [150, 40, 32];
/// Parts of the stated limits at which defects are recorded, and those of the records that set the sizes.
const PARTS: [f64; 2] = [1.0, 1.0 / 1.3];
const QUANTILES: [f64; 3] = [0.2, 0.5, 0.8];
/// A size counts as that of the limit within this factor.
const NEAR: f64 = 1.15;
/// Severities are multiples of this, at least [`SMALLEST`], so that rounding does not matter, and at most [`LARGEST`].
const STEP: f64 = 1.0 / 1920.0;
const SMALLEST: f64 = 8.0 * STEP;
const LARGEST: f64 = 2.1;
/// The kinds of defects, with the names of features whose limit is that of their size.
const KINDS: [(DefectKind, &[&str]); 2] =
    [(DefectKind::Spall, &["order_outer"]), (DefectKind::Roughness, &["viscous", "viscous_log"])];

/// What is found of one kind of defect.
#[derive(Clone, Debug, PartialEq)]
struct Kind {
    /// Limits that healthy records state, severities in increasing order.
    limits: Vec<f64>,
    /// For each of [`PARTS`], the called ones.
    called: [Rate; 2],
}

/// The limits of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    row: Row,
    /// Healthy records without a verdict.
    undetermined: Rate,
    /// For each of [`KINDS`]; `None` where the model has no such feature.
    kinds: [Option<Kind>; 2],
}

/// Amplitude of the first harmonic of the pulses of a spall of this size, A: ½ (1 − cos) over a part w of a period.
#[must_use]
pub fn amplitude_a(severity: f64) -> f64 {
    let w = PULSE_DUTY;
    severity * PULSE_NM / Scenario::STANDARD.motor.kt_nm_per_a * w * (PI * w).sin() / (PI * w) / (1.0 - w * w)
}

/// The smallest of the limits that a segment states for features of these names; `None` if the model has none of them.
#[must_use]
pub fn stated(model: &Embedded, segment: &SegmentReport, names: &[&str]) -> Option<f64> {
    let all = model.coordinate_names(&["outer", "inner", "ball", "cage"].map(String::from));
    let named = segment.smallest.iter().filter(|(k, _)| names.contains(&all[usize::from(*k)].as_str()));
    named.map(|(_, size)| f64::from(*size)).reduce(f64::min)
}

/// The gate of a row, and the size of a defect for a stated limit.
struct Bench {
    row: Row,
    draw: u32,
    model: Embedded,
    /// The usual viscous friction B/Kt, A s/rad.
    viscous: f64,
}

impl Bench {
    fn new(row: &Row, draw: u32) -> Result<Self, Error> {
        let classes = class_names(&[Defect::HEALTHY]);
        let set = traces(&[(row.training(draw, Defect::HEALTHY), 0)], RECORDS[0])?;
        let model = train(&set, &classes, &by_default(row, &classes)?)?.embed()?;
        let viscous = model.shaft().map_or(f64::NAN, |shaft| f64::from(shaft.balance.nominal[1]));
        Ok(Self { row: *row, draw, model, viscous })
    }

    fn judged<T: Send>(
        &self,
        defect: Defect,
        count: u32,
        of: impl Fn(&SegmentReport) -> T + Sync,
    ) -> Result<Vec<T>, Error> {
        let cell: Cell = self.row.validation(self.draw, defect);
        map_traces(&Scenario::WITH_RESOLVER, &[cell], count, |recording: Recording| {
            let segments = self.model.run(&labelled(recording, 0).trace);
            segments.first().map(&of).ok_or_else(|| Error::Training("a record without a segment".into()))
        })
    }

    /// The severity at the limit that a segment states; infinite if it shows none.
    fn severity(&self, segment: &SegmentReport, (kind, names): (DefectKind, &[&str])) -> Option<f64> {
        let limit = stated(&self.model, segment, names)?;
        Some(match kind {
            DefectKind::Spall => limit / amplitude_a(1.0),
            _ => limit * self.viscous * Scenario::STANDARD.motor.kt_nm_per_a / ADDED_FRICTION_NM_S_PER_RAD,
        })
    }

    fn kind(&self, kind: (DefectKind, &[&str]), mut limits: Vec<f64>) -> Result<Kind, Error> {
        limits.sort_unstable_by(f64::total_cmp);
        let called = |part: f64| -> Result<Rate, Error> {
            let (mut called, mut near) = (0, 0);
            let mut sizes = Vec::from(QUANTILES.map(|at| {
                let limit = limits[(at * (limits.len() - 1) as f64).round() as usize];
                (limit * part / STEP).round() * STEP
            }));
            // The same size would be the same records.
            sizes.dedup();
            for severity in sizes.into_iter().filter(|size| (SMALLEST..=LARGEST).contains(size)) {
                let defect = Defect { kind: kind.0, severity };
                let near_limit = self.judged(defect, RECORDS[2], |segment| {
                    let ratio = severity / (part * self.severity(segment, kind)?);
                    let is_near = ratio < NEAR && ratio * NEAR > 1.0;
                    is_near.then_some(matches!(segment.verdict, Ok(verdict) if verdict != Finding::Class(0)))
                })?;
                near += near_limit.iter().flatten().count();
                called += near_limit.iter().flatten().filter(|called| **called).count();
            }
            Ok(Rate::wilson(called, near))
        };
        Ok(Kind { called: [called(PARTS[0])?, called(PARTS[1])?], limits })
    }
}

/// The limits of one draw of a row.
///
/// # Errors
/// Simulation or training fails.
pub fn limits(row: &Row, draw: u32) -> Result<Limits, Error> {
    let bench = Bench::new(row, draw)?;
    let healthy = bench.judged(Defect::HEALTHY, RECORDS[1], |segment| {
        (segment.verdict.is_err(), KINDS.map(|kind| bench.severity(segment, kind)))
    })?;
    let undetermined = Tally::of(healthy.iter().map(|(without, _)| Some(*without)));
    let of = |k: usize| -> Result<Option<Kind>, Error> {
        let stated: Option<Vec<f64>> = healthy.iter().map(|(_, own)| own[k]).collect();
        let known = |_: &Vec<f64>| k == 0 || has_load_sensor(&row.judged);
        stated.filter(known).map(|limits| bench.kind(KINDS[k], limits)).transpose()
    };
    Ok(Limits { row: *row, undetermined: rate(&[undetermined]), kinds: [of(0)?, of(1)?] })
}

/// The table as text.
#[must_use]
pub fn text(all: &[Limits]) -> String {
    let title = format!(
        "Defects as large as the limit that their own record states, called, % [95 % interval]; default recipe, \
         {} healthy records",
        RECORDS[0]
    );
    let head = [
        "",
        "no verdict, %",
        "spall: limit, median",
        "at the limit",
        "at 1/1.3 of it",
        "roughness: limit, median",
        "at the limit",
        "at 1/1.3 of it",
    ];
    let row = |own: &Limits| {
        let mut row = vec![own.row.name(), percent(own.undetermined)];
        for kind in &own.kinds {
            row.extend(kind.as_ref().map_or_else(
                || vec!["–".to_string(); 3],
                |kind| {
                    let size = format!("{:.3}", kind.limits[kind.limits.len() / 2]);
                    let told = |rate: Rate| if rate.value.is_finite() { percent(rate) } else { "–".into() };
                    vec![size, told(kind.called[0]), told(kind.called[1])]
                },
            ));
        }
        row
    };
    grid(&title, &head, &all.iter().map(row).collect::<Vec<_>>())
}

/// One object for each row.
#[must_use]
pub fn to_json(all: &[Limits]) -> Value {
    let rate = |rate: Rate| json!([rate.value, rate.low, rate.high]);
    let kind = |kind: &Option<Kind>| {
        kind.as_ref().map(|kind| {
            json!({ "limits": kind.limits, "at_limit": rate(kind.called[0]), "below_limit": rate(kind.called[1]) })
        })
    };
    let row = |own: &Limits| {
        let [spall, roughness] = [&own.kinds[0], &own.kinds[1]].map(kind);
        json!({ "row": own.row.name(), "undetermined": rate(own.undetermined), "spall": spall, "roughness": roughness })
    };
    json!({ "rows": all.iter().map(row).collect::<Vec<_>>() })
}
