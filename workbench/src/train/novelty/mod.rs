//! Healthy training segments → the novelty gate and the constants of the alarm.
//!
//! Mean and covariance are those of the healthy class alone; the rate is set by the law of a further segment's distance
//! ([`law`]), so that it holds in the mean over training sets of any size. How far a single gate may be off is a matter
//! of the number of segments ([`spread`]).

mod knots;
pub mod law;
pub mod spread;

use bearing_watch::model::EvidenceConstants;
use bearing_watch::model::KNOTS;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::FeatureTable;
use super::statistics::{ClassStatistics, singular, whitening};
use crate::Error;
use law::DistanceLaw;

/// κ of the evidence: a mean surprise of 5 nats is found soonest, and a mean surprise of 2 instead of 1 while healthy
/// still brings no alarm.
pub const BET: f32 = 0.2;
/// A gate so many times as far out (in d²) as one of known spread is refused: nothing but the coarsest defect reaches it.
const FARTHEST: f64 = 10.0;
/// Mean time between false alarms, where none is asked: hours where the rate is known, else segments.
const USUAL_HOURS: f64 = 1000.0;
const USUAL_SEGMENTS: f64 = 1e5;

/// Mean time between false alarms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlarmInterval {
    /// 1000 hours, or 100 000 segments where the sampling interval is not known.
    Usual,
    /// Hours.
    Hours(f64),
    /// Segments.
    Segments(f64),
}

/// What is asked of gate, reject option and alarm.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarms {
    /// The healthy class; no gate and no alarm without one.
    pub healthy: Option<usize>,
    /// Rate of healthy segments called novel.
    pub false_alarm: f64,
    /// Whether to refuse what is too few for a gate, instead of doing without.
    pub required: bool,
    /// What no decision costs; infinite where one is always wanted.
    pub reject_cost: f64,
    /// Mean time between false alarms.
    pub interval: AlarmInterval,
}

impl Default for Alarms {
    fn default() -> Self {
        let interval = AlarmInterval::Usual;
        Self { healthy: None, false_alarm: 0.01, required: false, reject_cost: f64::INFINITY, interval }
    }
}

/// The gate in double precision; fields as in [`bearing_watch::decide::Novelty`].
#[derive(Clone, Debug)]
pub struct Gate {
    /// The healthy class.
    pub class: usize,
    /// Its mean.
    pub mean: DVector<f64>,
    /// U with UᵀU = S⁻¹.
    pub whitening: DMatrix<f64>,
    /// (d², surprise).
    pub knots: [[f64; 2]; KNOTS],
    /// −ln of the false-alarm rate.
    pub limit: f64,
    /// The law of distances.
    pub law: DistanceLaw,
    /// Healthy segments it was made of.
    pub rows: usize,
    /// Segments from which 95 % of gates have at most three times the rate.
    pub rows_needed: usize,
}

/// Gate and alarm of a trained model.
#[derive(Clone, Debug)]
pub struct Watch {
    /// The gate, where there is one.
    pub gate: Option<Gate>,
    /// Constants of the alarm.
    pub evidence: EvidenceConstants,
    /// Mean segments between false alarms.
    pub segments: f64,
    /// What the user should know.
    pub warning: Option<String>,
}

/// Trains on coordinates called `names`; `segment_s` is the duration of a segment where it is known.
pub(crate) fn train(
    table: &FeatureTable,
    names: &[String],
    alarms: &Alarms,
    segment_s: Option<f64>,
) -> Result<Watch, Error> {
    let none = |warning| Watch { gate: None, evidence: EvidenceConstants::NONE, segments: f64::INFINITY, warning };
    if alarms.reject_cost.is_nan() || alarms.reject_cost < 0.0 {
        return Err(Error::Usage("--reject-cost is not negative".into()));
    }
    let Some(class) = alarms.healthy else { return Ok(none(None)) };
    let rate = alarms.false_alarm;
    if !(1e-9..=0.5).contains(&rate) {
        return Err(Error::Usage(format!("--false-alarm {rate}: give a rate from 1e-9 to 0.5 a segment")));
    }
    let segments = segments_between(alarms.interval, segment_s)?;
    let rows = table.classes.iter().filter(|c| **c == class).count();
    let least = fewest(names.len(), rate);
    if rows < least {
        let problem = format!(
            "{rows} healthy segments are too few for a novelty gate of {} coordinates at a false-alarm rate of {rate}; \
             give at least {least}, use fewer features, or a higher rate",
            names.len()
        );
        return if alarms.required { Err(Error::Training(problem)) } else { Ok(none(Some(problem + "; none is set"))) };
    }
    let gate = gate(table, names, class, rate)?;
    // Scores of the novelty and of each defect share the rate.
    let limit = (table.names.len() as f64 * segments).ln() as f32;
    let warning = (rows < gate.rows_needed).then(|| {
        format!(
            "{rows} healthy segments keep the false-alarm rate of {rate} in the mean only; from {} on, 95 % of such gates \
             have at most {} times the rate",
            gate.rows_needed,
            spread::BOUND
        )
    });
    // One segment alone is no alarm.
    let evidence = EvidenceConstants { bet: BET, limit, cap: 0.5 * limit };
    Ok(Watch { gate: Some(gate), evidence, segments, warning })
}

/// The fewest segments of which a gate can be made, and one that is not too far out for its rate.
#[must_use]
pub fn fewest(coordinates: usize, rate: f64) -> usize {
    let known = ChiSquared::new(coordinates as f64).map_or(f64::NAN, |law| law.inverse_cdf(1.0 - rate));
    let near = |rows: &usize| DistanceLaw::gaussian(coordinates, *rows).squared_at(-rate.ln()) <= FARTHEST * known;
    (coordinates + 2..).take(1000).find(near).unwrap_or(coordinates + 1000)
}

/// The gate of healthy rows alone.
///
/// # Errors
/// Too few rows for the rate, or coordinates that are constant or depend on each other.
pub fn gate_of(healthy: &[DVector<f64>], rate: f64) -> Result<Gate, Error> {
    let names: Vec<String> = (1..=healthy.first().map_or(0, DVector::len)).map(|k| format!("z{k}")).collect();
    let table = FeatureTable { rows: healthy.to_vec(), classes: vec![0; healthy.len()], names: vec!["healthy".into()] };
    let alarms = Alarms { healthy: Some(0), false_alarm: rate, required: true, ..Alarms::default() };
    let watch = train(&table, &names, &alarms, None)?;
    watch.gate.ok_or_else(|| Error::Training("no healthy rows".into()))
}

fn gate(table: &FeatureTable, names: &[String], class: usize, rate: f64) -> Result<Gate, Error> {
    let statistics = ClassStatistics::new(table);
    let (mean, rows) = (statistics.means[class].clone(), statistics.counts[class]);
    let (whitening, _) = whitening(&statistics.covariances[class])
        .map_err(|dependent| singular(&format!("class {}", table.names[class]), rows, 1, names, dependent))?;
    let own = table.rows.iter().zip(&table.classes).filter(|(_, c)| **c == class).map(|(row, _)| row);
    let squared: Vec<f64> = own.map(|row| (&whitening * (row - &mean)).norm_squared()).collect();
    let law = DistanceLaw::of(names.len(), &squared);
    let limit = -rate.ln();
    let (knots, rows_needed) = (knots::knots(&law, limit), spread::rows_needed(names.len(), rate));
    Ok(Gate { class, mean, whitening, knots, limit, law, rows, rows_needed })
}

fn segments_between(interval: AlarmInterval, segment_s: Option<f64>) -> Result<f64, Error> {
    let segments = match (interval, segment_s) {
        (AlarmInterval::Usual, None) => USUAL_SEGMENTS,
        (AlarmInterval::Usual, Some(seconds)) => (USUAL_HOURS * 3600.0 / seconds).max(USUAL_SEGMENTS.sqrt()),
        (AlarmInterval::Segments(segments), _) => segments,
        (AlarmInterval::Hours(hours), Some(seconds)) => hours * 3600.0 / seconds,
        (AlarmInterval::Hours(_), None) => {
            let problem = "the traces have no time, so --alarm-interval-h says nothing; give --alarm-interval-segments";
            return Err(Error::Usage(problem.into()));
        }
    };
    if segments.is_finite() && segments >= 10.0 {
        return Ok(segments);
    }
    Err(Error::Usage(format!("one false alarm in {segments} segments is no interval; give at least 10 segments")))
}
