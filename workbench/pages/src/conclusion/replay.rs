//! What the detector says of a drive after all its traces.

use bearing_watch::alarm::Contribution;
use model::core::coordinates::{Side, in_words};
use model::core::sight::{self, Shown};
use model::core::{AlarmState, Embedded, Finding, SegmentReport};
use model::trace::Trace;

use super::percent;
use super::risen::{self, Others};
use super::runs::Runs;
use crate::page::counted;

/// Segments of a drive, one trace after another, and the alarm.
#[derive(Clone, Debug)]
pub struct Conclusion<'a> {
    model: &'a Embedded,
    /// Names of the tracked orders.
    orders: &'a [String],
    traces: usize,
    segments: usize,
    /// Number of segments of each class.
    by_class: Vec<usize>,
    novel: usize,
    ambiguous: usize,
    /// Reasons for no verdict, with their numbers.
    reasons: Vec<(String, usize)>,
    /// Place of the first segment that departs from healthy.
    first: Option<String>,
    /// The smallest defects of the healthy segments, of each feature that rises with one.
    smallest: Vec<(u8, f32)>,
    /// Surprise of the segment that departs most until the alarm, nats, and its feature.
    most: (f32, Option<String>),
    /// Place of each segment.
    places: Vec<String>,
    /// Place of the segment since which the evidence is above zero.
    rising: Option<String>,
    runs: Runs,
    /// The largest evidence until the alarm, nats.
    score: f32,
    alarm: Option<Raised>,
}

/// The first alarm.
#[derive(Clone, Debug)]
struct Raised {
    cause: String,
    at: String,
    since: String,
    /// The direction that raised it, in a model that watches directions.
    main: Option<Contribution>,
    /// What else has risen or fallen, and what is as usual.
    others: Others,
}

impl<'a> Conclusion<'a> {
    /// Before the first trace; `orders` are the names of the tracked orders.
    #[must_use]
    pub fn new(model: &'a Embedded, orders: &'a [String]) -> Self {
        Self {
            model,
            orders,
            traces: 0,
            segments: 0,
            by_class: vec![0; model.classes.len()],
            novel: 0,
            ambiguous: 0,
            reasons: vec![],
            first: None,
            smallest: vec![],
            most: (0.0, None),
            places: vec![],
            rising: None,
            runs: Runs::default(),
            score: 0.0,
            alarm: None,
        }
    }

    /// Takes the next trace with its segments and the evidence after each of them.
    pub fn take(&mut self, trace: &Trace, segments: &[SegmentReport], watched: &[AlarmState]) {
        self.traces += 1;
        for (segment, watched) in segments.iter().zip(watched) {
            let at = place(trace, segment);
            self.count(segment, &at);
            self.runs.take(self.places.len(), watched);
            if self.alarm.is_none() {
                self.weigh(watched, &at);
            }
            self.places.push(at);
        }
    }

    fn count(&mut self, segment: &SegmentReport, at: &str) {
        self.segments += 1;
        let healthy = self.model.healthy();
        match &segment.verdict {
            Ok(Finding::Class(class)) => self.by_class[*class] += 1,
            Ok(Finding::Novel) => self.novel += 1,
            Ok(Finding::Ambiguous) => self.ambiguous += 1,
            Err(reason) => match self.reasons.iter_mut().find(|(own, _)| own == reason) {
                Some((_, count)) => *count += 1,
                None => self.reasons.push((reason.clone(), 1)),
            },
        }
        if matches!(segment.verdict, Ok(Finding::Class(class)) if Some(class) == healthy) {
            self.smallest.extend(&segment.smallest);
        }
        let departs = match &segment.verdict {
            Ok(Finding::Class(class)) => healthy.is_some_and(|healthy| healthy != *class),
            Ok(Finding::Novel) => true,
            _ => false,
        };
        if departs {
            self.first.get_or_insert_with(|| at.to_owned());
            if self.alarm.is_none() && segment.surprise > self.most.0 {
                self.most = (segment.surprise, sight::most(self.model, self.orders, segment));
            }
        }
    }

    fn weigh(&mut self, watched: &AlarmState, at: &str) {
        if watched.score > 0.0 {
            self.rising.get_or_insert_with(|| at.to_owned());
        } else {
            self.rising = None;
        }
        self.score = self.score.max(watched.score);
        if let Some(cause) = self.model.cause(watched, self.orders) {
            let onset = watched.main.and_then(|main| self.places.get(usize::try_from(main.since).ok()?));
            let since = onset.or(self.rising.as_ref()).cloned().unwrap_or_else(|| at.to_owned());
            let others = risen::others(&self.of_last_run(), &cause);
            self.alarm = Some(Raised { cause, at: at.to_owned(), since, main: watched.main, others });
        }
    }

    /// Names of the tracked orders.
    pub(crate) const fn orders(&self) -> &[String] {
        self.orders
    }

    /// The sentences.
    #[must_use]
    pub fn words(&self) -> String {
        let decided = self.by_class.iter().sum::<usize>() + self.novel;
        if self.segments == 0 {
            let (traces, verb) = (counted(self.traces, "trace"), if self.traces == 1 { "is" } else { "are" });
            return format!("No statement: {traces} {verb} shorter than a segment. Record for longer.");
        }
        let words = match (self.model.healthy(), &self.alarm) {
            (Some(_), Some(alarm)) => self.alarmed(alarm, decided),
            _ if decided == 0 => return self.silent(),
            (None, _) => self.similar(decided),
            (Some(healthy), None) if self.by_class[healthy] < decided => self.unusual(decided, healthy),
            (Some(_), None) => self.nothing(decided),
        };
        words + &self.without()
    }

    fn alarmed(&self, alarm: &Raised, decided: usize) -> String {
        let Raised { cause, at, since, main, .. } = alarm;
        if let Some(main) = main {
            return self.risen(alarm, main);
        }
        if cause.ends_with("lower than usual") {
            return format!(
                "ALARM: {cause}. It was raised in {at}; the evidence {}. This is no bearing defect: look for a load or \
                 belt that is lost, for a sensor, and for conditions warmer than those of training.",
                self.evidence(),
            );
        }
        let what = if cause == "unknown" { "a defect of no trained class" } else { cause };
        format!(
            "ALARM: {what}. It was raised in {at}; the evidence has been above zero since {since}, and {}. {}. Inspect \
             the bearing; if it is sound, compare load, speed and temperature with those of the healthy training records.",
            self.evidence(),
            self.departures(decided, self.model.healthy()),
        )
    }

    /// An alarm by a direction: what has risen, by how much, since when, and what has not.
    fn risen(&self, raised: &Raised, main: &Contribution) -> String {
        let Raised { cause, at, since, others, .. } = raised;
        let by = format!("{:.1}", main.deviations.abs());
        format!(
            "ALARM: {} The alarm was raised in {at}; the evidence {}. Inspect the bearing. If it is sound, file the \
             alarm as false: bearing-watch confirm --false.",
            risen::sentence((cause, Side::of(main.deviations)), &by, since, others),
            self.evidence(),
        )
    }

    /// The coordinates of all directions, with their deviations at the end of the last run.
    fn of_last_run(&self) -> Vec<(String, f32)> {
        let of = |one: &Contribution| (self.model.direction_coordinate(self.orders, one.direction), one.deviations);
        self.runs.contributions().iter().map(of).collect()
    }

    /// The sentences, and in a paragraph of its own the size of a defect. The command line prints the size before them.
    pub(crate) fn words_with_size(&self) -> String {
        let size = self.runs.size(&|direction| in_words(&self.model.direction_coordinate(self.orders, direction)));
        format!("{}\n\n{size}", self.words())
    }

    /// The runs that have ended.
    pub(crate) const fn runs(&self) -> &Runs {
        &self.runs
    }

    /// Since which segment a direction has risen: that of the alarm since the segment that the sentences name, the
    /// others if they are not as usual at the end of the last run.
    pub(crate) fn risen_since(&self, one: &Contribution) -> Option<usize> {
        let main = self.alarm.as_ref().and_then(|alarm| alarm.main).filter(|main| main.direction == one.direction);
        let since = main.map(|main| main.since).or((one.deviations.abs() >= risen::USUAL).then_some(one.since));
        usize::try_from(since?).ok()
    }

    /// Place of a segment by its number.
    pub(crate) fn place(&self, segment: usize) -> &str {
        self.places.get(segment).map_or("–", String::as_str)
    }

    fn unusual(&self, decided: usize, healthy: usize) -> String {
        let gate = self.model.model().constants().classifier.novelty.limit;
        let usual = (-f64::from(gate)).exp();
        let usual =
            if gate.is_finite() { format!("; of a healthy drive, {} do", percent(usual)) } else { String::new() };
        format!(
            "No alarm, but {}{usual}. First: {}. The evidence {}: record more of this drive before you decide.",
            self.departures(decided, Some(healthy)),
            self.first.as_deref().unwrap_or("–"),
            self.evidence(),
        )
    }

    fn nothing(&self, decided: usize) -> String {
        let (all, verb) = (counted(decided, "segment"), if decided == 1 { "is" } else { "are" });
        format!(
            "No defect found: {all} of {} {verb} healthy, and the evidence {}. No action is needed. {}",
            counted(self.traces, "trace"),
            self.evidence(),
            self.would_have_been_found(),
        )
    }

    /// What the best of the healthy segments would have shown.
    fn would_have_been_found(&self) -> String {
        let shown: Vec<Shown> = sight::smallest(self.model, self.orders, std::iter::once(&self.smallest[..]));
        let (best, one) = (self.segments > 1, "The segment");
        match sight::sentences(self.model, &shown) {
            [found, _] if found.is_empty() => "Defects smaller than the model can detect are not excluded.".into(),
            [found, unseen] => {
                let which = if best { "The best of them" } else { one };
                let unseen = if unseen.is_empty() { unseen } else { format!(" Not looked at: {unseen}.") };
                format!("{which} would have shown {found}; smaller defects are not excluded.{unseen}")
            }
        }
    }

    fn similar(&self, decided: usize) -> String {
        let largest = (0..self.by_class.len()).rev().max_by_key(|class| self.by_class[*class]).unwrap_or(0);
        format!(
            "This model has no healthy class: it cannot say that a drive is healthy, and raises no alarm. Most similar of \
             the trained classes: {} ({} of {}). Train with healthy records to watch a drive.",
            self.model.classes.get(largest).map_or("–", String::as_str),
            self.by_class.get(largest).unwrap_or(&0),
            counted(decided, "segment"),
        )
    }

    /// No segment has a class.
    fn silent(&self) -> String {
        let why = match (self.reason(), self.ambiguous) {
            (Some(reason), 0) => format!("most often: {reason}"),
            (Some(reason), k) => format!("{k} ambiguous between classes; of the others most often: {reason}"),
            (None, _) => "all are ambiguous between classes".into(),
        };
        format!(
            "No statement on the bearing: none of {} has a verdict ({why}). Examine the recordings with bearing-watch audit, and \
             compare their motion with that of the training.",
            counted(self.segments, "segment"),
        )
    }

    /// How many segments depart from healthy, and by which feature.
    fn departures(&self, decided: usize, healthy: Option<usize>) -> String {
        let depart = decided - healthy.map_or(0, |healthy| self.by_class[healthy]);
        let most = self.most.1.as_ref().map_or_else(String::new, |name| format!(", most by {name}"));
        let verb = if depart == 1 { "departs" } else { "depart" };
        format!("{depart} of {} {verb} from healthy{most}", counted(decided, "segment"))
    }

    fn evidence(&self) -> String {
        let limit = self.model.evidence_constants().limit;
        if limit.is_finite() {
            format!("reached {:.1} of {limit:.1} nats", self.score)
        } else {
            format!("reached {:.1} nats; the model has no limit for an alarm", self.score)
        }
    }

    /// The most frequent reason for no verdict.
    fn reason(&self) -> Option<&str> {
        self.reasons.iter().max_by_key(|(_, count)| *count).map(|(reason, _)| reason.as_str())
    }

    /// Segments without verdict beside those with one.
    fn without(&self) -> String {
        let undetermined: usize = self.reasons.iter().map(|(_, count)| count).sum();
        let mut words = String::new();
        if let Some(reason) = self.reason() {
            words += &format!(" Without verdict: {} (most often: {reason}).", counted(undetermined, "segment"));
        }
        if self.ambiguous > 0 {
            words += &format!(" Ambiguous between classes: {}.", counted(self.ambiguous, "segment"));
        }
        words
    }
}

/// The trace, and the start of a segment within it.
fn place(trace: &Trace, segment: &SegmentReport) -> String {
    match trace.interval_s {
        _ if segment.start == 0 => trace.id.clone(),
        Some(step) => format!("{} at {:.1} s", trace.id, segment.start as f64 * step),
        None => format!("{} at sample {}", trace.id, segment.start),
    }
}
