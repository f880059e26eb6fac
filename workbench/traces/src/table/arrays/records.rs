//! Several records in one file of arrays: each is a trace of its own, named by a column `trace`.
//!
//! ```text
//! a.h5    /run_0/t, /run_0/i, /run_1/t, /run_1/i      traces a_run_0 and a_run_1, columns t, i
//! a.mat   data(1).t, data(1).i, data(2).t, data(2).i  traces a_1 and a_2
//! ```
//!
//! Groups are records if they have the same arrays, and either arrays of other lengths or a time of their own; several
//! axes, sensors or phases of one recording have one length, and stay its columns. What is in no record belongs to each
//! of them if it is one number, or has a value for each of its rows.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::table::arrays::columns::{of_one_length, rising_time};
use crate::table::arrays::groups::{Group, Named, all_parts, are_records, groups, last, number_of_element, places};
use crate::table::columns::About;
use crate::table::columns::{Columns, Wanted};
use crate::table::limit::Limit;
use crate::time::names;
use model::Error;
use model::trace::{file_name, stem};

/// The column with the ids of the traces.
const TRACE: &str = "trace";
/// Records that are named where they are told.
const TOLD: usize = 5;
/// Columns of arrays, the rows of one record after those of another.
#[derive(Debug, Default)]
pub(in crate::table) struct Arrays {
    pub(in crate::table) names: Vec<String>,
    /// The first one is empty if there are several records: it has their ids.
    pub(in crate::table) columns: Vec<Vec<f64>>,
    /// Ids of several records, and their numbers of rows.
    records: Vec<(String, usize)>,
}

impl From<(Vec<String>, Vec<Vec<f64>>)> for Arrays {
    fn from((names, columns): (Vec<String>, Vec<Vec<f64>>)) -> Self {
        Self { names, columns, records: vec![] }
    }
}

impl Arrays {
    /// Reads columns.
    pub(in crate::table) fn read(&self, wanted: Wanted<'_>) -> Columns {
        let by_trace = wanted.text == Some(0) && !self.records.is_empty();
        let mut kept = Vec::new();
        let (mut texts, mut start) = (Vec::new(), 0);
        for (id, rows) in &self.records {
            if !by_trace || (wanted.row)(id) {
                kept.push(start..start + rows);
                texts.extend(std::iter::repeat_n(id.clone(), if by_trace { *rows } else { 0 }));
            }
            start += rows;
        }
        let column = |place: &usize| match (&self.columns[*place], self.records.is_empty()) {
            (column, true) => column.clone(),
            // Ids are no numbers.
            (_, false) if *place == 0 => vec![f64::NAN; kept.iter().map(ExactSizeIterator::len).sum()],
            (column, false) => kept.iter().flat_map(|rows| &column[rows.clone()]).copied().collect(),
        };
        Columns {
            numbers: wanted.numbers.iter().map(column).collect(),
            texts: by_trace.then_some(texts),
            ..Columns::default()
        }
    }
}

/// The arrays of a file as columns: those of one record, or of several.
///
/// # Errors
/// No arrays of numbers, more than the limit, or records of different rates without times.
pub(in crate::table) fn columns_of(path: &Path, arrays: Named, about: &mut About) -> Result<Arrays, Error> {
    match Split::of(&arrays) {
        Some(split) => split.columns(path, arrays, about),
        None => Ok(Arrays::from(of_one_length(path, arrays, about)?)),
    }
}

/// Of a record the id, the names and places of its arrays, and its rows.
type OfRecord = (String, Vec<(String, usize)>, usize);

/// The records of a file, and the arrays of none.
struct Split {
    records: Vec<OfRecord>,
    others: Vec<usize>,
}

impl Split {
    /// Finds the records among arrays, the innermost groups first; `None` if there is one record.
    fn of(arrays: &Named) -> Option<Self> {
        let all = all_parts(arrays);
        let deepest = all.iter().map(Vec::len).max()?;
        (1..deepest).rev().find_map(|depth| {
            let groups = groups(arrays, &all, depth);
            let mut counts: BTreeMap<&BTreeSet<&str>, usize> = BTreeMap::new();
            groups.iter().for_each(|group| *counts.entry(&group.signals).or_default() += 1);
            let (usual, _) =
                counts.iter().filter(|(signals, _)| !signals.is_empty()).max_by_key(|(_, count)| **count)?;
            let (records, others): (Vec<_>, Vec<_>) = groups.iter().partition(|group| group.is_like(usual));
            // Groups that are alike in another way are parts of records further out.
            let is_alone = others.iter().all(|other| counts[&other.signals] == 1);
            (records.len() > 1 && is_alone && are_records(&records, arrays)).then(|| Self::with(&records, arrays.len()))
        })
    }

    fn with(records: &[&Group<'_>], arrays: usize) -> Self {
        let first = &records[0].name;
        let is_common = |k: &usize| records.iter().all(|record| record.name.get(*k) == first.get(*k));
        let common = (0..first.len()).take_while(is_common).count();
        let list = first[..common].last().copied().unwrap_or("m");
        let is_short = records.iter().all(|record| {
            let last: BTreeSet<&str> = record.arrays.iter().map(|(name, _)| last(name)).collect();
            last.len() == record.arrays.len()
        });
        let named = |name: &str| match name {
            // The columns of a matrix in a list have but a number.
            _ if name.starts_with('_') => format!("{list}{name}"),
            _ if is_short => last(name).to_string(),
            _ => name.to_string(),
        };
        let each = |record: &&Group<'_>| {
            let part = |part: &&str| number_of_element(part).unwrap_or(part).to_string();
            let id: Vec<String> = record.name[common..].iter().map(part).collect();
            (id.join("_"), record.arrays.iter().map(|(name, place)| (named(name), *place)).collect(), record.rows)
        };
        let inside = places(records);
        let others = (0..arrays).filter(|place| !inside.contains(place)).collect();
        Self { records: records.iter().map(each).collect(), others }
    }

    /// The columns of all records.
    fn columns(self, path: &Path, arrays: Named, about: &mut About) -> Result<Arrays, Error> {
        let file = stem(&file_name(path)).to_string();
        let rows: Vec<usize> = self.records.iter().map(|(.., rows)| *rows).collect();
        let fits = |place: &&usize| {
            let count = arrays[**place].1.len();
            count == 1 || rows.iter().all(|rows| *rows == count)
        };
        let (shared, left): (Vec<&usize>, Vec<&usize>) = self.others.iter().partition(fits);
        for place in left {
            about.omit(format!("array {}", arrays[*place].0), "it is in no record, and has other rows than they");
        }
        let mut all = Arrays { names: vec![TRACE.into()], columns: vec![vec![]], records: vec![] };
        let mut abouts = Vec::new();
        let mut limit = Limit::of_file(path)?;
        for (id, own, rows) in &self.records {
            let own = own.iter().map(|(name, place)| (name.clone(), *place));
            let shared = shared.iter().map(|place| (arrays[**place].0.clone(), **place));
            let of_record: Named = own.chain(shared).map(|(name, place)| (name, arrays[place].1.clone())).collect();
            let claimed = limit.claim_numbers([*rows as u64, of_record.len() as u64]);
            claimed.map_err(|problem| Error::content(path, format!("record {id}"), problem))?;
            let mut told = About::default();
            let (names, columns) = of_one_length(path, of_record, &mut told)?;
            rising_time(&names, &columns, &mut told);
            for omitted in std::mem::take(&mut told.omitted) {
                about.omit(format!("record {id}, {}", omitted.place), omitted.reason);
            }
            let clock = told.clocks.first().map(|place| names[*place].clone());
            abouts.push((clock, told));
            all.add(format!("{file}_{id}"), names, columns);
        }
        all.say(path, abouts, about)?;
        Ok(all)
    }
}

impl Arrays {
    /// Adds the rows of a record; it lacks columns that others have.
    fn add(&mut self, id: String, names: Vec<String>, columns: Vec<Vec<f64>>) {
        let filled = self.records.iter().map(|(_, rows)| rows).sum();
        let rows = columns.first().map_or(0, Vec::len);
        for (name, column) in names.into_iter().zip(columns) {
            // A second column of a name stays, with its name twice, as in a header.
            let is_free = |place: &usize| self.names[*place] == name && self.columns[*place].len() <= filled;
            let place = (1..self.names.len()).find(is_free).unwrap_or_else(|| {
                self.names.push(name.clone());
                self.columns.push(vec![]);
                self.names.len() - 1
            });
            self.columns[place].resize(filled, f64::NAN);
            self.columns[place].extend(column);
        }
        self.columns.iter_mut().skip(1).for_each(|column| column.resize(filled + rows, f64::NAN));
        self.records.push((id, rows));
    }

    /// Says which records there are, and how they tell the time.
    fn say(&self, path: &Path, told: Vec<(Option<String>, About)>, about: &mut About) -> Result<(), Error> {
        let ids: Vec<&str> = self.records.iter().take(TOLD).map(|(id, _)| id.as_str()).collect();
        let more = if self.records.len() > TOLD { ", …" } else { "" };
        let count = self.records.len();
        about.notes.push(format!("{count} records, each a trace of its own: {}{more}", ids.join(", ")));
        let has_time = self.names.iter().any(|name| names::usual(name).is_some());
        let Some((clock, first)) = told.first() else { return Ok(()) };
        if let Some(clock) = clock.as_ref().filter(|_| told.iter().all(|(other, _)| other == clock)) {
            about.clocks.extend(self.names.iter().position(|name| name == clock));
        }
        if told.iter().all(|(_, own)| own.step_s == first.step_s) {
            about.step_s = first.step_s;
            about.notes.extend(first.notes.iter().cloned());
        } else if !has_time && about.clocks.is_empty() {
            let problem = "the records have different rates; add a time to each, or save each in a file of its own";
            return Err(Error::content(path, "content", problem));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Arrays by their names and lengths; each counts up from its place.
    fn of(arrays: &[(&str, usize)]) -> Result<(Arrays, About), String> {
        let file = tempfile::Builder::new().prefix("a").suffix(".h5").tempfile().expect("a file");
        let values = |place: usize, count: usize| (0..count).map(|k| (place * 1000 + k) as f64).collect();
        let arrays = arrays.iter().enumerate();
        let arrays = arrays.map(|(place, (name, count))| (name.to_string(), values(place, *count))).collect();
        let mut about = About::default();
        let own = columns_of(file.path(), arrays, &mut about).map_err(|error| error.to_string())?;
        Ok((own, about))
    }

    /// Names, and the ends of the ids of the records with their rows.
    fn told(arrays: &[(&str, usize)]) -> (String, String) {
        let (own, _) = of(arrays).expect("columns");
        let record = |(id, rows): &(String, usize)| format!("{} {rows}", id.split_once('_').map_or("", |(_, id)| id));
        (own.names.join(" "), own.records.iter().map(record).collect::<Vec<_>>().join(", "))
    }

    #[test]
    fn groups_of_other_lengths_or_with_times_are_records() {
        for (arrays, names, records) in [
            (&[("run_0/t", 3), ("run_0/i", 3), ("run_1/t", 2), ("run_1/i", 2)][..], "trace t i", "run_0 3, run_1 2"),
            (&[("d(1).i", 3), ("d(1).w", 3), ("d(2).i", 4), ("d(2).w", 4)], "trace i w", "1 3, 2 4"),
            (&[("d(1).t", 3), ("d(1).i", 3), ("d(2).t", 3), ("d(2).i", 3)], "trace t i", "1 3, 2 3"),
            (&[("ok/a/t", 3), ("ok/a/i", 3), ("bad/a/t", 3), ("bad/a/i", 3)], "trace t i", "ok_a 3, bad_a 3"),
            (
                &[("ok.t", 3), ("ok.i", 3), ("ok.w", 3), ("bad.t", 3), ("bad.i", 3), ("bad.q", 3)],
                "trace t i w q",
                "ok 3, bad 3",
            ),
            (&[("c(1)_1", 3), ("c(1)_2", 3), ("c(2)_1", 2), ("c(2)_2", 2)], "trace c_1 c_2", "1 3, 2 2"),
            (
                &[("r1/m/i", 3), ("r1/e/q", 3), ("r1/load", 1), ("r2/m/i", 2), ("r2/e/q", 2), ("r2/load", 1)],
                "trace i q load",
                "r1 3, r2 2",
            ),
            (&[("run1_1", 3), ("run1_2", 3), ("run2_1", 2), ("run2_2", 2)], "trace m_1 m_2", "run1 3, run2 2"),
            (
                &[("v1.5/t", 3), ("v1.5/i", 3), ("v2.5/t", 3), ("v2.5/i", 3), ("calibration", 7)],
                "trace t i",
                "v1.5 3, v2.5 3",
            ),
        ] {
            let (found, of_records) = told(arrays);
            assert_eq!((found.as_str(), of_records.as_str()), (names, records), "{arrays:?}");
        }
    }

    #[test]
    fn parts_of_one_recording_are_no_records() {
        for arrays in [
            // Axes, with a time of all or their own.
            &[("axis_0/i", 3), ("axis_0/w", 3), ("axis_1/i", 3), ("axis_1/w", 3), ("t", 3)][..],
            &[("axis_0/t", 3), ("axis_0/w", 3), ("axis_1/t", 3), ("axis_1/w", 3)],
            &[("left/i", 3), ("left/w", 3), ("right/i", 3), ("right/w", 3)],
            // A signal in each group.
            &[("current/time", 3), ("current/value", 3), ("temperature/time", 2), ("temperature/value", 2)],
            &[("motor.i", 3), ("encoder.q", 3), ("c(1)", 3), ("c(2)", 3)],
            &[("m_1", 3), ("m_2", 3)],
            &[("m1_1", 3), ("m1_2", 3), ("m2_1", 3), ("m2_2", 3)],
            // Two matrices of other things.
            &[("current_1", 3), ("current_2", 3), ("heat_1", 2), ("heat_2", 2)],
            &[("axis1_1", 3), ("axis1_2", 3), ("axis2_1", 2), ("axis2_2", 2)],
        ] {
            let (names, records) = told(arrays);
            assert_eq!((records.as_str(), names.starts_with("trace")), ("", false), "{arrays:?}");
        }
    }

    #[test]
    fn what_is_in_no_record_belongs_to_all_or_is_left_out() {
        let arrays = [("fs", 1), ("r1/i", 3), ("r1/w", 3), ("r2/i", 3), ("r2/w", 2), ("extra", 5), ("fit", 3)];
        let (own, about) = of(&[&arrays[..6], &[("r3/i", 4), ("r3/w", 4)]].concat()).expect("columns");
        assert_eq!(own.names, ["trace", "i", "w", "fs"]);
        let nan: Vec<usize> = (0..10).filter(|row| own.columns[2][*row].is_nan()).collect();
        assert_eq!((own.columns[1].len(), nan), (10, vec![3, 4, 5]));
        let left: Vec<&str> = about.omitted.iter().map(|own| own.place.as_str()).collect();
        assert_eq!(left, ["array extra", "record r2, array w"]);
        assert!(about.notes[0].starts_with("3 records, each a trace of its own: "), "{:?}", about.notes);
        let (own, _) = of(&[("r1/t", 3), ("r1/i", 3), ("r2/t", 3), ("r2/i", 3), ("fit", 3)]).expect("columns");
        assert_eq!((own.names.join(" "), &own.columns[3][3..]), ("trace t i fit".into(), &own.columns[3][..3]));
        // Each record has its rate, and no time.
        let arrays = [("r1/i", 3), ("r1/w", 3), ("r1/fs", 1), ("r2/i", 2), ("r2/w", 2), ("r2/fs", 1)];
        let refused = of(&arrays).map(|_| ()).expect_err("two rates");
        assert!(refused.contains("the records have different rates; add a time to each"), "{refused}");
    }

    #[test]
    fn the_rows_of_wanted_records_are_read() {
        let (own, _) = of(&[("r1/t", 3), ("r1/i", 3), ("r2/t", 2), ("r2/i", 2)]).expect("columns");
        let second = own.records[1].0.clone();
        let read = own.read(Wanted { numbers: &[2], text: Some(0), row: &|id| id == second });
        assert_eq!((read.numbers, read.texts), (vec![vec![3000.0, 3001.0]], Some(vec![second; 2])));
        let all = own.read(Wanted { numbers: &[0, 1], text: None, row: &|_| true });
        assert!(all.numbers[0].iter().all(|id| id.is_nan()) && all.numbers[1].len() == 5 && all.texts.is_none());
    }
}
