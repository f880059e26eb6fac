//! Sums of parts by drive, run and class, which merge in any order.
//!
//! A drive is closed where it is known to be complete: its runs and itself go into the levels of their class and are
//! forgotten, so that memory does not grow with the rows. Rows that lack a feature count for their class by the pattern
//! of what they have, and not for the spread of drives and runs.

use std::collections::BTreeMap;

use super::double::Double;
use super::{Closed, Group, Level, Plan};
use model::Error;

/// Most patterns of missing features in a class.
const PATTERNS: usize = 256;
/// Most features: bits of a pattern.
pub const MOST_FEATURES: usize = 64;

/// Rows of one class.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassSums {
    /// Rows by the features that they have, a bit mask, of closed drives.
    patterns: BTreeMap<u64, Pattern>,
    /// Rows without any of the features.
    pub empty: u64,
    /// Closed runs, of rows with all features.
    pub runs: Level,
    /// Closed drives.
    pub units: Level,
}

/// Rows that have the same features.
#[derive(Clone, Debug, PartialEq)]
struct Pattern {
    rows: Group,
    /// Sums of what the variances of errors exceed the usual ones.
    excess: Vec<Double>,
}

/// Sums of a pattern: the mask, the rows, and the mean excess of the variances of their errors.
#[derive(Clone, Debug)]
pub struct PatternSums {
    /// Bit k: whether the rows have feature k.
    pub mask: u64,
    /// Mean and scatter of the features that they have.
    pub rows: Closed,
    /// Mean excess of each of these features' variances.
    pub excess: Vec<f64>,
}

/// Sums of a drive, by class and run, of rows with all features. In the order of class and run if they are closed.
pub(super) type Unit = Vec<((String, String), Group)>;

/// Sums of parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    /// The plan of the parts.
    pub plan: Plan,
    /// Names of the features that are summed.
    pub features: Vec<String>,
    /// Number of rows.
    pub rows: u64,
    classes: BTreeMap<String, ClassSums>,
}

impl Pattern {
    fn merge(&mut self, other: &Self) {
        self.rows.merge(&other.rows);
        self.excess.iter_mut().zip(&other.excess).for_each(|(sum, more)| sum.merge(*more));
    }
}

impl ClassSums {
    fn new(features: usize) -> Self {
        Self { patterns: BTreeMap::new(), empty: 0, runs: Level::new(features), units: Level::new(features) }
    }

    fn pattern(&mut self, mask: u64) -> Result<&mut Pattern, Error> {
        if self.patterns.len() >= PATTERNS && !self.patterns.contains_key(&mask) {
            let problem = "rows lack features in more than 256 different patterns; choose features of fewer parts of \
                           the detector";
            return Err(Error::Training(problem.into()));
        }
        let features = mask.count_ones() as usize;
        let new = || Pattern { rows: Group::new(features), excess: vec![Double::default(); features] };
        Ok(self.patterns.entry(mask).or_insert_with(new))
    }

    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.empty += other.empty;
        self.runs.merge(&other.runs);
        self.units.merge(&other.units);
        other.patterns.iter().try_for_each(|(mask, more)| {
            self.pattern(*mask)?.merge(more);
            Ok(())
        })
    }

    /// Number of rows with any of the features.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.patterns.values().map(|own| own.rows.count).sum()
    }

    /// Returns the rows of these features by patterns, in the order of their masks; a pattern without any is left out.
    #[must_use]
    pub fn patterns(&self, places: &[usize]) -> Vec<PatternSums> {
        let mut all: BTreeMap<u64, Pattern> = BTreeMap::new();
        for (mask, own) in &self.patterns {
            let rank = |place: usize| (mask & ((1 << place) - 1)).count_ones() as usize;
            let there: Vec<usize> = (0..places.len()).filter(|k| (mask >> places[*k]) & 1 == 1).collect();
            let selected = there.iter().fold(0, |mask, k| mask | 1 << k);
            let ranks: Vec<usize> = there.iter().map(|k| rank(places[*k])).collect();
            let excess = ranks.iter().map(|rank| own.excess[*rank]).collect();
            let chosen = Pattern { rows: own.rows.select(&ranks), excess };
            match all.get_mut(&selected) {
                Some(found) => found.merge(&chosen),
                None => drop(all.insert(selected, chosen)),
            }
        }
        all.remove(&0);
        let each = |(mask, own): (&u64, &Pattern)| PatternSums {
            mask: *mask,
            rows: own.rows.close(),
            excess: own.excess.iter().map(|sum| sum.value() / own.rows.count as f64).collect(),
        };
        all.iter().map(each).collect()
    }
}

impl Sums {
    /// No rows yet of these features.
    ///
    /// # Errors
    /// More than [`MOST_FEATURES`].
    pub fn new(plan: &Plan, features: &[String]) -> Result<Self, Error> {
        if features.len() > MOST_FEATURES {
            return Err(Error::Usage(format!("at most {MOST_FEATURES} features can be summed; choose by --features")));
        }
        Ok(Self { plan: plan.clone(), features: features.to_vec(), rows: 0, classes: BTreeMap::new() })
    }

    fn class(&mut self, name: &str) -> &mut ClassSums {
        if !self.classes.contains_key(name) {
            self.classes.insert(name.to_string(), ClassSums::new(self.features.len()));
        }
        self.classes.get_mut(name).unwrap_or_else(|| unreachable!("just inserted"))
    }

    /// Adds a row that lacks a feature: values (NaN if missing) and excess variances of their errors.
    pub(super) fn add_partial(&mut self, class: &str, values: &[f64], excess: &[f64]) -> Result<(), Error> {
        self.rows += 1;
        let there: Vec<usize> = (0..values.len()).filter(|k| !values[*k].is_nan()).collect();
        let class = self.class(class);
        if there.is_empty() {
            class.empty += 1;
            return Ok(());
        }
        let pattern = class.pattern(there.iter().fold(0, |mask, k| mask | 1 << k))?;
        pattern.rows.add(&there.iter().map(|k| values[*k]).collect::<Vec<_>>());
        pattern.excess.iter_mut().zip(&there).for_each(|(sum, k)| sum.add(excess[*k]));
        Ok(())
    }

    /// Adds the excess variances of a row with all features.
    pub(super) fn add_excess(&mut self, class: &str, excess: &[f64]) -> Result<(), Error> {
        let all = self.all();
        let pattern = self.class(class).pattern(all)?;
        pattern.excess.iter_mut().zip(excess).for_each(|(sum, x)| sum.add(*x));
        Ok(())
    }

    /// The mask of all features.
    fn all(&self) -> u64 {
        u64::MAX >> (MOST_FEATURES - self.features.len())
    }

    /// Closes a complete drive.
    pub(super) fn close(&mut self, unit: &[((String, String), Group)]) -> Result<(), Error> {
        let all = self.all();
        // Of a run whose segments all lack a feature there is no row.
        let mut runs = unit.iter().filter(|(_, own)| own.count > 0).peekable();
        while let Some(((class, _), first)) = runs.next() {
            let mut closed = first.close();
            let own = self.class(class);
            own.runs.add(&closed);
            let mut whole = None;
            while let Some((_, more)) = runs.next_if(|((other, _), _)| other == class) {
                own.runs.add(&more.close());
                whole.get_or_insert_with(|| first.clone()).merge(more);
            }
            let whole = whole.as_ref().unwrap_or(first);
            if whole.count > closed.count {
                closed = whole.close();
            }
            own.units.add(&closed);
            own.pattern(all)?.rows.merge(whole);
        }
        Ok(())
    }

    /// Adds the sums of other rows of the same plan and features.
    pub(super) fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.rows += other.rows;
        other.classes.iter().try_for_each(|(name, class)| self.class(name).merge(class))
    }

    /// Names of the classes that have rows.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.classes.keys().map(String::as_str)
    }

    /// The sums of a class.
    #[must_use]
    pub fn of_class(&self, name: &str) -> Option<&ClassSums> {
        self.classes.get(name)
    }
}

/// Adds the runs of a drive to those of the same drive.
pub(super) fn merge_unit(own: &mut Unit, more: Unit) {
    for (run, group) in more {
        match own.iter_mut().find(|(other, _)| *other == run) {
            Some((_, own)) => own.merge(&group),
            None => own.push((run, group)),
        }
    }
    own.sort_by(|(one, _), (two, _)| one.cmp(two));
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Sums of two features; of the plan only the text counts here.
    fn sums() -> Sums {
        let plan = json!({
            "version": 1, "features": ["a", "b"], "usual": [0.0, 0.0], "classes": [], "unit": null, "group": null,
            "y": "i", "u1": "w", "u2": "t", "shaft": null, "further": [], "time": null, "rate_hz": null,
            "front_end": null, "block_mean": 1, "decimate": 1, "recorded_interval_s": 0.0, "interval_s": 0.0,
            "segment_samples": 1, "segment_given": false, "order": [1, 1, 1, 1, 1], "offset": false, "park": null,
            "memory": null, "nominal": 0, "orders": [], "velocity_from_angle": false, "load": false, "core": "",
        });
        Sums::new(&serde_json::from_value(plan).expect("all keys"), &["a", "b"].map(String::from)).expect("few")
    }

    /// A run of healthy rows with both features.
    fn run(name: &str, values: &[f64]) -> ((String, String), Group) {
        let mut rows = Group::new(2);
        values.iter().for_each(|value| rows.add(&[*value, -value]));
        (("healthy".to_string(), name.to_string()), rows)
    }

    #[test]
    fn rows_are_counted_by_the_features_that_they_have() {
        let (mut one, mut other) = (sums(), sums());
        one.add_partial("healthy", &[f64::NAN, f64::NAN], &[0.0, 0.0]).expect("few patterns");
        one.add_partial("healthy", &[3.0, f64::NAN], &[0.5, 0.0]).expect("few patterns");
        other.add_partial("healthy", &[5.0, f64::NAN], &[1.5, 0.0]).expect("few patterns");
        one.merge(&other).expect("few patterns");
        assert_eq!(one.rows, 3);
        let class = one.of_class("healthy").expect("rows");
        assert_eq!((class.empty, class.count()), (1, 2));
        let [pattern] = &class.patterns(&[0, 1])[..] else { panic!("one pattern") };
        assert_eq!((pattern.mask, pattern.rows.mean.as_slice(), &pattern.excess[..]), (1, &[4.0][..], &[1.0][..]));
    }

    #[test]
    fn a_drive_has_the_rows_of_all_its_runs() {
        let mut sums = sums();
        sums.close(&[run("1", &[1.0, 3.0]), run("2", &[8.0]), run("3", &[])]).expect("one drive");
        let class = sums.of_class("healthy").expect("rows");
        assert_eq!((class.runs.count, class.runs.rows, class.runs.longest, class.runs.single), (2, 3, 2, 1));
        assert_eq!((class.units.count, class.units.rows, class.units.longest), (1, 3, 3));
        // Means: of runs 2 and 8, of the drive 12/3.
        assert_eq!((class.runs.means().mean[0], class.units.means().mean[0]), (5.0, 4.0));
    }
}
