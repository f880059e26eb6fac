//! A model of any capacity, run over traces through the core's [`Detector`], the code that firmware runs.

use bearing_watch::decide::EvidencePlan;
use bearing_watch::estimate::{Accumulator, Fading, Rows, Triangle, TwoLevel};
use bearing_watch::{Detector, Model, ModelError, Report, Sampling, Shaft, ShaftModel, Verdict};

use super::choice::{AnyRows, Sums};
use super::motion::{MAX_ORDERS, samples, shaft_features};
use super::segment::{Finding, SegmentReport};
use super::watch::{self, Watched};
use super::words::explain;
use crate::identify::Structure;
use crate::trace::Trace;

/// Columns of the largest model there is.
pub const MAX_COLUMNS: usize = 100;

/// A model in the core's form, in the smallest capacity that holds it.
#[derive(Clone, Debug)]
pub struct Embedded {
    model: Sized,
    /// Class names.
    pub classes: Vec<String>,
}

/// A function of these capacities with the sums of the model's memory.
macro_rules! by_memory {
    ($model:ident, [$m:literal $l:literal $f:literal $z:literal $c:literal], $run:ident, $($rest:expr),+) => {{
        const P: usize = $m * ($m - 1) / 2;
        match Sums::of(&$model.regression, &$model.sampling) {
            Sums::Triangle => $run::<$m, P, $l, $f, $z, $c, Triangle<$m, P>>($model, $($rest),+),
            Sums::TwoLevel => $run::<$m, P, $l, $f, $z, $c, TwoLevel<$m, P>>($model, $($rest),+),
            Sums::Fading => $run::<$m, P, $l, $f, $z, $c, Fading<$m, P>>($model, $($rest),+),
        }
    }};
}

/// Capacities that the workbench instantiates: columns, delays, features, coordinates, classes.
macro_rules! capacities {
    ($($name:ident: $m:literal $l:literal $f:literal $z:literal $c:literal;)+) => {
        #[derive(Clone, Debug)]
        enum Sized {
            $($name(Box<Model<$m, $f, $z, $c, MAX_ORDERS>>),)+
        }

        impl Sized {
            fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
                $(
                    match Model::<$m, $f, $z, $c, MAX_ORDERS>::from_bytes(bytes) {
                        // Delays and filters are the detector's capacity, so ask it too.
                        Ok(model) if AnyRows::<$m, $l>::fits(&model.regression) => {
                            return Ok(Self::$name(Box::new(model)));
                        }
                        Ok(_) | Err(ModelError::Capacity(_)) => {}
                        Err(error) => return Err(error),
                    }
                )+
                Err(ModelError::Capacity("columns, delays, features or classes"))
            }

            fn run(&self, trace: &Trace) -> Result<Vec<SegmentReport>, ModelError> {
                match self {
                    $(Self::$name(model) => {
                        by_memory!(model, [$m $l $f $z $c], run, trace)
                    })+
                }
            }

            fn previews(&self, trace: &Trace, every: usize) -> Result<Vec<SegmentReport>, ModelError> {
                match self {
                    $(Self::$name(model) => {
                        by_memory!(model, [$m $l $f $z $c], previews, trace, every)
                    })+
                }
            }

            fn rates(&self) -> Sampling {
                match self {
                    $(Self::$name(model) => model.sampling,)+
                }
            }

            fn shaft(&self) -> Option<&ShaftModel<MAX_ORDERS>> {
                match self {
                    $(Self::$name(model) => model.shaft.as_ref(),)+
                }
            }

            fn structure(&self) -> Structure {
                match self {
                    $(Self::$name(model) => {
                        Structure { order: model.regression.order, offset: model.regression.offset }
                    })+
                }
            }

            fn decide(&self, log_likelihoods: &[f32], surprise: f32) -> Option<(Finding, Vec<f32>)> {
                match self {
                    $(Self::$name(model) => {
                        let mut padded = [f32::NEG_INFINITY; $c];
                        padded.iter_mut().zip(log_likelihoods).for_each(|(cell, value)| *cell = *value);
                        let mut decision = model.classifier.discriminant.decide_from(padded)?;
                        decision.surprise = surprise;
                        let finding = model.classifier.finding(&decision);
                        Some((finding.into(), decision.posteriors[..log_likelihoods.len()].to_vec()))
                    })+
                }
            }

            fn decide_at(&self, coordinates: &[f32]) -> Option<usize> {
                match self {
                    $(Self::$name(model) => {
                        let mut z = [0.0; $z];
                        z.iter_mut().zip(coordinates).for_each(|(cell, value)| *cell = *value);
                        Some(model.classifier.discriminant.decide(&z)?.class as usize)
                    })+
                }
            }

            fn healthy(&self) -> u8 {
                match self {
                    $(Self::$name(model) => model.classifier.novelty.class,)+
                }
            }

            fn plan(&self) -> EvidencePlan {
                match self {
                    $(Self::$name(model) => model.evidence,)+
                }
            }

            fn watch(&self, segments: &[SegmentReport]) -> Vec<Watched> {
                match self {
                    $(Self::$name(model) => watch::watch(model, segments),)+
                }
            }

            fn label_names(&self) -> Vec<String> {
                match self {
                    $(Self::$name(model) => {
                        let count = model.classifier.discriminant.classes;
                        (0..count).map(|k| model.label(k).to_string()).collect()
                    })+
                }
            }
        }
    };
}

capacities! {
    Small: 10 4 10 10 4;
    Medium: 20 8 20 20 8;
    Large: 100 32 100 100 8;
}

fn run<
    const M: usize,
    const P: usize,
    const L: usize,
    const F: usize,
    const Z: usize,
    const C: usize,
    A: Accumulator<M, P>,
>(
    model: &Model<M, F, Z, C, MAX_ORDERS>,
    trace: &Trace,
) -> Result<Vec<SegmentReport>, ModelError> {
    let mut detector = Detector::<'_, M, P, L, F, Z, C, AnyRows<M, L>, A, Shaft<MAX_ORDERS>, MAX_ORDERS>::new(model)?;
    let sizes = sizes(model);
    let mut segments = Vec::new();
    let mut start = 0;
    for (k, (sample, motion)) in samples(trace).enumerate() {
        if let Some(report) = detector.step_with_motion(sample, &motion) {
            segments.push(SegmentReport { start, length: k + 1 - start, ..segment(&report, sizes) });
            start = k + 1;
        }
    }
    // What is left counts only where it is more than half a segment: the model knows the spread of whole ones.
    let (pending, whole) = (detector.pending(), model.sampling.segment_samples);
    if pending > whole / 2 || segments.is_empty() {
        let mut rest = SegmentReport { start, length: trace.y.len() - start, ..segment(&detector.finish(), sizes) };
        if pending <= whole / 2 {
            rest = rest.undetermined(format!("{pending} samples are no more than half a segment of {whole}"));
        }
        segments.push(rest);
    }
    Ok(segments)
}

fn previews<
    const M: usize,
    const P: usize,
    const L: usize,
    const F: usize,
    const Z: usize,
    const C: usize,
    A: Accumulator<M, P>,
>(
    model: &Model<M, F, Z, C, MAX_ORDERS>,
    trace: &Trace,
    every: usize,
) -> Result<Vec<SegmentReport>, ModelError> {
    let mut detector = Detector::<'_, M, P, L, F, Z, C, AnyRows<M, L>, A, Shaft<MAX_ORDERS>, MAX_ORDERS>::new(model)?;
    let sizes = sizes(model);
    let mut previews = Vec::new();
    for (k, (sample, motion)) in samples(trace).enumerate() {
        let closed = detector.step_with_motion(sample, &motion);
        if (k + 1).is_multiple_of(every) {
            let report = closed.unwrap_or_else(|| detector.preview());
            previews.push(SegmentReport { length: k + 1, ..segment(&report, sizes) });
        }
        if closed.is_some() {
            break;
        }
    }
    Ok(previews)
}

/// Runs a function on a thread whose stack holds several copies of the largest model, half a megabyte each. Threads of
/// tests and of the pool have a stack of two megabytes.
pub(crate) fn with_room<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    const STACK: usize = 32 << 20;
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run);
        // Without a thread to be had nothing else runs either.
        match thread.map(std::thread::ScopedJoinHandle::join) {
            Ok(Ok(result)) => result,
            Ok(Err(panic)) => std::panic::resume_unwind(panic),
            Err(error) => panic!("no thread: {error}"),
        }
    })
}

/// Classes and bearing orders in use.
fn sizes<const M: usize, const F: usize, const Z: usize, const C: usize>(
    model: &Model<M, F, Z, C, MAX_ORDERS>,
) -> (usize, usize) {
    let orders = model.shaft.as_ref().map_or(0, |shaft| shaft.tracking.count as usize);
    (model.classifier.discriminant.classes as usize, orders)
}

fn segment<const M: usize, const P: usize, const C: usize>(
    report: &Report<M, P, C, MAX_ORDERS>,
    (classes, orders): (usize, usize),
) -> SegmentReport {
    let n = report.estimate.parameters();
    let decided = |pick: fn(&bearing_watch::Decision<C>) -> [f32; C]| {
        report.decision.map_or_else(Vec::new, |decision| pick(&decision)[..classes].to_vec())
    };
    SegmentReport {
        verdict: match report.verdict {
            Verdict::Undetermined(reason) => Err(explain(reason, report)),
            verdict => Finding::of(verdict).ok_or_else(String::new),
        },
        posteriors: decided(|d| d.posteriors),
        log_likelihoods: decided(|d| d.log_likelihoods),
        distance: report.decision.map_or(0.0, |decision| decision.distance),
        surprise: report.decision.map_or(0.0, |decision| decision.surprise),
        delta: report.estimate.delta[..n].to_vec(),
        raw: report.estimate.raw()[..n].to_vec(),
        variance: report.estimate.variance,
        friction: report.shaft.map(|shaft| shaft.friction),
        orders: report.shaft.map_or_else(Vec::new, |shaft| shaft.orders[..orders].to_vec()),
        shaft_features: shaft_features(report, orders),
        rows: report.estimate.rows,
        counts: report.estimate.counts,
        start: 0,
        length: 0,
    }
}

impl Embedded {
    /// Reads a binary model into the smallest capacity that holds it.
    ///
    /// # Errors
    /// Whatever the core refuses the bytes for.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        let model = with_room(|| Sized::from_bytes(bytes))?;
        Ok(Self { classes: model.label_names(), model })
    }

    /// Runs one trace through the detector; a partial last segment counts where it is more than half a segment.
    ///
    /// # Errors
    /// Where the detector refuses the model.
    pub fn run(&self, trace: &Trace) -> Result<Vec<SegmentReport>, ModelError> {
        self.model.run(trace)
    }

    /// What is known of the shaft, where it is watched.
    #[must_use]
    pub fn shaft(&self) -> Option<&ShaftModel<MAX_ORDERS>> {
        self.model.shaft()
    }

    /// Order and constant of the regression.
    #[must_use]
    pub fn structure(&self) -> Structure {
        self.model.structure()
    }

    /// What the first segment would say if it ended after each multiple of `every` samples.
    ///
    /// # Errors
    /// Where the detector refuses the model.
    pub fn previews(&self, trace: &Trace, every: usize) -> Result<Vec<SegmentReport>, ModelError> {
        self.model.previews(trace, every)
    }

    /// Rates and segment length.
    #[must_use]
    pub fn sampling(&self) -> Sampling {
        self.model.rates()
    }

    /// Index of the healthy class, where the model knows one.
    #[must_use]
    pub fn healthy(&self) -> Option<usize> {
        Some(usize::from(self.model.healthy())).filter(|class| *class < self.classes.len())
    }

    /// Constants of the alarm.
    #[must_use]
    pub fn evidence_plan(&self) -> EvidencePlan {
        self.model.plan()
    }

    /// State of the core's evidence after each of these segments, which may be of several traces of one drive.
    #[must_use]
    pub fn watch(&self, segments: &[SegmentReport]) -> Vec<Watched> {
        self.model.watch(segments)
    }

    /// Verdict over several independent segments: their log-likelihoods add up, and their surprises combine by Fisher's
    /// method. Nothing where no segment has one.
    #[must_use]
    pub fn combine(&self, segments: &[SegmentReport]) -> Option<(Finding, Vec<f32>)> {
        let mut sums = vec![0.0; self.classes.len()];
        let determined = segments.iter().filter(|s| s.verdict.is_ok());
        for segment in determined.clone() {
            sums.iter_mut().zip(&segment.log_likelihoods).for_each(|(sum, value)| *sum += value);
        }
        determined.clone().count().checked_sub(1)?;
        self.model.decide(&sums, watch::combined_surprise(determined.map(|s| s.surprise)))
    }

    /// Prior of each class: the posteriors where every class is as likely.
    #[must_use]
    pub fn priors(&self) -> Vec<f64> {
        let even = self.model.decide(&vec![0.0; self.classes.len()], 0.0);
        even.map_or_else(Vec::new, |(_, posteriors)| posteriors.into_iter().map(f64::from).collect())
    }

    /// The class decided at projected coordinates, for plots of decision regions.
    #[must_use]
    pub fn decide_at(&self, coordinates: &[f32]) -> Option<usize> {
        self.model.decide_at(coordinates)
    }
}
