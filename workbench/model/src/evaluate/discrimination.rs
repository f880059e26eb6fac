//! Verdicts → how well the scores that decide distinguish each defect from healthy: areas under ROC curves.
//!
//! ```text
//! log-odds    Σ over segments of ln p(x | class) − ln p(x | healthy): the posterior's but for the priors; of classes
//!             that were trained
//! surprise    of all segments by Fisher's method, which the gate compares; of classes that were not trained
//! direction   mean of its values, weighted as in a run of the alarm; of all classes
//! ```

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::{Areas, Judged, Rate, Scored};
use crate::core::{Embedded, SegmentReport, combined_surprise};

/// Areas that differ by more are worth a word: one pair in twenty is ordered by the units.
const FAR: f64 = 0.05;
/// Units of one class that a line names.
const NAMED: usize = 5;

/// What decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Score {
    LogOdds { healthy: usize },
    Surprise,
    Direction(u8),
}

/// How well a score distinguishes a class from healthy.
#[derive(Clone, Debug, PartialEq)]
pub struct Discrimination {
    /// The class.
    pub class: String,
    /// Name of the score.
    pub score: String,
    /// The areas.
    pub areas: Areas,
    /// Whether units are known; otherwise traces are independent.
    pub has_units: bool,
    /// Names of the units with this class only, or with healthy traces only.
    pub of_one_class: Vec<String>,
    /// Number of traces, or of segments, without a verdict.
    pub without: usize,
}

impl Discrimination {
    /// Of each class against healthy; none without a healthy class. `orders` are the names of the orders.
    #[must_use]
    pub fn all(judged: &Judged<'_>, model: &Embedded, orders: &[String]) -> Vec<Self> {
        let Some(healthy) = judged.healthy else { return vec![] };
        let seen: BTreeSet<usize> = judged.verdicts.iter().map(|verdict| verdict.class).collect();
        let of_class = |&class: &usize| {
            let trained = class < judged.trained;
            let first = if trained { Score::LogOdds { healthy } } else { Score::Surprise };
            let scores = std::iter::once(first).chain((0..model.directions()).map(Score::Direction));
            scores.map(|score| Self::of(judged, model, (class, healthy), (score, score.name(model, orders)))).collect()
        };
        seen.iter().filter(|class| **class != healthy).flat_map(|class| -> Vec<Self> { of_class(class) }).collect()
    }

    fn of(
        judged: &Judged<'_>,
        model: &Embedded,
        (class, healthy): (usize, usize),
        (score, name): (Score, String),
    ) -> Self {
        let (places, _) = judged.places();
        let (mut scored, mut without) = (vec![], 0);
        for (verdict, unit) in judged.verdicts.iter().zip(&places) {
            let defect = verdict.class == class;
            if !defect && verdict.class != healthy {
                continue;
            }
            let parts =
                if judged.per_segment { verdict.segments.chunks(1) } else { verdict.segments.chunks(usize::MAX) };
            let values: Vec<Option<f64>> = parts.map(|segments| score.of(model, segments, class)).collect();
            without += values.iter().filter(|value| value.is_none()).count() + usize::from(values.is_empty());
            scored.extend(values.into_iter().flatten().map(|score| Scored { unit: *unit, defect, score }));
        }
        let mut areas = Areas::of(&scored);
        let has_units = judged.groups.is_some();
        if !has_units {
            areas = Areas { pooled: areas.pooled, ..Areas::default() };
        }
        let named = |place: &usize| {
            let first = places.iter().position(|unit| unit == place);
            first.zip(judged.groups).map(|(first, groups)| groups[first].clone())
        };
        Self {
            class: judged.classes[class].clone(),
            score: name,
            has_units,
            of_one_class: areas.of_one_class.iter().filter_map(named).collect(),
            areas,
            without,
        }
    }

    /// What the difference of the areas means, if it is large.
    #[must_use]
    pub fn difference(&self) -> Option<&'static str> {
        let difference = self.areas.within?.value - self.areas.pooled?.value;
        if difference > FAR {
            return Some("units differ in level: relative to its unit the score distinguishes more");
        }
        (difference < -FAR).then_some("a part of the latter is of the units, not of the defect")
    }

    /// JSON object with the keys `class`, `score`, `within`, `pooled`, `units`, `units_of_one_class`, `without_score`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Self { class, score, areas, of_one_class, without, .. } = self;
        json!({
            "class": class,
            "score": score,
            "within": areas.within.map(Rate::to_json),
            "pooled": areas.pooled.map(Rate::to_json),
            "units": areas.units,
            "units_of_one_class": of_one_class,
            "without_score": without,
        })
    }
}

impl Score {
    fn name(self, model: &Embedded, orders: &[String]) -> String {
        match self {
            Self::LogOdds { .. } => "log-odds".into(),
            Self::Surprise => "surprise".into(),
            Self::Direction(place) => model.direction_name(orders, place),
        }
    }

    /// Of these segments; `None` without a verdict.
    fn of(self, model: &Embedded, segments: &[SegmentReport], class: usize) -> Option<f64> {
        let mut determined = segments.iter().filter(|segment| segment.verdict.is_ok()).peekable();
        determined.peek()?;
        let score = match self {
            Self::LogOdds { healthy } => {
                let log = |segment: &SegmentReport, class: usize| segment.log_likelihoods.get(class).copied();
                let odds = |segment| Some(f64::from(log(segment, class)?) - f64::from(log(segment, healthy)?));
                determined.map(odds).sum::<Option<f64>>()?
            }
            Self::Surprise => f64::from(combined_surprise(determined.map(|segment| segment.surprise))),
            Self::Direction(place) => model.mean_in_direction(segments, place)?,
        };
        (!score.is_nan()).then_some(score)
    }
}

/// Area with its interval, as parts of one.
#[must_use]
pub fn area_words(rate: Rate) -> String {
    let Rate { value, low, high } = rate;
    format!("{value:.3} [{low:.3}, {high:.3}]")
}

impl std::fmt::Display for Discrimination {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { class, score, areas, of_one_class, without, .. } = self;
        write!(f, "area under the ROC curve, {class} against healthy by {score}: ")?;
        let pooled = areas.pooled.map_or_else(|| "none without traces of both".into(), area_words);
        match areas.within {
            Some(within) => write!(f, "{} within {} units, {pooled} of all together", area_words(within), areas.units)?,
            None if self.has_units => write!(f, "{pooled} of all together, no unit has both")?,
            None => f.write_str(&pooled)?,
        }
        if let Some(words) = self.difference() {
            write!(f, ": {words}")?;
        }
        if let Some(first) = of_one_class.get(..of_one_class.len().min(NAMED)).filter(|first| !first.is_empty()) {
            let more = if of_one_class.len() > NAMED { ", …" } else { "" };
            write!(f, "; {} of one class: {}{more}", of_one_class.len(), first.join(", "))?;
        }
        if *without > 0 { write!(f, "; {without} without a verdict") } else { Ok(()) }
    }
}
