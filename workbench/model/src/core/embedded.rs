//! Runs a model of any layout over traces with the core's [`Detector`], the code that firmware runs.

use bearing_watch::model::{Direction, EvidenceConstants, Fall, Feature, Sampling, ShaftConstants};
use bearing_watch::plan::RunTime;
use bearing_watch::{Cause, Decision, Detector, Evidence, Model, ModelError, Reason, Report, Verdict};

use super::coordinates;
use super::features::{Catalogue, shaft_values};
use super::segment::{Finding, SegmentReport};
use super::watch::{self, AlarmState};
use super::wiring::{Feed, Field, column, fields};
use super::words::explain;
use crate::identify::Structure;
use crate::trace::{Channels, Trace};

/// A model of the core, ready to run over traces.
#[derive(Clone, Debug)]
pub struct Embedded {
    model: Model<RunTime>,
    fields: Vec<Field>,
    /// Class names.
    pub classes: Vec<String>,
}

/// Whether each covariate was missing or outside its range, as far as the report says it.
fn outside(report: &Report<RunTime>) -> Vec<bool> {
    match (&report.decision, report.verdict) {
        (Some(decision), _) => decision.outside().to_vec(),
        (None, Verdict::Undetermined(Reason::OutOfRange { covariate })) => {
            (0..=covariate).map(|k| k == covariate).collect()
        }
        _ => vec![],
    }
}

impl Embedded {
    /// Builds it from a model of the core.
    ///
    /// # Errors
    /// [`ModelError::OtherPlan`] if the columns of its channels are not known.
    pub fn new(model: Model<RunTime>) -> Result<Self, ModelError> {
        let layout = model.plan().layout();
        let classes = (0..layout.classes).map(|class| model.label(class).to_string()).collect();
        let fields = fields(&layout).map_err(|_| ModelError::OtherPlan)?;
        Ok(Self { fields, classes, model })
    }

    /// Reads a binary model.
    ///
    /// # Errors
    /// Errors of the core.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        Self::new(Model::from_bytes(bytes)?)
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> &Model<RunTime> {
        &self.model
    }

    /// The samples of a trace, one at a time.
    #[must_use]
    pub fn feed<'a>(&self, trace: &'a Trace) -> Feed<'a> {
        Feed::new(trace, &self.fields, self.model.plan().layout().needs_angle())
    }

    /// The report of the first segment if it ended after each multiple of `every` samples.
    #[must_use]
    pub fn previews(&self, trace: &Trace, every: usize) -> Vec<SegmentReport> {
        let mut detector = Detector::new(&self.model);
        let mut previews = Vec::new();
        let mut feed = self.feed(trace);
        for k in 0..trace.y.len() {
            let closed = detector.step(feed.at(k));
            let last = closed.is_some();
            if (k + 1).is_multiple_of(every) {
                let report = closed.unwrap_or_else(|| detector.preview());
                previews.push(SegmentReport { length: k + 1, ..self.segment(&report) });
            }
            if last {
                break;
            }
        }
        previews
    }

    /// The core's report on a whole trace.
    #[must_use]
    pub fn whole(&self, trace: &Trace) -> Report<RunTime> {
        let mut detector = Detector::new(&self.model);
        let mut feed = self.feed(trace);
        // Not by a fold: it would move a report of some kilobytes, or the place of none, with every sample.
        let closed = (0..trace.y.len()).find_map(|k| detector.step(feed.at(k)));
        closed.unwrap_or_else(|| detector.finish())
    }

    pub(super) fn segment(&self, report: &Report<RunTime>) -> SegmentReport {
        let decided = |pick: fn(&bearing_watch::Decision<RunTime>) -> &[f32]| {
            report.decision.as_ref().map_or_else(Vec::new, |decision| pick(decision).to_vec())
        };
        let (estimate, shaft) = (report.estimate(), report.shaft());
        let features = &self.model.constants().classifier.features;
        let missing = report.decision.iter().flat_map(|decision| decision.missing().iter().zip(features));
        SegmentReport {
            verdict: match report.verdict {
                Verdict::Undetermined(reason) => Err(explain(reason, report, &self.model)),
                verdict => Finding::of(verdict).ok_or_else(String::new),
            },
            posteriors: decided(|d| d.posteriors()),
            log_likelihoods: decided(|d| d.log_likelihoods()),
            beyond: report.decision.as_ref().map_or_else(Vec::new, |decision| decision.beyond().to_vec()),
            directed: report.decision.as_ref().map_or_else(Vec::new, |decision| decision.directed().to_vec()),
            reason: match report.verdict {
                Verdict::Undetermined(reason) => Some(reason),
                _ => None,
            },
            distance: report.decision.as_ref().map_or(0.0, |decision| decision.distance),
            distance_surprise: report.decision.as_ref().map_or(0.0, |decision| decision.distance_surprise),
            surprise: report.decision.as_ref().map_or(0.0, |decision| decision.surprise),
            most: report.decision.as_ref().and_then(|decision| decision.most),
            fall: report.decision.as_ref().map_or_else(Fall::default, |decision| decision.fall),
            smallest: self.smallest(report),
            delta: estimate.map_or_else(Vec::new, |estimate| estimate.delta().to_vec()),
            raw: estimate.map_or_else(Vec::new, |estimate| estimate.raw()),
            variance: estimate.map_or(0.0, |estimate| estimate.variance),
            estimated: estimate.is_some_and(|estimate| estimate.reason.is_none()),
            missing: missing.filter(|(missing, _)| **missing).map(|(_, feature)| *feature).collect(),
            averages: report.averages().to_vec(),
            outside: outside(report),
            friction: shaft.map(|shaft| shaft.friction),
            orders: shaft.map_or_else(Vec::new, |shaft| shaft.orders().to_vec()),
            shaft_features: shaft
                .zip(self.shaft())
                .map_or_else(Vec::new, |(shaft, own)| shaft_values(self.model.plan(), shaft, &own.balance)),
            rows: estimate.filter(|own| own.reason.is_none()).map_or(report.rows, |own| own.rows),
            counts: report.counts,
            start: 0,
            length: 0,
        }
    }

    /// The smallest defects of a report with the coordinates that rise with them.
    fn smallest(&self, report: &Report<RunTime>) -> Vec<(u8, f32)> {
        let layout = self.model.plan().layout();
        (layout.coordinates - layout.rising..layout.coordinates).zip(report.smallest().iter().copied()).collect()
    }

    /// Constants of the shaft, if it is watched.
    #[must_use]
    pub fn shaft(&self) -> Option<&ShaftConstants<RunTime>> {
        self.model.constants().shaft.first()
    }

    /// Structure of the regression, if there is one.
    #[must_use]
    pub fn structure(&self) -> Option<Structure> {
        self.model.plan().layout().regression.map(|regression| regression.structure)
    }

    /// What the detector estimates, in words, by the names of the tracked orders.
    #[must_use]
    pub fn estimates(&self, orders: &[String]) -> String {
        let difference = self
            .structure()
            .map(|own| format!("the difference model {}", own.orders().map(|count| count.to_string()).join(",")));
        let balance = self.shaft().map(|_| "the torque balance".to_owned());
        let tracked = (!orders.is_empty()).then(|| format!("the orders {}", orders.join(", ")));
        difference.into_iter().chain(balance).chain(tracked).collect::<Vec<_>>().join("; ")
    }

    /// The signals that the detector takes of a recording, by their columns there.
    #[must_use]
    pub fn signals<'a>(&'a self, recorded: &'a Channels) -> Vec<(&'a str, Field)> {
        let named = self.fields.iter().zip(self.channel_names());
        named.map(|(field, name)| (column(*field, recorded).unwrap_or(name), *field)).collect()
    }

    /// Names of the model's channels.
    #[must_use]
    pub fn channel_names(&self) -> Vec<&str> {
        self.model.constants().channels.iter().map(|channel| channel.name.as_str()).collect()
    }

    /// Names of the features, by those of the tracked orders.
    #[must_use]
    pub fn catalogue(&self, orders: &[String]) -> Catalogue {
        Catalogue::of_model(&self.model, orders)
    }

    /// Names of the coordinates, by those of the tracked orders ([`coordinates`]).
    #[must_use]
    pub fn coordinate_names(&self, orders: &[String]) -> Vec<String> {
        coordinates::of_model(&self.model, orders)
    }

    /// Name of a coordinate.
    #[must_use]
    pub fn coordinate_name(&self, orders: &[String], place: u8) -> String {
        let (names, place) = (self.coordinate_names(orders), usize::from(place));
        coordinates::name(place, names.get(place).map(String::as_str))
    }

    /// Name of the feature at a place in the core's order.
    #[must_use]
    pub fn feature_name(&self, orders: &[String], place: u8) -> String {
        let feature = self.model.constants().classifier.features.get(usize::from(place));
        feature.map_or_else(|| "unknown".into(), |feature| self.catalogue(orders).name(*feature))
    }

    /// Name of the coordinate that a direction of the alarm watches.
    #[must_use]
    pub fn direction_coordinate(&self, orders: &[String], direction: u8) -> String {
        let watched = self.watched().get(usize::from(direction));
        watched.map_or_else(|| "unknown".into(), |direction| self.coordinate_name(orders, direction.coordinate))
    }

    fn watched(&self) -> &[Direction] {
        &self.model.constants().classifier.novelty.directions.list
    }

    /// Number of directions that the alarm watches.
    #[must_use]
    pub fn directions(&self) -> u8 {
        u8::try_from(self.watched().len()).unwrap_or(u8::MAX)
    }

    /// Mean of the values of a direction, with the weights of the segments of a run; `None` if they have none.
    pub(crate) fn mean_in_direction(&self, segments: &[SegmentReport], place: u8) -> Option<f64> {
        let within = f64::from(self.watched().get(usize::from(place))?.segment);
        let determined = segments.iter().filter(|segment| segment.verdict.is_ok());
        let values = determined.filter_map(|segment| segment.directed.get(usize::from(place)));
        let known = values.filter(|value| !value.is_missing());
        let weighted = known.map(|value| {
            let weight = 1.0 / (1.0 + f64::from(value.variance) / within);
            (weight, weight * f64::from(value.value))
        });
        let (weights, sum) = weighted.fold((0.0, 0.0), |all, one| (all.0 + one.0, all.1 + one.1));
        (weights > 0.0).then(|| sum / weights)
    }

    /// The same with the coordinates that are subtracted from it.
    #[must_use]
    pub fn direction_name(&self, orders: &[String], direction: u8) -> String {
        let watched = self.watched().get(usize::from(direction));
        let terms = watched.map_or(&[][..], |direction| &direction.background);
        let subtracted = terms.iter().filter(|term| term.weight != 0.0);
        let background: Vec<String> = subtracted.map(|term| self.coordinate_name(orders, term.coordinate)).collect();
        let name = self.direction_coordinate(orders, direction);
        if background.is_empty() { name } else { format!("{name} given {}", background.join(", ")) }
    }

    /// The covariates that were missing or outside their range.
    #[must_use]
    pub fn outside(&self, segment: &SegmentReport) -> Vec<Feature> {
        let list = self.model.constants().classifier.covariates.list.iter().zip(&segment.outside);
        list.filter(|(_, outside)| **outside).map(|(own, _)| own.feature).collect()
    }

    /// Rates and segment length.
    #[must_use]
    pub const fn sampling(&self) -> Sampling {
        self.model.constants().sampling
    }

    /// Index of the healthy class, if the model has one.
    #[must_use]
    pub fn healthy(&self) -> Option<usize> {
        self.model.constants().classifier.novelty.class.map(usize::from)
    }

    /// Constants of the alarm.
    #[must_use]
    pub const fn evidence_constants(&self) -> EvidenceConstants {
        self.model.constants().evidence
    }

    /// The class or coordinate that the alarm names; `unknown` if it names none. `orders` are the names of the orders.
    #[must_use]
    pub fn cause(&self, watched: &AlarmState, orders: &[String]) -> Option<String> {
        watched.alarm.map(|alarm| match alarm.cause {
            Cause::Class(class) => self.classes.get(usize::from(class)).cloned().unwrap_or_default(),
            Cause::Unknown => "unknown".into(),
            Cause::Coordinate(place) => self.coordinate_name(orders, place),
            Cause::Fallen(place) => format!("{} lower than usual", self.coordinate_name(orders, place)),
        })
    }

    /// The core's evidence before the first segment of a drive.
    #[must_use]
    pub fn evidence(&self) -> Evidence<RunTime> {
        Evidence::new(&self.model)
    }

    /// The core's decision on a segment; `None` if it had none.
    #[must_use]
    pub fn decision(&self, segment: &SegmentReport) -> Option<Decision<RunTime>> {
        watch::decision(&self.model, segment)
    }

    /// State of the core's evidence after each of these segments; they may come from several traces of one drive, in
    /// another order than the one in which they were recorded.
    #[must_use]
    pub fn watch(&self, segments: &[SegmentReport]) -> Vec<AlarmState> {
        watch::over(&self.model, segments)
    }

    /// Verdict on several independent segments together: their log-likelihoods add up, their surprises combine by
    /// Fisher's method, and they are beyond the gate of a class if most of them are. `None` if no segment has one.
    #[must_use]
    pub fn combine(&self, segments: &[SegmentReport]) -> Option<(Finding, Vec<f32>)> {
        let mut sums = vec![0.0; self.classes.len()];
        let determined = segments.iter().filter(|s| s.verdict.is_ok());
        for segment in determined.clone() {
            sums.iter_mut().zip(&segment.log_likelihoods).for_each(|(sum, value)| *sum += value);
        }
        let count = determined.clone().count();
        count.checked_sub(1)?;
        let beyond_in = |class: usize| determined.clone().filter(|s| s.beyond.get(class) == Some(&true)).count();
        let beyond: Vec<bool> = (0..sums.len()).map(|class| 2 * beyond_in(class) > count).collect();
        self.decide(&sums, watch::combined_surprise(determined.clone().map(|s| s.surprise)), &beyond)
    }

    fn decide(&self, log_likelihoods: &[f32], surprise: f32, beyond: &[bool]) -> Option<(Finding, Vec<f32>)> {
        let classifier = &self.model.constants().classifier;
        let mut decision = classifier.decide(self.model.plan(), log_likelihoods, surprise)?;
        decision.set_beyond(beyond);
        Some((Finding::of(classifier.verdict(&decision))?, decision.posteriors().to_vec()))
    }

    /// Prior probability of each class: the posteriors for equal likelihoods of all classes.
    #[must_use]
    pub fn priors(&self) -> Vec<f64> {
        let even = self.decide(&vec![0.0; self.classes.len()], 0.0, &[]);
        even.map_or_else(Vec::new, |(_, posteriors)| posteriors.into_iter().map(f64::from).collect())
    }

    /// The class decided at these projected coordinates; used to plot decision regions.
    #[must_use]
    pub fn decide_at(&self, coordinates: &[f32]) -> Option<usize> {
        let decision = self.model.constants().classifier.decide_at(self.model.plan(), coordinates, &[])?;
        Some(decision.class as usize)
    }
}
