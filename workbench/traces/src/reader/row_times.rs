//! The time of each row of a trace, s, from the columns of a table.
//!
//! ```text
//! time column ─► seconds ─► + part of a second ─► counters go on, rounded times on a line ─► checks
//! no time     ─► the step that the file tells, if there is one and no rate is given
//! ```

use std::collections::BTreeMap;

use crate::reader::assemble::rows_of;
use crate::reader::header::Header;
use crate::table::{Columns, Table};
use crate::time;
use crate::time::second_part::is_below_a_second;
use model::Error;

/// How a table tells the time of its rows.
#[derive(Clone, Copy)]
pub(super) struct RowTimes<'a> {
    pub(super) table: &'a Table,
    pub(super) header: &'a Header,
    /// The column that was asked for.
    pub(super) asked: Option<&'a str>,
    /// The rate that was given.
    pub(super) rate_hz: Option<f64>,
}

impl RowTimes<'_> {
    /// Returns an error if a channel has times of its own in the first rows.
    pub(super) fn check_first_rows(&self) -> Result<(), Error> {
        match self.table.about().other_times.filter(|_| self.header.time.is_some()) {
            Some((place, line)) => Err(self.other_times(place, &format!("line {line}"))),
            None => Ok(()),
        }
    }

    /// Columns that are read beside the time: those that repeat it, and the part of a second.
    pub(super) fn further_places(&self) -> impl Iterator<Item = usize> {
        self.twins().iter().copied().chain(self.header.fraction.map(|(place, _)| place))
    }

    fn twins(&self) -> &[usize] {
        if self.header.time.is_some() { &self.header.twins } else { &[] }
    }

    /// An error of the time column says how to leave it out: it was found by its name, not requested.
    pub(super) fn excludable(&self, problem: Error) -> Error {
        match (self.header.time(), problem) {
            (Some(time), Error::Content { path, place, problem })
                if self.asked.is_none() && place.ends_with(&format!("column {}", self.header.names()[time])) =>
            {
                Error::Content { path, place, problem: problem + "; --time none leaves the time out" }
            }
            (_, other) => other,
        }
    }

    /// Returns an error if a column that repeats the time in the first rows differs from it in a later one.
    pub(super) fn check_twins(&self, places: &[usize], columns: &Columns) -> Result<(), Error> {
        let of_place = |place: usize| places.binary_search(&place).ok().and_then(|at| columns.numbers.get(at));
        let Some(times) = self.header.time().and_then(of_place) else { return Ok(()) };
        for twin in self.twins() {
            let differs = |(one, other): (&f64, &f64)| one.to_bits() != other.to_bits();
            let row = of_place(*twin).and_then(|repeated| repeated.iter().zip(times).position(differs));
            if let Some(row) = row {
                return Err(self.other_times(*twin, &columns.place(row)));
            }
        }
        Ok(())
    }

    /// A table whose channels have different times.
    fn other_times(&self, place: usize, line: &str) -> Error {
        let at = format!("{line}, column {} {}", place + 1, self.table.names()[place]);
        let problem = "this channel has times of its own; export the channels with one time, or each in a file";
        Error::content(self.table.path(), at, problem)
    }

    /// Takes the columns of the time out of those of a trace, but for those that signals need, and makes the times of
    /// its rows of them.
    pub(super) fn take(
        &self,
        columns: &mut BTreeMap<usize, Vec<f64>>,
        needed: &[usize],
        (id, place_of_row): (&str, &dyn Fn(usize) -> String),
    ) -> Result<Option<Vec<f64>>, Error> {
        let path = self.table.path();
        columns.retain(|place, _| !self.twins().contains(place) || needed.contains(place));
        let times = self.header.time.and_then(|(place, factor)| {
            let mut times =
                if needed.contains(&place) { columns.get(&place).cloned() } else { columns.remove(&place) }?;
            if factor != 1.0 {
                times.iter_mut().for_each(|t| *t *= factor);
            }
            Some(times)
        });
        let times = times.map(|times| self.with_fraction(times, columns, (needed, place_of_row))).transpose()?;
        let told_step = self.table.about().step_s.filter(|_| self.asked.is_none() && self.rate_hz.is_none());
        let by_row = |step: f64| (0..rows_of(columns, None)).map(|row| row as f64 * step).collect();
        let Some(mut times) = times.or_else(|| told_step.map(by_row)) else { return Ok(None) };
        if let Some((place, factor)) = self.header.time {
            let ticks = &self.table.about().ticks_s;
            let tick = ticks.iter().find(|(column, _)| *column == place).map_or(factor, |(_, tick)| *tick);
            let notes = [time::unwrapped(&mut times, Some(tick)), time::evened(&mut times)];
            notes.iter().flatten().for_each(|note| log::warn!("{}: {note}", path.display()));
        }
        let name = self.header.time().map_or("", |place| &self.header.names()[place]);
        let wrong = |problem: String| Err(Error::content(path, format!("column {name} of {id}"), problem));
        if !times.is_empty() && times.iter().all(|time| time.is_nan()) {
            return wrong("no row has a time; record it again, or leave the time out with --time none".into());
        }
        if self.header.time.is_some() && time::stands(&times) {
            return wrong(format!(
                "the time is the same in most of {} rows, too coarse to tell the rate; export it with the parts of a \
                 second, or give --time none and --rate-hz",
                times.len()
            ));
        }
        if let Some(row) = time::backwards(&times) {
            let place = format!("{}, column {name}", place_of_row(row));
            return Err(Error::content(path, place, "time runs backwards; sort the rows or split the trace there"));
        }
        Ok(Some(times))
    }

    /// With the part of a second, if that has a column of its own.
    fn with_fraction(
        &self,
        mut times: Vec<f64>,
        columns: &mut BTreeMap<usize, Vec<f64>>,
        (needed, place_of_row): (&[usize], &dyn Fn(usize) -> String),
    ) -> Result<Vec<f64>, Error> {
        let Some((place, unit)) = self.header.fraction else { return Ok(times) };
        let Some(parts) = columns.get(&place) else { return Ok(times) };
        let is_wrong = |value: &f64| value.is_finite() && !is_below_a_second(*value, unit);
        if let Some(row) = parts.iter().position(is_wrong) {
            let place = format!("{}, column {}", place_of_row(row), self.header.names()[place]);
            let problem = "more than a second, where the rows before have parts of one; name the time with --time";
            return Err(Error::content(self.table.path(), place, problem));
        }
        times.iter_mut().zip(parts).for_each(|(time, part)| *time += part * unit);
        if !needed.contains(&place) {
            columns.remove(&place);
        }
        Ok(times)
    }
}
