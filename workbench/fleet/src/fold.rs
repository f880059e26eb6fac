//! Parts → sums, in parallel and in constant memory.
//!
//! ```text
//! units of the row groups (from the files' statistics) ─► slices of about as many rows, each of whole units
//! slice: rows of its units, of all parts ─► sums, with every unit closed at its end
//! ```
//!
//! A slice reads the row groups that may have its units, so that a unit may be in several parts, such as one part a
//! month. Memory is that of the slices at work. A part whose units do not ascend is one slice with all its units open;
//! too many of them are refused.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::sums::{Unit, merge_unit};
use super::{Batch, Group, Part, Sums, Wanted};
use model::Error;

/// Rows of a slice, at least, as far as units allow.
const SLICE: u64 = 250_000;
/// Most units of parts whose units do not ascend.
const MOST_OPEN: usize = 50_000;

/// What is done with the rows of a slice.
pub(super) trait Visitor: Sized + Send {
    /// Takes rows of a batch that are of one class, unit and run.
    fn rows(&mut self, batch: &Batch, rows: Range<usize>) -> Result<(), Error>;
    /// The units of all rows so far are complete.
    fn complete(&mut self) -> Result<(), Error>;
    /// Number of units that are not complete.
    fn open(&self) -> usize;
}

/// Rows with `from ≤ unit < to`.
#[derive(Clone, Debug, Default)]
struct Slice {
    from: Option<String>,
    to: Option<String>,
    /// Part and row group, in this order.
    groups: Vec<(usize, usize)>,
}

impl Slice {
    fn has(&self, unit: &str) -> bool {
        self.from.as_deref().is_none_or(|from| from <= unit) && self.to.as_deref().is_none_or(|to| unit < to)
    }
}

/// Cuts parts into slices; the flag tells whether units of each part ascend.
fn slices(parts: &[Part]) -> (Vec<Slice>, bool) {
    let all: Vec<(usize, usize)> =
        parts.iter().enumerate().flat_map(|(k, part)| (0..part.row_groups()).map(move |group| (k, group))).collect();
    let sorted = parts.iter().all(|part| part.sorted);
    let bounds: Option<Vec<(u64, [String; 2])>> = all
        .iter()
        .map(|&(part, group)| parts[part].bounds(group))
        .map(|(rows, bounds)| bounds.map(|bounds| (rows, bounds)))
        .collect();
    let Some(bounds) = bounds.filter(|_| sorted) else {
        return (vec![Slice { groups: all, ..Slice::default() }], sorted);
    };
    let mut starts: Vec<(&str, u64)> = bounds.iter().map(|(rows, [from, _])| (from.as_str(), *rows)).collect();
    starts.sort_unstable();
    // Where a part begins, a slice does: the units of parts that follow each other are then complete at their end.
    let first = |part: usize| all.iter().position(|(own, _)| *own == part).map(|place| bounds[place].1[0].as_str());
    let begins: Vec<&str> = (0..parts.len()).filter_map(first).collect();
    let (mut cuts, mut rows) = (vec![], 0);
    for (from, more) in starts {
        if (rows >= SLICE || begins.contains(&from)) && cuts.last().is_none_or(|last| *last != from) {
            (cuts, rows) = ([&cuts[..], &[from]].concat(), 0);
        }
        rows += more;
    }
    let ends = cuts.iter().map(Some).chain([None]);
    let slice = |(from, to): (Option<&&str>, Option<&&str>)| {
        let mut slice = Slice { from: from.map(ToString::to_string), to: to.map(ToString::to_string), groups: vec![] };
        let may_have = |(_, [first, last]): &(u64, [String; 2])| {
            slice.from.as_deref().is_none_or(|from| from <= last.as_str())
                && slice.to.as_deref().is_none_or(|to| first.as_str() < to)
        };
        slice.groups = all.iter().zip(&bounds).filter(|(_, own)| may_have(own)).map(|(place, _)| *place).collect();
        slice
    };
    ([None].into_iter().chain(cuts.iter().map(Some)).zip(ends).map(slice).collect(), true)
}

/// Reads the rows of a slice; `told` is called with numbers of rows that were read.
fn scan<V: Visitor>(
    parts: &[Part],
    (slice, sorted): (&Slice, bool),
    wanted: &Wanted,
    (visitor, told): (&mut V, &(dyn Fn(u64) + Sync)),
) -> Result<(), Error> {
    let alone = sorted && slice.groups.windows(2).all(|two| two[0].0 == two[1].0);
    let mut last: Option<(usize, String)> = None;
    for &(place, group) in &slice.groups {
        let part = &parts[place];
        for batch in part.read(group, wanted)? {
            let batch = batch?;
            let mut taken = 0;
            for rows in batch.stretches() {
                let unit = batch.texts(rows.start)[1];
                if !slice.has(unit) {
                    continue;
                }
                if last.as_ref().is_none_or(|(from, last)| *from != place || last != unit) {
                    let before = last.as_ref().filter(|(from, last)| sorted && *from == place && last.as_str() > unit);
                    if let Some((_, before)) = before {
                        let problem = format!("unit {unit} after {before}, but the file says that units ascend");
                        return Err(Error::content(&part.path, format!("row group {group}"), problem));
                    }
                    if alone {
                        visitor.complete()?;
                    }
                    last = Some((place, unit.to_string()));
                }
                taken += rows.len() as u64;
                visitor.rows(&batch, rows)?;
            }
            told(taken);
            if visitor.open() > MOST_OPEN && !sorted {
                let problem =
                    format!("more than {MOST_OPEN} units, and they do not ascend: sort the rows by the column unit");
                return Err(Error::content(&part.path, "column unit", problem));
            }
        }
    }
    visitor.complete()
}

/// Folds all slices and combines what the visitors have found, in the order of the slices.
pub(super) fn each_slice<V: Visitor>(
    parts: &[Part],
    wanted: &Wanted,
    told: &(dyn Fn(u64) + Sync),
    new: &(dyn Fn() -> Result<V, Error> + Sync),
    join: &(dyn Fn(V, V) -> Result<V, Error> + Sync),
) -> Result<V, Error> {
    let (slices, sorted) = slices(parts);
    let one = |slice: &Slice| {
        let mut visitor = new()?;
        scan(parts, (slice, sorted), wanted, (&mut visitor, told))?;
        Ok(visitor)
    };
    slices.par_iter().map(one).try_reduce_with(join).unwrap_or_else(new)
}

/// Sums of a slice.
struct Summing {
    sums: Sums,
    /// What errors usually are, of each feature.
    usual: Vec<f64>,
    /// The unit of the last rows, with its runs.
    name: String,
    unit: Unit,
    /// Units whose rows may go on.
    parked: BTreeMap<String, Unit>,
    /// Groups whose storage is used again.
    spare: Vec<Group>,
}

impl Summing {
    fn park(&mut self) {
        if !self.unit.is_empty() {
            let unit = std::mem::take(&mut self.unit);
            merge_unit(self.parked.entry(self.name.clone()).or_default(), unit);
        }
    }

    fn close(&mut self, unit: &mut Unit) -> Result<(), Error> {
        unit.sort_by(|(one, _), (two, _)| one.cmp(two));
        self.sums.close(unit)?;
        self.spare.extend(unit.drain(..).map(|(_, mut group)| {
            group.reset();
            group
        }));
        Ok(())
    }

    /// The place of a run of the last unit.
    fn place(&mut self, class: &str, run: &str) -> usize {
        let found = self.unit.iter().rposition(|((own, other), _)| own == class && other == run);
        found.unwrap_or_else(|| {
            let group = self.spare.pop().unwrap_or_else(|| Group::new(self.usual.len()));
            self.unit.push(((class.to_string(), run.to_string()), group));
            self.unit.len() - 1
        })
    }
}

impl Visitor for Summing {
    fn rows(&mut self, batch: &Batch, rows: Range<usize>) -> Result<(), Error> {
        let [class, unit, run] = batch.texts(rows.start);
        if self.name != unit {
            self.park();
            self.name = unit.to_string();
        }
        let place = self.place(class, run);
        for row in rows {
            let (values, variances) = (batch.values(row), batch.variances(row));
            let excess = || variances.iter().zip(&self.usual).map(|(own, usual)| (own - usual).max(0.0));
            if values.iter().any(|x| x.is_nan()) {
                self.sums.add_partial(class, values, &excess().collect::<Vec<_>>())?;
                continue;
            }
            self.sums.rows += 1;
            self.unit[place].1.add(values);
            if excess().any(|x| x > 0.0) {
                self.sums.add_excess(class, &excess().collect::<Vec<_>>())?;
            }
        }
        Ok(())
    }

    fn complete(&mut self) -> Result<(), Error> {
        if self.parked.is_empty() {
            let mut unit = std::mem::take(&mut self.unit);
            self.close(&mut unit)?;
            self.unit = unit;
        } else {
            self.park();
            while let Some((_, mut unit)) = self.parked.pop_first() {
                self.close(&mut unit)?;
            }
        }
        self.name.clear();
        Ok(())
    }

    fn open(&self) -> usize {
        self.parked.len()
    }
}

/// Sums the rows of parts; `told` is called with numbers of rows that were read.
///
/// # Errors
/// Parts of several plans, without the features, or damaged; too many units that do not ascend.
pub fn fold(parts: &[Part], wanted: &Wanted, told: &(dyn Fn(u64) + Sync)) -> Result<Sums, Error> {
    let first = parts.first().ok_or_else(|| Error::Usage("no part is given".into()))?;
    for part in &parts[1..] {
        if let Some(difference) = first.plan.difference(&part.plan) {
            let (one, two) = (first.path.display(), part.path.display());
            let problem = format!("{one} and {two} have different plans: {difference}");
            return Err(Error::Usage(format!("{problem}; compute both with one --plan")));
        }
    }
    let place = |name: &String| first.plan.features.iter().position(|own| own == name);
    let usual = wanted.features.iter().map(|name| place(name).map_or(0.0, |k| first.plan.usual[k])).collect::<Vec<_>>();
    let new = || {
        Ok(Summing {
            sums: Sums::new(&first.plan, &wanted.features)?,
            usual: usual.clone(),
            name: String::new(),
            unit: vec![],
            parked: BTreeMap::new(),
            spare: vec![],
        })
    };
    let join = |mut one: Summing, two: Summing| {
        one.sums.merge(&two.sums)?;
        Ok(one)
    };
    each_slice(parts, wanted, told, &new, &join).map(|slices| slices.sums)
}
