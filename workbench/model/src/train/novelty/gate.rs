//! The novelty gate in double precision, and whether there are enough segments or runs for its rate.

use bearing_watch::model::KNOTS;
use nalgebra::{DMatrix, DVector};

use super::alarms::Alarms;
use super::laws::law::{self, DistanceLaw, fewest};
use super::laws::rising::Rising;
use super::laws::spread;
use super::runs::{self, RunSpread};
use crate::Error;
use crate::train::distribution::moments;

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
    /// The coordinate in which healthy segments, or the means of their runs, are skewed most, if they are.
    pub skewed: Option<String>,
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

    /// Number of independent segments whose covariance has the same accuracy.
    #[must_use]
    pub fn counted(&self) -> f64 {
        self.runs.as_ref().map_or(self.rows as f64, |runs| runs.freedom + 1.0)
    }

    /// The least rate that is known from counts, without the law of the distances: one in the number of segments, or of
    /// runs with the next one, which is the farthest of all in one of so many cases.
    pub(crate) fn least_counted_rate(&self) -> f64 {
        self.runs.as_ref().map_or_else(|| 1.0 / self.rows.max(1) as f64, |runs| 1.0 / (runs.count as f64 + 1.0))
    }

    /// Says what is uncertain about the rate of this gate.
    pub(super) fn warning(&self, rate: f64) -> Option<String> {
        let Self { rows, runs, rows_needed, .. } = self;
        let counted = self.counted();
        let counted_as = runs.as_ref().map_or_else(String::new, |runs| {
            format!(" of {} runs, which count as {counted:.0} independent ones,", runs.count)
        });
        let few = (counted < *rows_needed as f64).then(|| {
            format!(
                "{rows} healthy segments{counted_as} keep the false-alarm rate of {rate} in the mean only; from \
                 {rows_needed} on, 95 % of such gates have at most {} times the rate",
                spread::BOUND
            )
        });
        let unsupported = runs.as_ref().filter(|_| self.least_counted_rate() > rate);
        let free = unsupported.map(|runs| {
            format!(
                "the rate is that of normally distributed means of runs; without this law {} runs support {:.0} %",
                runs.count,
                100.0 * self.least_counted_rate()
            )
        });
        let all: Vec<String> = few.into_iter().chain(free).chain(self.wider()).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }

    /// Says why the gate is further out than that of a usual law.
    fn wider(&self) -> Option<String> {
        let what = if self.runs.is_some() { "the means of healthy runs" } else { "healthy segments" };
        let why = match (&self.skewed, self.law.excess()) {
            (None, None) => return None,
            (Some(name), _) => format!("{what} are skewed in {name}"),
            (None, Some(_)) => "more healthy segments are far out than by a normal law".into(),
        };
        let effect = match self.law.excess() {
            Some(_) => "the gate is further out, and finds larger defects only",
            None => "the rate of false alarms may differ from the set one",
        };
        Some(format!("{why}: {effect}; look at the page of the training for a cause that a covariate could explain"))
    }
}

/// A gate, or why there is none.
pub(super) type GateOrReason = Result<Gate, String>;

/// Returns the gate if rate and segments allow it.
pub(super) fn checked(
    alarms: &Alarms,
    scarcity: impl FnOnce() -> Option<String>,
    gate: impl FnOnce() -> Result<Gate, Error>,
) -> Result<GateOrReason, Error> {
    let rate = alarms.false_alarm;
    if !(1e-9..=0.5).contains(&rate) {
        return Err(Error::Usage(format!("--false-alarm {rate}: give a rate from 1e-9 to 0.5 a segment")));
    }
    match scarcity() {
        Some(problem) if alarms.required => Err(Error::Training(problem)),
        Some(problem) => Ok(Err(problem)),
        None => gate().map(Ok),
    }
}

/// What must suffice for the rate of a gate.
pub(crate) enum Counted {
    Runs(usize),
    /// Rows that have the coordinate which is missing most often, and this coordinate.
    Rows((usize, Option<usize>)),
}

/// Says why there are too few segments or runs for a gate at this rate.
pub(crate) fn scarcity(counted: Counted, fitted: usize, names: &[String], rate: f64) -> Option<String> {
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
