//! Sections on segments with their verdicts: features over runs, features in a plane, distance and evidence.

use bearing_watch::Counts;

use crate::page::or_reason;
use crate::plot::{self, Panel, RunPoint, Series, Span, Strip};
use crate::{Class, Color};
use model::core::features::Catalogue;
use model::core::{Embedded, Finding, SegmentReport};
use model::evaluate::TraceVerdict;
use model::train::features_of;

/// Chosen features of segments.
#[derive(Clone, Copy, Debug)]
pub struct Chosen<'a> {
    /// All features.
    pub catalogue: &'a Catalogue,
    /// Names of the chosen ones.
    pub names: &'a [String],
}

impl Chosen<'_> {
    /// The values of a segment; NaN where one is missing.
    #[must_use]
    pub fn values(&self, segment: &SegmentReport) -> Vec<f64> {
        let all = self.catalogue.names();
        let (values, variances) = features_of(segment, self.catalogue);
        let place = |name: &String| all.iter().position(|own| own == name);
        let value = |k: usize| if variances[k].is_finite() { values[k] } else { f64::NAN };
        self.names.iter().map(|name| place(name).map_or(f64::NAN, value)).collect()
    }
}

/// The segments of all traces as points over runs; `runs` are the run of each trace.
#[must_use]
pub fn points(chosen: Chosen, verdicts: &[TraceVerdict], runs: Option<&[String]>) -> Vec<RunPoint> {
    let of_trace = |(k, verdict): (usize, &TraceVerdict)| {
        let run = runs.and_then(|runs| runs.get(k).cloned());
        let point = |segment: &SegmentReport| RunPoint {
            trace: verdict.id.clone(),
            run: run.clone(),
            class: verdict.class,
            novel: segment.verdict == Ok(Finding::Novel),
            values: chosen.values(segment),
        };
        verdict.segments.iter().map(point).collect::<Vec<_>>()
    };
    let mut points: Vec<RunPoint> = verdicts.iter().enumerate().flat_map(of_trace).collect();
    // Neighbours of one run stand together, in the order in which runs begin.
    let mut order: Vec<Option<String>> = Vec::new();
    points.iter().for_each(|point| {
        if !order.contains(&point.run) {
            order.push(point.run.clone());
        }
    });
    points.sort_by_key(|point| order.iter().position(|run| *run == point.run));
    points
}

/// The chosen features of all segments in the order of their runs.
#[must_use]
pub fn over_runs(names: &[String], classes: &[String], points: &[RunPoint]) -> String {
    or_reason(plot::features_over_runs("Features over runs", names, &Class::all(classes), points))
}

/// Place of a finding in [`Class::findings`] of this number of classes.
#[must_use]
pub fn place(segment: &SegmentReport, classes: usize) -> usize {
    match &segment.verdict {
        Ok(Finding::Class(class)) => *class,
        Ok(Finding::Novel) => classes,
        Ok(Finding::Ambiguous) => classes + 1,
        Err(_) => classes + 2,
    }
}

/// A judged interval of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// Start and end on the horizontal axis.
    pub span: (f64, f64),
    /// Place of the finding in [`Class::findings`].
    pub place: usize,
    /// Distance from healthy, in its standard deviations; NaN without a verdict.
    pub distance: f64,
    /// Surprise, nats; NaN without a verdict.
    pub surprise: f64,
    /// Evidence after it, nats.
    pub score: Option<f64>,
    /// Index of what was wrong with its data: rejected or saturated samples, a stuck channel, a covariate.
    pub trouble: Option<usize>,
}

impl Judged {
    /// An undetermined segment without values, among this number of classes.
    #[must_use]
    pub const fn blank(classes: usize) -> Self {
        let (span, place) = ((0.0, 1.0), classes + 2);
        Self { span, place, distance: f64::NAN, surprise: f64::NAN, score: None, trouble: None }
    }

    /// A segment at this place of the axis, with the evidence after it.
    #[must_use]
    pub fn new(span: (f64, f64), segment: &SegmentReport, score: Option<f32>, classes: usize) -> Self {
        let far = |value: f32| if segment.verdict.is_ok() { f64::from(value) } else { f64::NAN };
        Self {
            span,
            place: place(segment, classes),
            distance: far(segment.distance),
            surprise: far(segment.surprise),
            score: score.map(f64::from),
            trouble: trouble(&segment.counts, segment.outside.contains(&true)),
        }
    }
}

/// Names of the troubles of data, by rising importance.
const TROUBLES: [&str; 4] = ["rejected samples", "saturated samples", "stuck channel", "covariate out of range"];

/// Index of the most important trouble.
#[must_use]
pub fn trouble(counts: &Counts, outside: bool) -> Option<usize> {
    let has = [counts.rejected > 0, counts.saturated > 0, !counts.stuck.is_empty(), outside];
    has.iter().rposition(|has| *has)
}

/// Verdicts as a strip, and what was wrong with the data of segments if something was.
#[must_use]
pub fn strips(classes: &[String], judged: &[Judged]) -> Vec<Strip> {
    let spans = |name: &dyn Fn(&Judged) -> Option<usize>| -> Vec<Span> {
        judged.iter().map(|one| Span { start: one.span.0, end: one.span.1, name: name(one) }).collect()
    };
    let strip = |label: &str, names, spans| Strip { label: label.into(), names, spans, in_legend: true };
    let mut strips = vec![strip("verdict", Class::findings(classes), spans(&|one| Some(one.place)))];
    if judged.iter().any(|one| one.trouble.is_some()) {
        let names = TROUBLES.iter().zip(3..).map(|(name, k)| Class::new(k, *name)).collect();
        strips.push(strip("data", names, spans(&|one| one.trouble)));
    }
    strips
}

/// Limits that are drawn; infinite ones are not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Surprise above which a segment is novel, nats.
    pub gate: f64,
    /// Evidence at which the alarm is raised, nats.
    pub alarm: f64,
}

impl Limits {
    /// Those of a model.
    #[must_use]
    pub fn of(model: &Embedded) -> Self {
        let gate = model.model().constants().classifier.novelty.limit;
        Self { gate: f64::from(gate), alarm: f64::from(model.evidence_constants().limit) }
    }
}

/// Distance, surprise and evidence over the intervals, with their limits; without a healthy class there is none.
#[must_use]
pub fn evidence(limits: Limits, judged: &[Judged]) -> Vec<Panel> {
    let steps = |name: &str, color: usize, pick: &dyn Fn(&Judged) -> f64| {
        let points = judged.iter().flat_map(|one| [(one.span.0, pick(one)), (one.span.1, pick(one))]);
        Series::new(name, Color::of(color), points.collect::<Vec<_>>())
    };
    let ends = judged.first().zip(judged.last()).map(|(first, last)| [first.span.0, last.span.1]);
    let with = |series: Series, limit: f64| {
        let ends = ends.filter(|_| limit.is_finite());
        let line = ends.map(|ends| Series::new("limit", Color::of(6), ends.map(|at| (at, limit))).dashed());
        std::iter::once(series).chain(line).collect()
    };
    let distance = steps("distance", 0, &|one| one.distance);
    let surprise = steps("surprise", 2, &|one| one.surprise);
    let mut panels = vec![
        Panel::new("distance from healthy / sd", vec![distance]),
        Panel::new("surprise of a healthy segment / nats", with(surprise, limits.gate)),
    ];
    if judged.iter().any(|one| one.score.is_some()) {
        let score = steps("evidence", 1, &|one| one.score.unwrap_or(f64::NAN));
        panels.push(Panel::new("evidence of a defect / nats", with(score, limits.alarm)));
    }
    panels
}
