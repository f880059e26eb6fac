//! Trains and judges one draw of one row with the embedded detector.

use super::recipe::{by_default, of_classes, of_gate};
use super::rows::{CLASS_SIZES, CLASSES, COLUMNS, Row};
use super::settings::Settings;
use super::tally::Tally;
use crate::campaign::run::{class_names, labelled, traces};
use crate::campaign::{Recording, map_traces};
use model::Error;
use model::core::{Embedded, Finding, SegmentReport};
use model::trace::labels::LabelledTrace;
use model::train::{Recipe, train};
use rig::{Defect, DefectKind, Scenario};

/// Result of one draw of one row; the error is the reason why training refused the set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draw {
    /// Detected records, one tally for each of [`COLUMNS`].
    pub gate: Result<Vec<Tally>, String>,
    /// Wrong classes, one tally for each of [`CLASS_SIZES`]; `None` if the row has no discriminant.
    pub classes: Option<Result<Vec<Tally>, String>>,
}

/// A trained detector, or why training refused the set.
type Trained = Result<Embedded, String>;

/// Outcomes of one validation record: detected by the gate, and the class is wrong.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    detected: Option<bool>,
    wrong: Option<bool>,
}

/// Trains and judges one draw of a row.
///
/// # Errors
/// Returns an error if simulation fails.
pub fn draw(row: &Row, draw: u32, settings: &Settings) -> Result<Draw, Error> {
    let (gate, classes) = detectors(row, draw, settings)?;
    if gate.is_err() && classes.as_ref().is_none_or(Result::is_err) {
        return Ok(Draw { gate: gate.map(|_| vec![]), classes: classes.map(|own| own.map(|_| vec![])) });
    }
    let mut judged: Vec<(Defect, Vec<Outcome>)> = Vec::new();
    let detectors = (&gate, classes.as_ref());
    for defect in row.judged_defects() {
        let cell = row.validation(draw, defect);
        let of_record = |recording: Recording| Ok(segments(recording, detectors));
        let count = settings.judged(defect.kind) * settings.together;
        let records = map_traces(&Scenario::WITH_RESOLVER, &[cell], count, of_record)?;
        let runs = records.chunks(settings.together as usize);
        judged.push((defect, runs.map(|run| outcome(run, defect, detectors)).collect()));
    }
    let of = |defect: Defect| judged.iter().filter(move |(own, _)| *own == defect).flat_map(|(_, outcomes)| outcomes);
    let detected = || COLUMNS.map(|defect| Tally::of(of(defect).map(|own| own.detected))).to_vec();
    let count = settings.defects as usize;
    let wrong = |size: f64| {
        // As many healthy records as there are of each defect.
        let kinds = CLASSES.iter().flat_map(|kind| of(of_size(*kind, size)).take(count));
        Tally::of(kinds.map(|own| own.wrong))
    };
    let classes = classes.map(|own| own.map(|_| CLASS_SIZES.map(wrong).to_vec()));
    Ok(Draw { gate: gate.map(|_| detected()), classes })
}

/// A class at this size; a healthy bearing has no size.
fn of_size(kind: DefectKind, severity: f64) -> Defect {
    if kind == Defect::HEALTHY.kind { Defect::HEALTHY } else { Defect { kind, severity } }
}

/// The gate, trained on healthy records, and the discriminant, trained on the same records and the defects.
fn detectors(row: &Row, draw: u32, settings: &Settings) -> Result<(Trained, Option<Trained>), Error> {
    let healthy = traces(&[(row.training(draw, Defect::HEALTHY), 0)], settings.healthy_training)?;
    let trained = |set: &[LabelledTrace], classes: &[Defect], recipe: Recipe| -> Trained {
        if recipe.features.is_empty() && !recipe.automatic {
            return Err("none of the features exists without a load sensor".into());
        }
        let trained = train(set, &class_names(classes), &recipe);
        trained.and_then(|trained| trained.embed()).map_err(|error| error.to_string())
    };
    let recipe = |classes: &[Defect], own: Recipe| {
        if settings.default { by_default(row, &class_names(classes)) } else { Ok(own) }
    };
    let gate = recipe(&[Defect::HEALTHY], of_gate(row, &settings.features))?;
    let gate = trained(&healthy, &[Defect::HEALTHY], gate);
    if !row.classes {
        return Ok((gate, None));
    }
    let classes = CLASSES.map(Defect::full);
    let cells: Vec<_> = classes.iter().enumerate().skip(1).map(|(k, own)| (row.training(draw, *own), k)).collect();
    let mut set = healthy;
    set.extend(traces(&cells, settings.defects_training)?);
    let own = recipe(&classes, of_classes(row, &settings.features))?;
    Ok((gate, Some(trained(&set, &classes, own))))
}

/// Runs gate and discriminant over one record.
fn segments(recording: Recording, (gate, classes): (&Trained, Option<&Trained>)) -> [Vec<SegmentReport>; 2] {
    let record = labelled(recording, 0).trace;
    let run = |detector: &Trained| detector.as_ref().map_or(vec![], |detector| detector.run(&record));
    [run(gate), classes.map_or(vec![], run)]
}

/// What gate and discriminant say of the records of one run.
fn outcome(run: &[[Vec<SegmentReport>; 2]], defect: Defect, (gate, classes): (&Trained, Option<&Trained>)) -> Outcome {
    let truth = CLASSES.iter().position(|kind| *kind == defect.kind);
    let decided = |detector: Option<&Trained>, of: usize| {
        let together: Vec<SegmentReport> = run.iter().flat_map(|record| record[of].clone()).collect();
        detector?.as_ref().ok()?.combine(&together)
    };
    let detected = decided(Some(gate), 0).map(|(finding, _)| finding != Finding::Class(0));
    let wrong = decided(classes, 1).map(|(_, posteriors)| {
        let most_plausible = (0..posteriors.len()).max_by(|&i, &j| posteriors[i].total_cmp(&posteriors[j]));
        most_plausible != truth
    });
    Outcome { detected, wrong }
}
