//! The page of traces that the detector judged one after another: signals, verdicts, distance and evidence over time.

use super::runs;
use crate::conclusion::replay::Conclusion;
use crate::page::table::table;
use crate::page::{counted, linked, or_reason, paragraph};
use crate::plot::{self, Event, Panel, Segment, Series};
use crate::segments::{Judged, Limits, evidence, strips};
use crate::{Class, Color, Page};
use model::core::{AlarmState, Embedded, Field, Finding, SegmentReport};
use model::trace::{Channels, Trace, tally};

/// Traces whose starts are marked, and marked with their names; more would cover each other.
const MARKED: usize = 60;
const NAMED: usize = 5;
/// Rows of the table of segments.
const ROWS: usize = 500;

/// A trace as the detector read it, its segments, and the evidence after each of them.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The trace.
    pub trace: Trace,
    /// Its segments.
    pub segments: Vec<SegmentReport>,
    /// The evidence after each segment.
    pub watched: Vec<AlarmState>,
}

/// Creates the page. `replayed` has at least one trace; `conclusion` has taken the same traces.
#[must_use]
pub fn page(
    title: &str,
    (model, channels): (&Embedded, &Channels),
    replayed: &[Replayed],
    conclusion: &Conclusion,
) -> Page {
    let clock = Clock::new(replayed);
    let judged = clock.judged(model, replayed);
    let starts = if (2..=MARKED).contains(&replayed.len()) { clock.starts(replayed) } else { vec![] };
    let events: Vec<Event> = starts.into_iter().chain(clock.alarm(model, conclusion.orders(), replayed)).collect();
    let strips = strips(&model.classes, &judged);
    let signals = signals(model, channels, replayed, &clock);
    let mut over_time = or_reason(plot::timeline("Signals and verdicts", clock.label, &signals, &strips, &events));
    if model.healthy().is_some() {
        let evidence = evidence(Limits::of(model), &judged);
        over_time += &or_reason(plot::timeline("Distance and evidence", clock.label, &evidence, &strips, &events));
    }
    over_time += &posteriors(model, &clock, replayed);
    let segments: usize = replayed.iter().map(|one| one.segments.len()).sum();
    let counts = [counted(replayed.len(), "trace"), counted(segments, "segment")].join(", ");
    let missing = tally::told(replayed.iter().map(|one| &one.trace)).map_or_else(String::new, |own| format!(" {own}."));
    let estimates = model.estimates(conclusion.orders());
    let lead = format!("{counts}; classes {}.{missing} The detector estimates {estimates}.", model.classes.join(", "));
    let page = Page::new(title).conclusion(conclusion.words_with_size()).lead(lead);
    let runs = runs::section(model, conclusion);
    let page = if runs.is_empty() { page } else { page.section("Runs", &runs) };
    page.section("Over time", &linked(&over_time)).section("Segments", &rows(model, replayed))
}

/// Places of the traces on one axis, each after the one before.
struct Clock {
    /// Start of each trace.
    starts: Vec<f64>,
    /// Length of a sample of each trace.
    steps: Vec<f64>,
    label: &'static str,
}

impl Clock {
    fn new(replayed: &[Replayed]) -> Self {
        let timed = replayed.iter().all(|one| one.trace.interval_s.is_some());
        let step = |one: &Replayed| one.trace.interval_s.filter(|_| timed).unwrap_or(1.0);
        let steps: Vec<f64> = replayed.iter().map(step).collect();
        let mut at = 0.0;
        let mut starts = Vec::new();
        for (one, step) in replayed.iter().zip(&steps) {
            starts.push(at);
            at += one.trace.y.len() as f64 * step;
        }
        Self { starts, steps, label: if timed { "time / s" } else { "sample" } }
    }

    fn starts(&self, replayed: &[Replayed]) -> Vec<Event> {
        let named = replayed.len() <= NAMED;
        let name = |one: &Replayed| if named { one.trace.id.clone() } else { String::new() };
        self.starts.iter().zip(replayed).map(|(at, one)| Event { at: *at, name: name(one) }).collect()
    }

    /// Start and end of each segment on the axis; a segment without samples has no place.
    fn spans<'a>(&self, replayed: &'a [Replayed]) -> impl Iterator<Item = ((f64, f64), &'a Replayed, usize)> {
        let of_trace = |((one, start), step): ((&'a Replayed, &f64), &f64)| {
            let at = |sample: usize| start + sample as f64 * step;
            let span = |segment: &SegmentReport| (at(segment.start), at(segment.start + segment.length));
            let each = one.segments.iter().enumerate().filter(|(_, segment)| segment.length > 0);
            each.map(|(k, segment)| (span(segment), one, k)).collect::<Vec<_>>()
        };
        replayed.iter().zip(&self.starts).zip(&self.steps).flat_map(of_trace).collect::<Vec<_>>().into_iter()
    }

    fn judged(&self, model: &Embedded, replayed: &[Replayed]) -> Vec<Judged> {
        let classes = model.classes.len();
        let score = |one: &Replayed, k: usize| one.watched.get(k).map(|watched| watched.score);
        self.spans(replayed).map(|(span, one, k)| Judged::new(span, &one.segments[k], score(one, k), classes)).collect()
    }

    /// The first alarm.
    fn alarm(&self, model: &Embedded, orders: &[String], replayed: &[Replayed]) -> Option<Event> {
        self.spans(replayed).find_map(|(span, one, k)| {
            let cause = model.cause(one.watched.get(k)?, orders)?;
            Some(Event { at: span.1, name: format!("ALARM: {cause}") })
        })
    }
}

fn signals(model: &Embedded, channels: &Channels, replayed: &[Replayed], clock: &Clock) -> Vec<Panel> {
    let panel = |(color, (label, field)): (usize, (&str, Field))| {
        let mut points = Vec::new();
        for ((one, start), step) in replayed.iter().zip(&clock.starts).zip(&clock.steps) {
            points.extend(field.of(&one.trace).iter().enumerate().map(|(k, x)| (start + k as f64 * step, *x)));
            // A gap between traces.
            points.push((f64::NAN, f64::NAN));
        }
        points.pop();
        Panel::new(label, vec![Series::new(label, Color::of(color), points)])
    };
    model.signals(channels).into_iter().enumerate().map(panel).collect()
}

fn posteriors(model: &Embedded, clock: &Clock, replayed: &[Replayed]) -> String {
    let classes = model.classes.len();
    if classes < 2 {
        return String::new();
    }
    let segment = |(span, one, k): ((f64, f64), &Replayed, usize)| {
        let own = &one.segments[k];
        let known = own.posteriors.len() == classes;
        Segment {
            start: span.0,
            end: span.1,
            truth: None,
            decided: own.verdict.as_ref().ok().and_then(|finding| finding.class()),
            posteriors: if known {
                own.posteriors.iter().map(|p| f64::from(*p)).collect()
            } else {
                vec![f64::NAN; classes]
            },
        }
    };
    let segments: Vec<Segment> = clock.spans(replayed).map(segment).collect();
    or_reason(plot::posteriors("Posterior of each segment", clock.label, &Class::all(&model.classes), &segments))
}

fn rows(model: &Embedded, replayed: &[Replayed]) -> String {
    let row = |one: &Replayed, (k, segment): (usize, &SegmentReport)| {
        let verdict = match &segment.verdict {
            Ok(finding) => Finding::name(*finding, &model.classes).to_owned(),
            Err(reason) => format!("undetermined: {reason}"),
        };
        let number = |value: f32| if segment.verdict.is_ok() { format!("{value:.2}") } else { "–".into() };
        let score = one.watched.get(k).map_or_else(|| "–".into(), |watched| format!("{:.1}", watched.score));
        let far = [number(segment.distance), number(segment.surprise)];
        [vec![one.trace.id.clone(), k.to_string(), verdict], far.to_vec(), vec![score, segment.rows.to_string()]]
            .concat()
    };
    let all = replayed.iter().flat_map(|one| one.segments.iter().enumerate().map(move |own| row(one, own)));
    let rows: Vec<Vec<String>> = all.take(ROWS + 1).collect();
    let header = ["trace", "segment", "verdict", "distance / sd", "surprise / nats", "evidence / nats", "rows"];
    let more = if rows.len() > ROWS { paragraph(&format!("The first {ROWS} segments.")) } else { String::new() };
    table(&header, &rows[..rows.len().min(ROWS)]) + &more
}
