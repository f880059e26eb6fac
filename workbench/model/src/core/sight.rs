//! What segments would have shown, in words.

use bearing_watch::model::Feature;

use super::coordinates::{in_words, is_order, quantity};
use super::{Embedded, SegmentReport};

/// Place of 1/Kt in the parameters of the torque balance.
const INVERSE_KT: usize = 3;

/// The smallest defect of one kind that segments would have shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// What rises with it, whatever its scale: `drag`, or the name of an order.
    pub name: String,
    /// A part of the usual value, or the amplitude at an order, A; infinite if it would not have been found.
    pub size: f32,
    /// Whether it is an amplitude.
    pub is_amplitude: bool,
}

/// The smallest defects of all segments, kind by kind: the best of them, not their sum.
#[must_use]
pub fn smallest<'a>(
    model: &Embedded,
    orders: &[String],
    segments: impl Iterator<Item = &'a [(u8, f32)]>,
) -> Vec<Shown> {
    let names = model.coordinate_names(orders);
    let mut all: Vec<Shown> = vec![];
    for (coordinate, size) in segments.flatten() {
        let Some(full) = names.get(usize::from(*coordinate)) else { continue };
        let (is_amplitude, name) = (is_order(full), quantity(full).to_string());
        match all.iter_mut().find(|own| own.name == name) {
            Some(own) => own.size = own.size.min(*size),
            None => all.push(Shown { name, size: *size, is_amplitude }),
        }
    }
    all
}

impl Shown {
    /// The defect in words, with its size, if it would have been found.
    fn found(&self, model: &Embedded) -> String {
        if !self.is_amplitude {
            let more = f64::from(self.size) * 100.0;
            let more = if more < 1000.0 { format!("{more:.0} %") } else { format!("{:.0} times", more / 100.0) };
            return format!("{more} more {}", self.kind());
        }
        let inverse_kt = model.shaft().map_or(0.0, |own| own.balance.nominal[INVERSE_KT]);
        let current = significant(f64::from(self.size));
        if inverse_kt > 0.0 {
            let torque = significant(f64::from(self.size / inverse_kt));
            return format!("{} above {torque} N·m ({current} A)", self.kind());
        }
        format!("{} above {current} A", self.kind())
    }

    /// The defect in words.
    fn kind(&self) -> String {
        match (self.is_amplitude, self.name.as_str()) {
            (true, "outer") => "an outer-race defect".into(),
            (true, "inner") => "an inner-race defect".into(),
            (true, "ball") => "a rolling-element defect".into(),
            (true, "cage") => "a cage defect".into(),
            (true, name) => format!("a defect at the order {name}"),
            (false, name) => in_words(name),
        }
    }
}

/// The feature by which a segment departs most from healthy, and where it falls what that may be.
#[must_use]
pub fn most(model: &Embedded, orders: &[String], segment: &SegmentReport) -> Option<String> {
    let most = segment.most?;
    let name = model.coordinate_name(orders, most.coordinate);
    let lower = format!("{}, which is lower than usual: load or belt lost, a sensor, or warmer than trained", name);
    Some(if most.falls { lower } else { name })
}

/// Two digits that count.
fn significant(x: f64) -> String {
    let digits = (1 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{x:.digits$}")
}

/// What would have been found, and what was not looked at; empty where there is none.
#[must_use]
pub fn sentences(model: &Embedded, shown: &[Shown]) -> [String; 2] {
    let of = |found: bool, words: &dyn Fn(&Shown) -> String| -> Vec<String> {
        shown.iter().filter(|own| own.size.is_finite() == found).map(words).collect()
    };
    let mut unseen = of(false, &Shown::kind);
    if reads_orders_alone(&model.model().constants().classifier.features) {
        unseen.push("friction, which no feature reads".into());
    }
    [join(&of(true, &|own| own.found(model)), "or"), join(&unseen, "and")]
}

/// Whether features tell damage of the bearing's parts, and none a bearing that runs dry. A mean is a covariate.
fn reads_orders_alone(features: &[Feature]) -> bool {
    let is_order = |own: &Feature| matches!(own, Feature::OrderScore(_) | Feature::LogOrderAmplitude(_));
    features.iter().any(is_order) && features.iter().all(|own| is_order(own) || matches!(own, Feature::ChannelMean(_)))
}

fn join(parts: &[String], last: &str) -> String {
    match parts {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_count() {
        assert_eq!([0.010_62, 0.22, 12.4, 3.0, 0.000_045].map(significant), ["0.011", "0.22", "12", "3.0", "0.000045"]);
    }

    #[test]
    fn orders_alone_see_no_friction() {
        let (order, mean) = (Feature::OrderScore(0), Feature::ChannelMean(2));
        let drag = Feature::Friction(bearing_watch::FrictionTerm::Drag);
        assert_eq!(
            [&[order, mean][..], &[order, drag], &[drag], &[]].map(reads_orders_alone),
            [true, false, false, false]
        );
    }

    #[test]
    fn lists_read_as_sentences() {
        let names = ["drag", "cage", "outer"].map(String::from);
        assert_eq!([0, 1, 2, 3].map(|n| join(&names[..n], "or")), ["", "drag", "drag or cage", "drag, cage or outer"]);
    }
}
