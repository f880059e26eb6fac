//! What segments would have shown, in words.

use bearing_watch::model::Feature;

use super::Embedded;
use super::features::FRICTION;
use crate::train::directions::in_words;

/// Place of 1/Kt in the parameters of the torque balance.
const INVERSE_KT: usize = 3;

/// The smallest defect of one kind that segments would have shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// The name of the feature that rises with it, without its scale: `drag`, `order_outer`.
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
    segments: impl Iterator<Item = &'a [(Feature, f32)]>,
) -> Vec<Shown> {
    let catalogue = model.catalogue(orders);
    let mut all: Vec<Shown> = vec![];
    for (feature, size) in segments.flatten() {
        let is_amplitude = matches!(feature, Feature::OrderScore(_) | Feature::LogOrderAmplitude(_));
        let full = catalogue.name(*feature);
        let plain = full.strip_prefix("amplitude_").map(|order| format!("order_{order}"));
        let plain = plain.unwrap_or_else(|| full.trim_end_matches("_log").trim_end_matches("_score").to_string());
        match all.iter_mut().find(|own| own.name == plain) {
            Some(own) => own.size = own.size.min(*size),
            None => all.push(Shown { name: plain, size: *size, is_amplitude }),
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
        match self.name.as_str() {
            "order_outer" => "an outer-race defect".into(),
            "order_inner" => "an inner-race defect".into(),
            "order_ball" => "a rolling-element defect".into(),
            "order_cage" => "a cage defect".into(),
            name if self.is_amplitude => format!("a defect at the {}", in_words(name)),
            name if FRICTION.contains(&name) => in_words(name),
            name => format!("{name} than usual"),
        }
    }
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
    [join(&of(true, &|own| own.found(model)), "or"), join(&of(false, &Shown::kind), "and")]
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
    fn lists_read_as_sentences() {
        let names = ["drag", "cage", "outer"].map(String::from);
        assert_eq!([0, 1, 2, 3].map(|n| join(&names[..n], "or")), ["", "drag", "drag or cage", "drag, cage or outer"]);
    }
}
