//! Sums of parts by drive, run and class, which merge without rounding in any order.
//!
//! ```text
//! drive complete:   its runs and itself are closed into the levels of their class, then forgotten
//! drive open:       sums of each of its runs, as long as further rows may come
//! ```
//!
//! A drive is closed where it is known to be complete, so that memory does not grow with the rows. The sums remember 64
//! bits of each closed drive, and refuse to merge with others that have the drive too. Rows that lack a feature count
//! for their class by the pattern of what they have, and not for the spread of drives and runs.

use std::collections::BTreeMap;

use crc::{CRC_64_XZ, Crc};
use serde::{Deserialize, Serialize};

use super::exact::Exact;
use super::group::MOST_ROWS;
use super::{Closed, Group, Level, Plan};
use model::Error;

/// First bytes of a file of sums; the digit is the version of the format.
const MAGIC: &[u8] = b"bearing-watch sums 2\n";
/// Most patterns of missing features in a class.
const PATTERNS: usize = 256;
/// Most features: bits of a pattern.
pub const MOST_FEATURES: usize = 64;
const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// Rows of one class.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Pattern {
    rows: Group,
    /// Sums of what the variances of errors exceed the usual ones.
    excess: Vec<Exact>,
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

/// Sums of an open drive, by class and run, of rows with all features. In the order of class and run if they are
/// closed.
pub(super) type Unit = Vec<((String, String), Group)>;

/// Sums of parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    /// The plan of the parts.
    #[serde(with = "as_text")]
    pub plan: Plan,
    /// Names of the features that are summed.
    pub features: Vec<String>,
    /// The features that were chosen, as they were given, and may need further ones.
    pub chosen: Vec<String>,
    /// Conditions on the rows, as they were given.
    pub conditions: Vec<String>,
    /// Number of rows.
    pub rows: u64,
    classes: BTreeMap<String, ClassSums>,
    open: BTreeMap<String, Unit>,
    /// 64 bits of the name of each closed drive, in ascending order.
    closed: Vec<u64>,
}

mod as_text {
    use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

    use super::super::Plan;

    pub(super) fn serialize<S: Serializer>(plan: &Plan, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&plan.to_json())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Plan, D::Error> {
        Plan::parse(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl ClassSums {
    fn new(features: usize) -> Self {
        Self { patterns: BTreeMap::new(), empty: 0, runs: Level::new(features), units: Level::new(features) }
    }

    /// Whether the lengths are those of the features of this mask.
    fn fits(&self, all: u64) -> bool {
        let of = |mask: u64| mask.count_ones() as usize;
        let mut patterns = self.patterns.iter();
        self.patterns.len() <= PATTERNS
            && patterns.all(|(mask, own)| mask & !all == 0 && own.rows.fits(of(*mask)) && own.excess.len() == of(*mask))
            && self.empty <= MOST_ROWS
            && [&self.runs, &self.units].iter().all(|level| level.fits(of(all)))
    }

    fn pattern(&mut self, mask: u64) -> Result<&mut Pattern, Error> {
        if self.patterns.len() >= PATTERNS && !self.patterns.contains_key(&mask) {
            let problem = "rows lack features in more than 256 different patterns; choose features of fewer parts of \
                           the detector";
            return Err(Error::Training(problem.into()));
        }
        let features = mask.count_ones() as usize;
        let new = || Pattern { rows: Group::new(features), excess: vec![Exact::default(); features] };
        Ok(self.patterns.entry(mask).or_insert_with(new))
    }

    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.empty += other.empty;
        self.runs.merge(&other.runs);
        self.units.merge(&other.units);
        other.patterns.iter().try_for_each(|(mask, more)| {
            let own = self.pattern(*mask)?;
            own.rows.merge(&more.rows);
            own.excess.iter_mut().zip(&more.excess).for_each(|(sum, more)| sum.merge(more));
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
            let rows = own.rows.select(&ranks);
            let excess: Vec<Exact> = ranks.iter().map(|rank| own.excess[*rank].clone()).collect();
            match all.get_mut(&selected) {
                Some(found) => {
                    found.rows.merge(&rows);
                    found.excess.iter_mut().zip(&excess).for_each(|(sum, more)| sum.merge(more));
                }
                None => drop(all.insert(selected, Pattern { rows, excess })),
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
    /// No rows yet of these features, and the choice that needs them.
    ///
    /// # Errors
    /// More than [`MOST_FEATURES`].
    pub fn new(plan: &Plan, [features, chosen]: [&[String]; 2], conditions: &[String]) -> Result<Self, Error> {
        if features.len() > MOST_FEATURES {
            return Err(Error::Usage(format!("at most {MOST_FEATURES} features can be summed; choose by --features")));
        }
        Ok(Self {
            plan: plan.clone(),
            features: features.to_vec(),
            chosen: chosen.to_vec(),
            conditions: conditions.to_vec(),
            rows: 0,
            classes: BTreeMap::new(),
            open: BTreeMap::new(),
            closed: vec![],
        })
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
    pub(super) fn close(
        &mut self,
        name: &str,
        unit: &[((String, String), Group)],
        remember: bool,
    ) -> Result<(), Error> {
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
        if remember {
            let key = key_of(name);
            match self.closed.binary_search(&key) {
                Ok(_) => return Err(twice(name)),
                Err(place) => self.closed.insert(place, key),
            }
        }
        Ok(())
    }

    /// Keeps the sums of a drive of which further rows may come.
    pub(super) fn keep(&mut self, name: String, unit: Unit) {
        merge_unit(self.open.entry(name).or_default(), unit);
    }

    /// Adds the sums of other rows.
    ///
    /// # Errors
    /// Sums of other plans, features or conditions, or of the same drives.
    pub fn merge(&mut self, other: Self) -> Result<(), Error> {
        if let Some(difference) = self.plan.difference(&other.plan) {
            return Err(Error::Usage(format!("different plans: {difference}; compute the features with one --plan")));
        }
        let differ = |what: &str, one: &[String], two: &[String]| {
            let (one, two) = (one.join(", "), two.join(", "));
            (one != two)
                .then(|| Error::Usage(format!("sums of different {what}: {one} and {two}; sum the parts alike")))
        };
        let problem = differ("features", &self.features, &other.features);
        let problem = problem.or_else(|| differ("chosen features", &self.chosen, &other.chosen));
        if let Some(problem) = problem.or_else(|| differ("conditions", &self.conditions, &other.conditions)) {
            return Err(problem);
        }
        let is_closed = |closed: &[u64], name: &String| closed.binary_search(&key_of(name)).is_ok();
        let doubled = self.open.keys().find(|name| is_closed(&other.closed, name));
        if let Some(name) = doubled.or_else(|| other.open.keys().find(|name| is_closed(&self.closed, name))) {
            return Err(twice(name));
        }
        let before = self.closed.len();
        self.closed.extend(other.closed);
        // Both are sorted: the sort merges them.
        self.closed.sort();
        if before > 0 && self.closed.windows(2).any(|two| two[0] == two[1]) {
            return Err(twice("of one name"));
        }
        self.rows += other.rows;
        for (name, class) in &other.classes {
            self.class(name).merge(class)?;
        }
        other.open.into_iter().for_each(|(name, unit)| self.keep(name, unit));
        Ok(())
    }

    /// Closes all drives: no further rows come.
    ///
    /// # Errors
    /// As for rows that are added.
    pub fn finish(mut self) -> Result<Self, Error> {
        for (name, unit) in std::mem::take(&mut self.open) {
            self.close(&name, &unit, false)?;
        }
        Ok(self)
    }

    /// Names of the classes that have rows.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.classes.keys().map(String::as_str)
    }

    /// The sums of a class of finished sums.
    #[must_use]
    pub fn of_class(&self, name: &str) -> Option<&ClassSums> {
        self.classes.get(name)
    }

    /// Number of drives that are open, and of those that are closed and remembered.
    #[must_use]
    pub fn units(&self) -> [usize; 2] {
        [self.open.len(), self.closed.len()]
    }

    /// Returns the sums as bytes, with a checksum.
    ///
    /// # Errors
    /// Sums that cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let body = postcard::to_stdvec(self).map_err(|error| Error::Training(format!("sums: {error}")))?;
        let checksum = CRC.checksum(&body).to_le_bytes();
        Ok([MAGIC, &checksum, &body].concat())
    }

    /// Returns whether bytes begin as sums do.
    #[must_use]
    pub fn are_sums(bytes: &[u8]) -> bool {
        bytes.starts_with(&MAGIC[..MAGIC.len() - 2])
    }

    /// Reads sums.
    ///
    /// # Errors
    /// What is wrong with the bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return Err("no sums of this version; write them again with `bearing-watch features-sum`".into());
        };
        let Some((checksum, body)) = rest.split_first_chunk::<8>() else { return Err("truncated".into()) };
        if CRC.checksum(body) != u64::from_le_bytes(*checksum) {
            return Err("the sums are damaged: their checksum differs; write them again".into());
        }
        let sums: Self = postcard::from_bytes(body).map_err(|error| format!("not readable as sums: {error}"))?;
        if sums.fits() { Ok(sums) } else { Err("not readable as sums: their lengths differ; write them again".into()) }
    }

    /// Whether every part has the lengths of the features, and no more rows than can be added.
    fn fits(&self) -> bool {
        let features = self.features.len();
        let mut open = self.open.values().flatten();
        (1..=MOST_FEATURES).contains(&features)
            && self.rows <= MOST_ROWS
            && open.all(|(_, group)| group.fits(features))
            && self.classes.values().all(|class| class.fits(self.all()))
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

fn key_of(name: &str) -> u64 {
    CRC.checksum(name.as_bytes())
}

fn twice(name: &str) -> Error {
    Error::Usage(format!(
        "drive {name} is in several sums, of which one took it for complete: sum the parts with this drive in one \
         command, or with --keep-units"
    ))
}

#[cfg(test)]
mod tests;
