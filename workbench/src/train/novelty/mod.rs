//! Healthy training segments → the novelty gate and the constants of the alarm.
//!
//! Mean and covariance are those of the healthy class alone. The gate follows from the distribution of a further
//! segment's distance ([`law`]), so that the mean false-alarm rate over training sets of any size is the set one. The
//! deviation of a single gate from the set rate depends on the number of segments ([`spread`]).
//!
//! Coordinates may have errors of known variance, or be missing (`super::moments`). The distance of each segment is
//! that of its available coordinates, with their errors, and [`law::equivalent`] converts it to all coordinates, as the
//! core does. The number of segments is then that of the coordinate that is missing most often.
//!
//! Segments of one run are more alike than those of different runs. If the runs are known ([`Alarms::by_run`]), mean,
//! covariance and law are those for a segment of the next run ([`runs`]), and the number of runs, not of segments, must
//! suffice for the set rate.
//!
//! The alarm collects e-values of runs ([`alarm`]), divided by their mean for 95 % of baselines of this size:
//! [`baseline`] finds it for the novelty, `ratios` for the likelihood ratios of the defects.

pub mod alarm;
pub mod baseline;
mod commissioning;
mod knots;
pub mod law;
pub(crate) mod of_sums;
mod ratios;
pub mod rising;
pub mod runs;
pub mod score;
pub mod spread;

use bearing_watch::model::EvidenceConstants;
use bearing_watch::model::KNOTS;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::moments::{self, Moments};
use super::statistics::{ClassStatistics, singular, whitening};
use super::{FeatureTable, GaussianClasses, Recipe};
use crate::Error;
use law::DistanceLaw;
use ratios::TrainingSet;
use rising::Rising;
use runs::RunSpread;
use score::ScoreLaw;

/// κ of the evidence: a mean surprise of 5 nats is detected fastest, and a mean surprise of 2 instead of 1 in the
/// healthy state does not yet cause an alarm.
pub const BET: f32 = 0.2;
/// A gate is refused if its d² exceeds that of known mean and covariance by this factor: only the largest defects would
/// reach it.
const FARTHEST: f64 = 10.0;
/// Mean time between false alarms if none is given: in hours if the rate is known, else in segments.
const USUAL_HOURS: f64 = 1000.0;
const USUAL_SEGMENTS: f64 = 1e5;

/// Mean time between false alarms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlarmInterval {
    /// 1000 hours, or 100 000 segments if the sampling interval is not known.
    Usual,
    /// Hours.
    Hours(f64),
    /// Segments.
    Segments(f64),
}

/// Settings of gate, reject option and alarm.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarms {
    /// The healthy class; no gate and no alarm without one.
    pub healthy: Option<usize>,
    /// Rate of healthy segments called novel.
    pub false_alarm: f64,
    /// Whether too few segments for a gate are an error; if false, the model then has no gate.
    pub required: bool,
    /// Whether the rate is that of the next run, by the groups of the validation; if false, segments are independent.
    pub by_run: bool,
    /// Cost of no decision; infinite if a decision is always required.
    pub reject_cost: f64,
    /// Mean time between false alarms.
    pub interval: AlarmInterval,
    /// Number of segments after which a run ends by itself in service; if not given, that of the longest healthy
    /// training run, or 1 if segments are independent.
    pub segments_a_run: Option<u32>,
    /// Whether the groups of the validation are drives, and the model is for another one, whose offset lasts.
    pub other_drive: bool,
}

impl Default for Alarms {
    fn default() -> Self {
        let interval = AlarmInterval::Usual;
        let reject_cost = f64::INFINITY;
        Self {
            healthy: None,
            false_alarm: 0.01,
            required: false,
            by_run: false,
            reject_cost,
            interval,
            segments_a_run: None,
            other_drive: false,
        }
    }
}

/// The gate in double precision; fields as in [`bearing_watch::model::Novelty`].
#[derive(Clone, Debug)]
pub struct Gate {
    /// The healthy class.
    pub class: usize,
    /// Its mean.
    pub mean: DVector<f64>,
    /// S, its covariance.
    pub covariance: DMatrix<f64>,
    /// Knots (d², surprise).
    pub knots: [[f64; 2]; KNOTS],
    /// −ln of the false-alarm rate.
    pub limit: f64,
    /// The distribution of the distances.
    pub law: DistanceLaw,
    /// The last coordinates, if only larger values than usual are a defect.
    pub rising: Option<Rising>,
    /// Number of healthy segments in training.
    pub rows: usize,
    /// Spread of the runs, if the rate is that of the next run.
    pub runs: Option<RunSpread>,
    /// Number of independent segments from which on 95 % of gates have at most three times the rate.
    pub rows_needed: usize,
}

/// A gate, or why there is none.
type GateOrReason = Result<Gate, String>;

/// Gate and alarm of a trained model.
#[derive(Clone, Debug)]
pub struct Watch {
    /// The gate, if there is one.
    pub gate: Option<Gate>,
    /// Constants of the alarm.
    pub evidence: EvidenceConstants,
    /// Mean number of segments between false alarms.
    pub segments: f64,
    /// A warning for the user.
    pub warning: Option<String>,
}

/// Coordinates of training segments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a> {
    pub(crate) table: &'a FeatureTable,
    pub(crate) names: &'a [String],
    /// Number of coefficients of covariates that were fitted to their features.
    pub(crate) fitted: usize,
    /// Number of the last coordinates, of which only larger values than usual are a defect.
    pub(crate) rising: usize,
}

impl Watch {
    const fn without(warning: Option<String>) -> Self {
        Self { gate: None, evidence: EvidenceConstants::NONE, segments: f64::INFINITY, warning }
    }
}

/// Trains on the coordinates and their densities by the `recipe`; `runs` is the run of each row, if the rate is that of
/// the next run, and `segment_s` is the duration of a segment, if known.
pub(crate) fn train(
    rows: Rows<'_>,
    (runs, segment_s): (Option<&[usize]>, Option<f64>),
    recipe: &Recipe,
    densities: &GaussianClasses,
) -> Result<Watch, Error> {
    let Rows { table, names, .. } = rows;
    let rows_of_runs = TrainingSet::Rows { table, runs };
    watch((names, segment_s), recipe, densities, &|alarms| gate(rows, runs, alarms), &rows_of_runs)
}

/// Returns the gate by `gate`, and the constants of the alarm.
fn watch(
    (names, segment_s): (&[String], Option<f64>),
    recipe: &Recipe,
    densities: &GaussianClasses,
    gate: &dyn Fn(&Alarms) -> Result<GateOrReason, Error>,
    set: &TrainingSet<'_>,
) -> Result<Watch, Error> {
    let alarms = &recipe.alarms;
    if alarms.reject_cost.is_nan() || alarms.reject_cost < 0.0 {
        return Err(Error::Usage("--reject-cost is not negative".into()));
    }
    if alarms.healthy.is_none() {
        return Ok(Watch::without(None));
    }
    let segments = segments_between(alarms.interval, segment_s)?;
    let gate = match gate(alarms)? {
        Ok(gate) => gate,
        Err(problem) => return Ok(Watch::without(Some(problem + "; none is set"))),
    };
    let usual = gate.runs.as_ref().filter(|_| !alarms.other_drive).map_or(1, |runs| runs.longest as u32);
    let run = (alarms.segments_a_run.unwrap_or(usual), alarms.other_drive);
    let found = alarm::constants(&gate, densities.means.len(), segments, run).map(|evidence| {
        let defect_log_mean = ratios::log_mean((set, names), recipe, (densities, gate.runs.as_ref()), evidence.cap);
        EvidenceConstants { defect_log_mean, ..evidence }
    });
    let (evidence, refused) = match found {
        Ok(evidence) => (evidence, None),
        Err(Error::Training(problem)) if !alarms.required => {
            (EvidenceConstants::NONE, Some(problem + "; there is none"))
        }
        Err(problem) => return Err(problem),
    };
    let warnings: Vec<String> = gate.warning(alarms.false_alarm).into_iter().chain(refused).collect();
    let warning = (!warnings.is_empty()).then(|| warnings.join("; "));
    Ok(Watch { gate: Some(gate), evidence, segments, warning })
}

/// Returns the gate of the healthy class, or why there is none.
///
/// # Errors
/// Settings out of range; no gate although one is required.
fn gate(
    Rows { table, names, fitted, rising }: Rows<'_>,
    runs: Option<&[usize]>,
    alarms: &Alarms,
) -> Result<GateOrReason, Error> {
    let class = alarms.healthy.ok_or_else(|| Error::Training("no healthy class".into()))?;
    let healthy = Healthy { fitted, ..Healthy::of(table, class, runs) };
    let scarcity = healthy.scarcity(names, alarms.false_alarm);
    checked(alarms, scarcity, || healthy.gate(class, (names, rising), alarms.false_alarm))
}

/// Returns the gate if rate and segments allow it.
fn checked(
    alarms: &Alarms,
    scarcity: Option<String>,
    gate: impl FnOnce() -> Result<Gate, Error>,
) -> Result<GateOrReason, Error> {
    let rate = alarms.false_alarm;
    if !(1e-9..=0.5).contains(&rate) {
        return Err(Error::Usage(format!("--false-alarm {rate}: give a rate from 1e-9 to 0.5 a segment")));
    }
    match scarcity {
        Some(problem) if alarms.required => Err(Error::Training(problem)),
        Some(problem) => Ok(Err(problem)),
        None => gate().map(Ok),
    }
}

/// Returns the gate of the healthy class; too few rows are an error.
pub(crate) fn required_gate(rows: Rows<'_>, runs: Option<&[usize]>, alarms: &Alarms) -> Result<Gate, Error> {
    let alarms = Alarms { required: true, ..alarms.clone() };
    gate(rows, runs, &alarms)?.map_err(Error::Training)
}

/// Returns the number of rows of a class that have the coordinate which is missing most often, and this coordinate; all
/// rows and none if no coordinate is missing.
fn rows_of(table: &FeatureTable, class: usize) -> (usize, Option<usize>) {
    let rows = table.classes.iter().filter(|c| **c == class).count();
    let coordinates = table.rows.first().map_or(0, DVector::len);
    let with = |k: usize| (table.with(class, k).count(), Some(k));
    (0..coordinates).map(with).filter(|(count, _)| *count < rows).min().unwrap_or((rows, None))
}

/// Returns the smallest number of independent segments from which a gate can be trained that is not too far out for its
/// rate.
#[must_use]
pub fn fewest(coordinates: usize, rate: f64) -> usize {
    fewest_near(coordinates, rate, FARTHEST)
}

/// Returns the smallest number of rows from which a gate is near enough by [`is_near`].
fn fewest_near(coordinates: usize, rate: f64, factor: f64) -> usize {
    let near = |&rows: &usize| is_near(coordinates, rows, rate, factor);
    (coordinates + 2..).take(1000).find(near).unwrap_or(coordinates + 1000)
}

/// Returns whether the d² of a gate of so many segments exceeds that of known mean and covariance by at most a factor.
fn is_near(coordinates: usize, rows: usize, rate: f64, factor: f64) -> bool {
    let known = ChiSquared::new(coordinates as f64).map_or(f64::NAN, |law| law.inverse_cdf(1.0 - rate));
    DistanceLaw::gaussian(coordinates, rows).squared_at(-rate.ln()) <= factor * known
}

/// Returns the gate of healthy rows alone.
///
/// # Errors
/// Too few rows for the rate, or coordinates that are constant or depend on each other.
pub fn gate_of(healthy: &[DVector<f64>], rate: f64) -> Result<Gate, Error> {
    gate_of_table(&FeatureTable::exact(healthy.to_vec(), vec![0; healthy.len()], vec!["healthy".into()]), rate)
}

/// Returns the gate of a table of healthy rows alone, whose values may have errors or be missing.
///
/// # Errors
/// As [`gate_of`].
pub fn gate_of_table(table: &FeatureTable, rate: f64) -> Result<Gate, Error> {
    gate_of_runs(table, None, rate)
}

/// Returns the gate for the next run of a table of healthy rows alone, each of a run with a number in the order of
/// time.
///
/// # Errors
/// As [`gate_of`], for the number of runs.
pub fn gate_of_runs(table: &FeatureTable, runs: Option<&[usize]>, rate: f64) -> Result<Gate, Error> {
    gate_of_rising(table, runs, 0, rate)
}

/// Returns the gate for the next run of a table whose last `rising` coordinates only become larger with a defect.
///
/// # Errors
/// As [`gate_of_runs`].
pub fn gate_of_rising(table: &FeatureTable, runs: Option<&[usize]>, rising: usize, rate: f64) -> Result<Gate, Error> {
    let names: Vec<String> = (1..=table.rows.first().map_or(0, DVector::len)).map(|k| format!("z{k}")).collect();
    let rows = Rows { table, names: &names, fitted: 0, rising };
    required_gate(rows, runs, &Alarms { healthy: Some(0), false_alarm: rate, ..Alarms::default() })
}

/// What must suffice for the rate of a gate.
enum Counted {
    Runs(usize),
    /// Rows that have the coordinate which is missing most often, and this coordinate.
    Rows((usize, Option<usize>)),
}

/// Says why there are too few segments or runs for a gate at this rate.
fn scarcity(counted: Counted, fitted: usize, names: &[String], rate: f64) -> Option<String> {
    let (rows, scarce) = match counted {
        Counted::Runs(count) => {
            let count = count.saturating_sub(fitted);
            return (count < runs::fewest(names.len(), rate)).then(|| runs::refusal(names.len(), count, rate));
        }
        Counted::Rows(own) => own,
    };
    let least = fewest(names.len(), rate);
    let with = scarce.map_or_else(String::new, |k| format!(" with {}", names[k]));
    (rows.saturating_sub(fitted) < least).then(|| {
        format!(
            "{rows} healthy segments{with} are too few for a novelty gate of {} coordinates at a false-alarm rate of \
             {rate}; give at least {least}, shorter segments, fewer features, or a higher rate",
            names.len()
        )
    })
}

/// The healthy rows of a table, and their runs if these count.
struct Healthy {
    table: FeatureTable,
    /// Run of each row, from 0 in their order, and the number of runs.
    runs: Option<(Vec<usize>, usize)>,
    /// Number of coefficients that were fitted to a feature beforehand; each takes a degree of freedom.
    fitted: usize,
}

impl Healthy {
    fn of(table: &FeatureTable, class: usize, runs: Option<&[usize]>) -> Self {
        let own: Vec<usize> = (0..table.rows.len()).filter(|&row| table.classes[row] == class).collect();
        let mut healthy = table.keep(&own);
        (healthy.classes, healthy.names) = (vec![0; own.len()], vec![table.names[class].clone()]);
        let Some(runs) = runs else { return Self { table: healthy, runs: None, fitted: 0 } };
        let of_rows: Vec<usize> = own.iter().map(|&row| runs[row]).collect();
        let (rows, numbers, count) = runs::complete(&healthy, &of_rows);
        // Runs of one segment each are independent segments.
        let single = numbers.len() == count && count == own.len();
        let kept = if single { healthy } else { healthy.keep(&rows) };
        Self { table: kept, runs: (!single).then_some((numbers, count)), fitted: 0 }
    }

    /// Says why there are too few segments or runs for a gate at this rate.
    fn scarcity(&self, names: &[String], rate: f64) -> Option<String> {
        let counted = match &self.runs {
            Some((_, count)) => Counted::Runs(*count),
            None => Counted::Rows(rows_of(&self.table, 0)),
        };
        scarcity(counted, self.fitted, names, rate)
    }

    /// Factor of a covariance of so many rows or runs whose coefficients took degrees of freedom.
    fn wider(&self, rows: usize) -> f64 {
        let freedom = rows.saturating_sub(1) as f64;
        freedom / (freedom - self.fitted as f64).max(1.0)
    }

    fn gate(&self, class: usize, (names, rising): (&[String], usize), rate: f64) -> Result<Gate, Error> {
        let (healthy, all, rows) = (&self.table, names.len(), self.table.rows.len());
        let refuse = |dependent| singular(&format!("class {}", healthy.names[0]), rows, 1, names, dependent);
        let (limit, rows_needed) = (-rate.ln(), spread::rows_needed(all, rate));
        let gate = |mean, covariance, law: DistanceLaw, runs: Option<RunSpread>| {
            let freedom = runs.as_ref().map_or(rows as f64 - 1.0, |runs| runs.freedom);
            let rising = self.rising(rising, (&mean, &covariance), freedom, (names, rate))?;
            let knots = knots::knots(&law, limit);
            Ok(Gate { class, mean, covariance, knots, limit, law, rising, rows, runs, rows_needed })
        };
        if let Some((runs, count)) = &self.runs {
            let runs::NextRun { mean, covariance, law, spread } =
                runs::next_run(healthy, runs, *count).map_err(refuse)?;
            let covariance = covariance * self.wider(*count);
            return gate(mean, covariance, law, Some(spread));
        }
        let statistics = ClassStatistics::of(healthy, names)?;
        let (mean, covariance) = (statistics.means[0].clone(), statistics.pooled * self.wider(rows));
        whitening(&covariance).map_err(refuse)?;
        let law = self.law((&mean, &covariance), all).ok_or_else(|| refuse(0))?;
        gate(mean, covariance, law, None)
    }

    /// Returns the law of the distance of independent segments from this mean and covariance.
    fn law(&self, (mean, covariance): (&DVector<f64>, &DMatrix<f64>), all: usize) -> Option<DistanceLaw> {
        let found = Moments { means: vec![mean.clone()], covariance: covariance.clone() };
        let squared = moments::left_out(&self.table.observed(), &found)?;
        let squared: Vec<f64> = squared.into_iter().map(|(squared, k)| law::equivalent(squared, k, all)).collect();
        Some(DistanceLaw::of(all, rows_of(&self.table, 0).0 - self.fitted, &squared))
    }

    /// Returns the laws of the last coordinates, which rise; `None` without any.
    fn rising(
        &self,
        count: usize,
        healthy: (&DVector<f64>, &DMatrix<f64>),
        freedom: f64,
        (names, rate): (&[String], f64),
    ) -> Result<Option<Rising>, Error> {
        if count == 0 {
            return Ok(None);
        }
        let first = names.len() - count;
        let law = |table: FeatureTable, names: &[String]| {
            let alone = Self { table, runs: self.runs.clone(), fitted: self.fitted };
            alone.gate(0, (names, 0), rate).map(|gate| gate.law)
        };
        let of_others = || law(self.table.select(&(0..first).collect::<Vec<_>>()), &names[..first]);
        let others = (first > 0).then(of_others).transpose()?;
        let singular = || Error::Training("the healthy covariance is singular".into());
        let scores = self.conditional(healthy).ok_or_else(singular)?;
        let each = |k: usize| {
            let own = scores.select(&[k]);
            if self.runs.is_some() {
                return law(own, &names[k..=k]).map(|law| ScoreLaw::symmetric(&law));
            }
            let rows = own.with(0, 0).count().saturating_sub(self.fitted + k).max(2);
            Ok(ScoreLaw::of(rows, &left_out(&own).ok_or_else(singular)?))
        };
        let laws = (first..names.len()).map(each).collect::<Result<_, _>>()?;
        Ok(Some(Rising { freedom, laws, others }))
    }

    /// Returns each value less its mean given those before it, in standard deviations.
    fn conditional(&self, healthy: (&DVector<f64>, &DMatrix<f64>)) -> Option<FeatureTable> {
        let mut table = self.table.clone();
        for (value, variance) in table.rows.iter_mut().zip(&mut table.variances) {
            for (k, y) in moments::conditional_scores(healthy, value, variance)? {
                (value[k], variance[k]) = (y, 0.0);
            }
        }
        Some(table)
    }
}

/// Returns each value of one coordinate that is available less the mean of the others, in their standard deviations;
/// `None` if they are constant.
fn left_out(scores: &FeatureTable) -> Option<Vec<f64>> {
    let found = moments::moments(&scores.observed(), 1);
    let mean = found.means.first()?[0];
    let squared = moments::left_out(&scores.observed(), &found)?;
    let all = squared.into_iter().zip(&scores.rows).filter(|((_, available), _)| *available > 0);
    // The mean of the others is on the same side of the value as that of all.
    Some(all.map(|((squared, _), row)| squared.sqrt().copysign(row[0] - mean)).collect())
}

impl Gate {
    /// Returns whether the gate calls these coordinates novel; their errors have these variances.
    pub(crate) fn is_novel(&self, value: &DVector<f64>, variance: &DVector<f64>) -> bool {
        self.surprise(value, variance).is_none_or(|surprise| surprise >= self.limit)
    }

    /// Returns the surprise of these coordinates; `None` if the covariance is singular.
    #[must_use]
    pub fn surprise(&self, value: &DVector<f64>, variance: &DVector<f64>) -> Option<f64> {
        let healthy = (&self.mean, &self.covariance);
        match &self.rising {
            Some(rising) => rising.surprise(healthy, (value, variance)),
            None => moments::squared_distance(healthy, value, variance)
                .map(|(squared, available)| self.law.surprise(law::equivalent(squared, available, value.len()))),
        }
    }

    /// Says what is uncertain about the rate of this gate.
    fn warning(&self, rate: f64) -> Option<String> {
        let Self { rows, runs, rows_needed, .. } = self;
        // So many independent segments have a covariance of the same accuracy.
        let counted = runs.as_ref().map_or(*rows as f64, |runs| runs.freedom + 1.0);
        let counted_as = runs.as_ref().map_or_else(String::new, |runs| {
            format!(" of {} runs, which count as {counted:.0} independent ones,", runs.count)
        });
        (counted < *rows_needed as f64).then(|| {
            format!(
                "{rows} healthy segments{counted_as} keep the false-alarm rate of {rate} in the mean only; from \
                 {rows_needed} on, 95 % of such gates have at most {} times the rate",
                spread::BOUND
            )
        })
    }
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
