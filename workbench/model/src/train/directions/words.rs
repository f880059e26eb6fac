//! Directions in words.

use super::{Direction, Directions, FEWEST, MOST};
use crate::core::coordinates::{in_words, name};

impl Direction {
    /// What it watches, by the names of the coordinates.
    #[must_use]
    pub fn words(&self, names: &[String]) -> String {
        let of = |k: usize| in_words(&name(k, names.get(k).map(String::as_str)));
        let background: Vec<String> = self.background.iter().map(|(k, _)| of(*k)).collect();
        match background.as_slice() {
            [] => of(self.coordinate),
            [others @ .., last] if !others.is_empty() => {
                format!("{} given {} and {last}", of(self.coordinate), others.join(", "))
            }
            [only, ..] => format!("{} given {only}", of(self.coordinate)),
        }
    }
}

impl Directions {
    /// What is watched, and on which runs it rests.
    #[must_use]
    pub fn words(&self, names: &[String]) -> String {
        let Self { list, drives, runs, usual, .. } = self;
        let words: Vec<String> = list.iter().map(|direction| direction.words(names)).collect();
        let directions = if list.len() == 1 { "direction" } else { "directions" };
        let of = match drives {
            1 => format!("{runs} runs of one drive × {usual} records; of other drives it knows nothing"),
            _ if runs % drives == 0 => format!("{drives} drives × {} runs × {usual} records", runs / drives),
            _ => format!("{runs} runs of {drives} drives × {usual} records"),
        };
        format!("{} {directions} ({}), {of}{}", list.len(), words.join("; "), self.lasting())
    }

    /// In which directions too few runs of a drive follow each other to know how long offsets last.
    pub(crate) fn unordered(&self, names: &[String]) -> Option<String> {
        let unknown = self.list.iter().filter(|direction| direction.levels.correlation.is_none());
        let words: Vec<String> = unknown.map(|direction| direction.words(names)).collect();
        (!words.is_empty()).then(|| {
            format!(
                "the hours between false alarms hold for offsets that do not last from run to run (correlation 0), of \
                 {}: too few runs of a drive follow each other to know; where offsets last, as of weather, alarms are \
                 more frequent; give at least 4 successive runs of each drive, in the order of time",
                words.join("; ")
            )
        })
    }

    /// Up to which correlation of successive runs the hours between false alarms hold.
    fn lasting(&self) -> String {
        let known = || self.list.iter().filter_map(|direction| direction.levels.correlation);
        match [f64::min, f64::max].map(|of| known().reduce(of)) {
            [Some(least), Some(most)] if most - least < 0.01 => {
                format!("; offsets last with a correlation up to {most:.2}")
            }
            [Some(least), Some(most)] => format!("; offsets last with correlations up to {least:.2} … {most:.2}"),
            _ => String::new(),
        }
    }

    /// Which features the alarm does not watch although a defect raises them.
    #[must_use]
    pub fn unwatched(&self, names: &[String]) -> Option<String> {
        let features: Vec<&str> = self.left_out.iter().map(|&k| names[k].as_str()).collect();
        (!features.is_empty()).then(|| {
            format!(
                "the alarm does not watch {}: it has at most {MOST} directions, and {FEWEST} degrees of freedom of \
                 each",
                features.join(", ")
            )
        })
    }
}
