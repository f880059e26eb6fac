//! From the columns of a file to traces: one file a trace, or a tidy table with a `trace` column.

pub(crate) mod assemble;
mod changes;
pub(crate) mod header;
mod long_form;
mod row_times;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

pub use crate::reader::assemble::NO_TIME;
use crate::reader::assemble::{INTEGRAL, Rows as Given, assemble, elapsed, rows_of};
use crate::reader::header::{Header, header_of, is_wanted};
use crate::reader::row_times::RowTimes;
use crate::signal::{Signal, places_of, signs, values_of};
use crate::table::{Columns, Omitted, Table, Wanted};
use crate::time::names::usual;
use long_form::problem as long_form;
use model::Error;
use model::trace::{Channels, Trace, composed, trace_name};

/// Whether the header of a table has every wanted column.
pub(crate) fn has_columns(table: &Table, channels: &Channels) -> bool {
    header_of(table, channels.time.as_deref()).is_ok_and(|header| header.signals(channels).is_ok())
}

/// Reads the wanted traces of one table, with a sample for each row that it should have; only the wanted columns must
/// be numeric.
pub(crate) fn read(
    table: &Table,
    channels: &Channels,
    wanted: &(dyn Fn(&str) -> bool + Sync),
) -> Result<Vec<Trace>, Error> {
    read_rows(table, channels, wanted, |part| part.rows().complete())
}

/// Reads the wanted traces of one table, with a sample for each row that it has. Of the time column these are seconds,
/// on the line that rounded times are rounded from: what a front end numbers its rows by.
pub(crate) fn read_as_recorded(
    table: &Table,
    channels: &Channels,
    wanted: &(dyn Fn(&str) -> bool + Sync),
) -> Result<Vec<Trace>, Error> {
    read_rows(table, channels, wanted, |mut part| {
        let column = part.time.and_then(|place| part.columns.get_mut(&place));
        if let (Some(column), Some(times_s)) = (column, &part.times_s) {
            column.clone_from(times_s);
        }
        part.rows()
    })
}

/// Reads a piece of one or more traces, with a sample for each row; a channel may be missing all the time.
pub(crate) fn read_piece(table: &Table, channels: &Channels) -> Result<Vec<Trace>, Error> {
    read_rows(table, channels, &|_| true, |part| part.rows().piece())
}

fn read_rows(
    table: &Table,
    channels: &Channels,
    wanted: &(dyn Fn(&str) -> bool + Sync),
    rows_of: fn(Part) -> Given,
) -> Result<Vec<Trace>, Error> {
    let times = (channels.time.as_deref(), channels.rate_hz);
    let (signals, parts) = parts(table, times, &|header| header.signals(channels), wanted)?;
    let file = table.path().display();
    for part in &parts {
        let told = signs::told(&signals, table.names(), |place| part.columns.get(&place));
        told.iter().for_each(|told| log::warn!("{file}: {told}"));
    }
    let trace = |mut part: Part| assemble(std::mem::take(&mut part.id), channels, &signals, rows_of(part));
    parts.into_iter().map(trace).collect()
}

/// Channels of one trace.
#[derive(Debug)]
pub struct Series {
    /// Name of its file, or the `trace` cell of a tidy table.
    pub id: String,
    /// The time of each row, s, if there is one.
    pub times_s: Option<Vec<f64>>,
    /// The values of each channel.
    pub columns: Vec<Vec<f64>>,
}

/// Reads channels of each trace of a table; `rate_hz` stands for the time of a table without a column of times.
pub fn series(
    table: &Table,
    (time, rate_hz): (Option<&str>, Option<f64>),
    channels: &[String],
) -> Result<Vec<Series>, Error> {
    let signals = |header: &Header| {
        // Of many columns each is looked up at once.
        let mut places: HashMap<&str, usize> = HashMap::new();
        for (place, name) in header.names().iter().enumerate() {
            places.entry(name).or_insert(place);
        }
        let parse = |channel: &String| match places.get(&*composed(channel)) {
            Some(place) => Ok(Signal::Column(*place)),
            None => Signal::parse(channel, header.names()),
        };
        channels.iter().map(parse).collect()
    };
    let (signals, parts) = parts(table, (time, rate_hz), &signals, &|_| true)?;
    let each = |part: Part| {
        let Part { id, columns, times_s, .. } = part;
        let rows = rows_of(&columns, times_s.as_deref());
        let by_rate = || rate_hz.map(|rate| (0..rows).map(|row| row as f64 / rate).collect());
        let times_s = times_s.or_else(by_rate);
        if times_s.is_none() && signals.iter().any(Signal::integrates) {
            return Err(Error::trace(&id, INTEGRAL));
        }
        let columns = values_of(&signals, columns, rows, &elapsed(times_s.as_deref(), 0.0));
        Ok(Series { id, times_s, columns })
    };
    parts.into_iter().map(each).collect()
}

/// Whether a table has the columns of channels.
#[must_use]
pub fn has_channels(table: &Table, time: Option<&str>, channels: &[String]) -> bool {
    let has = |header: Header| channels.iter().all(|channel| Signal::parse(channel, header.names()).is_ok());
    header_of(table, time).is_ok_and(has)
}

/// The names of the columns of a table that hold numbers, but for its time, and why others do not.
pub fn numeric(table: &Table, time: Option<&str>) -> Result<(Vec<String>, Vec<Error>), Error> {
    numeric_with(table, time, &mut |_, _| {})
}

/// The same, with a look at the values of each column.
pub(crate) fn numeric_with(
    table: &Table,
    time: Option<&str>,
    look: &mut dyn FnMut(&str, &[f64]),
) -> Result<(Vec<String>, Vec<Error>), Error> {
    let header = header_of(table, time)?;
    if let Some(problem) = long_form(table) {
        return Err(Error::content(table.path(), "header", problem));
    }
    let own =
        |place: &usize| Some(*place) != header.trace && !header.is_time(*place) && !header.names()[*place].is_empty();
    let places: Vec<usize> = (0..header.names().len()).filter(own).collect();
    let (mut kept, mut problems) = (Vec::new(), Vec::new());
    for (place, column) in places.iter().zip(table.read_each(&places)?) {
        match column {
            Ok(values) => {
                look(&header.names()[*place], &values);
                kept.push(header.names()[*place].clone());
            }
            Err(problem) => problems.push(problem),
        }
    }
    // Where no column has a number, what is nested says more than the words beside it.
    if let Some(Omitted { place, reason }) = table.about().omitted.first().filter(|_| kept.is_empty()) {
        return Err(Error::content(table.path(), place.clone(), reason.clone()));
    }
    Ok((kept, problems))
}

/// Whether a column of this name is a time.
#[must_use]
pub fn is_time(name: &str) -> bool {
    usual(name).is_some()
}

/// Whether a table has a time column.
#[must_use]
pub fn has_time(table: &Table, time: Option<&str>) -> bool {
    header_of(table, time).is_ok_and(|header| header.time.is_some() || time.is_none() && table.about().step_s.is_some())
}

/// The names of the traces of the rows of a table that has a column of them.
pub(crate) fn names_of_rows(table: &Table) -> Option<Vec<String>> {
    let place = table.names().iter().position(|name| name == "trace")?;
    table.read(Wanted { numbers: &[], text: Some(place), row: &|_| true }).ok()?.texts
}

/// The names of the columns of numbers of a file with this content, its first trace, and what is said of it.
#[cfg(test)]
pub(crate) fn of_content(
    name: &str,
    content: &str,
    rate_hz: Option<f64>,
) -> Result<(Vec<String>, Series, Vec<String>), Error> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, content).expect("writable");
    let table = Table::open(&path)?;
    let (names, _) = numeric(&table, None)?;
    let first = series(&table, (None, rate_hz), &names)?.remove(0);
    Ok((names, first, table.about().told().collect()))
}

/// The columns of one trace.
struct Part {
    id: String,
    /// The columns that signals need, by their places in the file.
    columns: BTreeMap<usize, Vec<f64>>,
    times_s: Option<Vec<f64>>,
    /// The place of the time column.
    time: Option<usize>,
}

impl Part {
    fn rows(self) -> Given {
        Given::of(self.columns, self.times_s)
    }
}

/// Reads the columns of signals, one part for each trace; a given rate stands for the one that the file tells.
fn parts(
    table: &Table,
    (time, rate_hz): (Option<&str>, Option<f64>),
    signals: &dyn Fn(&Header) -> Result<Vec<Signal>, String>,
    wanted: &(dyn Fn(&str) -> bool + Sync),
) -> Result<(Vec<Signal>, Vec<Part>), Error> {
    let path = table.path();
    let wrong = |problem: String| Error::content(path, "header", problem);
    let id = table.id();
    let header = header_of(table, time)?;
    if !is_wanted(&header, table, wanted) {
        return Ok((vec![], vec![]));
    }
    if let Some(problem) = long_form(table) {
        return Err(wrong(problem));
    }
    let signals = signals(&header).map_err(wrong)?;
    let needed = places_of(&signals);
    let row_times = RowTimes { table, header: &header, asked: time, rate_hz };
    row_times.check_first_rows()?;
    let mut places: Vec<usize> = header.time().into_iter().chain(needed.iter().copied()).collect();
    if let Some(name) = header.doubled(&places) {
        return Err(wrong(format!("column {name} comes twice; rename or remove one")));
    }
    places.extend(row_times.further_places());
    places.sort_unstable();
    places.dedup();
    let read = table.read(Wanted { numbers: &places, text: header.trace, row: &|cell| wanted(&trace_name(cell)) });
    let mut columns = read.map_err(|problem| row_times.excludable(problem))?;
    row_times.check_twins(&places, &columns)?;
    let rows = Rows::split(path, &columns, &id)?;
    report(table, &header, &rows, columns.numbers.first().map_or(0, Vec::len));
    let mut whole = Some(std::mem::take(&mut columns.numbers));
    let each = |rows: Rows| -> Result<Part, Error> {
        let of_trace = match rows.rows {
            None => whole.take().unwrap_or_default(),
            Some(_) => whole.iter().flatten().map(|column| rows.of(column)).collect(),
        };
        let mut of_place: BTreeMap<usize, Vec<f64>> = places.iter().copied().zip(of_trace).collect();
        hold_changes(table, &header, &rows.id, &mut of_place);
        let place_of_row = |row: usize| columns.place(rows.row(row));
        let times_s = row_times.take(&mut of_place, &needed, (&rows.id, &place_of_row))?;
        Ok(Part { id: rows.id, columns: of_place, times_s, time: header.time() })
    };
    let parts = rows.into_iter().map(each).collect::<Result<_, Error>>()?;
    Ok((signals, parts))
}

/// Holds the values of a log of changes, and says so; a table in memory may be a piece, whose values tell too little.
fn hold_changes(table: &Table, header: &Header, id: &str, columns: &mut BTreeMap<usize, Vec<f64>>) {
    for (place, column) in columns.iter_mut().filter(|(place, _)| !table.is_in_memory() && !header.is_time(**place)) {
        let rows = column.len();
        if let Some(empty) = changes::hold(column) {
            let (file, name) = (table.path().display(), &header.names()[*place]);
            log::warn!(
                "{file}: column {name} of {id}: {empty} of {rows} cells are empty, and no value comes twice: a log of \
                 changes, whose last value is held"
            );
        }
    }
}

/// Reports what is read of a file, and what was left out or guessed.
fn report(table: &Table, header: &Header, traces: &[Rows], rows: usize) {
    let (file, count) = (table.path().display(), traces.len());
    table.about().told().for_each(|told| log::warn!("{file}: {told}"));
    match header.time() {
        Some(time) => log::info!("read {file}: traces {count}, rows {rows}, time by column {}", header.names()[time]),
        None => log::info!("read {file}: traces {count}, rows {rows}, no time column"),
    }
}

/// The rows of one trace.
struct Rows {
    id: String,
    /// Its rows in a tidy table; `None` for all.
    rows: Option<Vec<usize>>,
}

impl Rows {
    /// The traces of a table, in the order of their first rows.
    fn split(path: &Path, columns: &Columns, id: &str) -> Result<Vec<Self>, Error> {
        let Some(ids) = &columns.texts else { return Ok(vec![Self { id: id.into(), rows: None }]) };
        let (mut places, mut found): (HashMap<&str, usize>, Vec<Self>) = (HashMap::new(), Vec::new());
        for (row, id) in ids.iter().enumerate() {
            if id.is_empty() {
                let place = format!("{}, column trace", columns.place(row));
                return Err(Error::content(path, place, "no trace id; fill it in or remove the row"));
            }
            let place = *places.entry(id).or_insert_with(|| {
                found.push(Self { id: id.clone(), rows: Some(vec![]) });
                found.len() - 1
            });
            found[place].rows.get_or_insert_default().push(row);
        }
        Ok(found)
    }

    fn of(&self, column: &[f64]) -> Vec<f64> {
        self.rows.iter().flatten().map(|row| column[*row]).collect()
    }

    /// The row of the table.
    fn row(&self, own: usize) -> usize {
        self.rows.as_ref().map_or(own, |rows| rows[own])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channels() -> Channels {
        Channels::new("i", "ref-v", "load-cell")
    }

    fn file(content: &str) -> tempfile::NamedTempFile {
        let file = tempfile::Builder::new().suffix(".csv").tempfile().expect("temporary file");
        std::fs::write(file.path(), content).expect("writable");
        file
    }

    fn of_file(file: &tempfile::NamedTempFile, channels: &Channels) -> Result<Vec<Trace>, Error> {
        read(&Table::open(file.path())?, channels, &|_| true)
    }

    fn message(content: &str) -> String {
        of_file(&file(content), &channels()).expect_err("bad input").to_string()
    }

    #[test]
    fn single_file_with_difference_and_dashed_name() {
        let f = file("t_s,i,ref,v,load-cell,comment\n0,1,10,4,7,start\n0.5,2,11,4,8,\n");
        let traces = of_file(&f, &channels()).expect("good file");
        assert_eq!(traces.len(), 1);
        assert_eq!((traces[0].y.clone(), traces[0].u1.clone()), (vec![1.0, 2.0], vec![6.0, 7.0]));
        assert_eq!((traces[0].u2.clone(), traces[0].interval_s), (vec![7.0, 8.0], Some(0.5)));
    }

    #[test]
    fn tidy_table_keeps_first_appearance_order() {
        let f = file("trace,i,ref,v,load-cell\nb,1,0,0,0\na,2,0,0,0\nb,3,0,0,0\n");
        let traces = of_file(&f, &channels()).expect("good file");
        let ids: Vec<_> = traces.iter().map(|t| t.id.as_str()).collect();
        assert_eq!((ids, traces[0].y.clone()), (vec!["b", "a"], vec![1.0, 3.0]));
    }

    #[test]
    fn bad_content_names_line_and_column() {
        let good = "t_s,i,ref,v,load-cell\n0,1,2,3,4\n";
        assert!(message("t_s,i,ref,v\n0,1,2,3\n").contains("header: no column (or difference of columns) load-cell"));
        assert!(message(&format!("{good}0,1,2\n")).contains("line 3: 3 cells where the header has 5"));
        assert!(message(&format!("{good}0,x,2,3,4\n")).contains("line 3, column i: \"x\" is not a number"));
        assert!(message(&format!("{good}0,1,2,missing,4\n")).contains("line 3, column v: \"missing\" is not a number"));
        assert!(message("t_s,i,ref,v,load-cell\n0,1,2,,4\n1,2,2,NaN,3\n").contains("column v: no number in any row"));
        assert!(message("t_s,i,ref,v,load-cell\n,1,2,3,4\n").contains("t_s: no number in any row; leave the column"));
        assert!(message("t_s,i,ref,v,load-cell\n").contains("no rows"));
        assert!(message(&format!("{good}0,1e300,2,3,4\n")).contains("column i: 1e300 is no measured value"));
        assert!(message(&format!("{good}-1,1,2,3,4\n")).contains("line 3, column t_s: time runs backwards"));
        assert!(message(&format!("{good},1,2,3,4\n-1,1,2,3,4\n")).contains("line 4, column t_s: time runs backwards"));
        assert!(message("i,ref,v,load-cell,i\n1,2,3,4,5\n").contains("column i comes twice"));
        assert!(message("").contains("the file is empty"));
        assert!(message("trace,i,ref,v,load-cell\n,1,2,3,4\n").contains("line 2, column trace: no trace id"));
    }

    #[test]
    fn time_has_many_names_and_a_rate_stands_for_it() {
        for (name, step, seconds) in [
            ("t_s", 0.5, 0.5),
            ("Time [ms]", 500.0, 0.5),
            ("time", 0.5, 0.5),
            ("timestamp_us", 5e5, 0.5),
            ("t (s)", 0.5, 0.5),
        ] {
            let f = file(&format!("{name},i,ref,v,load-cell\n0,1,2,3,4\n{step},1,2,3,4\n"));
            let trace = &of_file(&f, &channels()).expect(name)[0];
            assert!(
                trace.interval_s.is_some_and(|found| (found - seconds).abs() < 1e-12),
                "{name}: {:?}",
                trace.interval_s
            );
        }
        let f = file("T1,clock,i,ref,v,load-cell\n0,9,1,2,3,4\n2,10,1,2,3,4\n");
        let with = |time: Option<&str>, rate_hz: Option<f64>| {
            let channels = Channels { time: time.map(String::from), rate_hz, ..channels() };
            of_file(&f, &channels).map(|traces| traces[0].interval_s).map_err(|error| error.to_string())
        };
        assert_eq!((with(None, None), with(Some("T1"), None)), (Ok(None), Ok(Some(2.0))));
        assert_eq!((with(None, Some(4.0)), with(Some("none"), None)), (Ok(Some(0.25)), Ok(None)));
        assert!(with(Some("clock"), Some(4.0)).expect_err("another rate").contains("has 1.00000 rows a second, not 4"));
        assert!(with(Some("t"), None).expect_err("no column").contains("no column t for the time"));
        let f = file("timestamp,i,ref,v,load-cell\n12:30:01,1,2,3,4\n12:30:02,1,2,3,4\n");
        assert_eq!(of_file(&f, &channels()).expect("a clock")[0].interval_s, Some(1.0));
        let f = file("timestamp,i,ref,v,load-cell\nfirst,1,2,3,4\nsecond,1,2,3,4\n");
        let words = of_file(&f, &channels()).expect_err("words").to_string();
        assert!(words.ends_with("column timestamp: \"first\" is not a number; --time none leaves the time out"));
    }
}
