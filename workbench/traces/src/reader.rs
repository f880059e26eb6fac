//! From the columns of a file to traces: one file a trace, or a tidy table with a `trace` column.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

pub use crate::assemble::NO_TIME;
use crate::assemble::{INTEGRAL, Rows as Given, assemble, elapsed};
use crate::signal::{Signal, places_of, values_of};
use crate::table::fraction::is_below_a_second;
use crate::table::time_name::{seconds, usual};
use crate::table::{About, Columns, Omitted, Table, Wanted, long_form};
use crate::time;
use model::Error;
use model::trace::{Channels, Trace, stem};

/// The names of the columns.
pub(super) struct Header {
    names: Vec<String>,
    trace: Option<usize>,
    /// Place of the time, and the factor to seconds.
    time: Option<(usize, f64)>,
    /// Places of columns that repeat the time.
    twins: Vec<usize>,
    /// Place of the part of a second that the time lacks, and the seconds of its unit.
    fraction: Option<(usize, f64)>,
}

impl Header {
    /// Of these columns; `time` is the column that was asked for, and the table tells which others are times.
    ///
    /// # Errors
    /// There is no such column.
    pub(super) fn of(names: Vec<String>, time: Option<&str>, about: &About) -> Result<Self, String> {
        let factor =
            |place: usize| if about.clocks.contains(&place) { 1.0 } else { seconds(&names[place]).unwrap_or(1.0) };
        let time = match time {
            Some(NO_TIME) => None,
            Some(wanted) => {
                let place = names.iter().position(|name| name == wanted);
                let place =
                    place.ok_or_else(|| format!("no column {wanted} for the time; there are {}", names.join(", ")))?;
                Some((place, factor(place)))
            }
            None => {
                let is_time = |place: &usize| usual(&names[*place]).is_some() && !about.counters.contains(place);
                // Dates and the like are a time whatever their column is called.
                let place = (0..names.len()).find(is_time).or_else(|| about.clocks.first().copied());
                let unit = |place: usize| usual(&names[place]).flatten().filter(|_| !about.clocks.contains(&place));
                place.map(|place| (place, unit(place).unwrap_or_else(|| factor(place))))
            }
        };
        let twins = about.twins.clone();
        let fraction = about.fraction.filter(|(place, _)| time.is_some_and(|(time, _)| time + 1 == *place));
        Ok(Self { fraction, trace: names.iter().position(|name| name == "trace"), time, twins, names })
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    pub(super) fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|column| column == name)
    }

    /// Place of the time.
    pub(super) fn time(&self) -> Option<usize> {
        self.time.map(|(place, _)| place)
    }

    /// A wanted column whose name occurs twice.
    fn doubled(&self, places: &[usize]) -> Option<&str> {
        let own = places.iter().copied().chain(self.trace).chain(self.time());
        let mut counts: HashMap<&str, usize> = HashMap::new();
        let single = self.names.iter().enumerate().filter(|(place, _)| !self.twins.contains(place));
        single.for_each(|(_, name)| *counts.entry(name).or_default() += 1);
        own.map(|place| self.names[place].as_str()).find(|name| counts[name] > 1)
    }

    /// Signals of y, u1, u2, of the further columns, and, if the shaft is watched, of current and angle, and of
    /// velocity, load and reference if they are given.
    pub(super) fn signals(&self, channels: &Channels) -> Result<Vec<Signal>, String> {
        if self.names.iter().all(String::is_empty) {
            return Err("the file is empty".into());
        }
        channels.in_order().into_iter().map(|channel| Signal::parse(channel, &self.names)).collect()
    }
}

/// The header of a table.
pub(super) fn header_of(table: &Table, time: Option<&str>) -> Result<Header, Error> {
    Header::of(table.names().to_vec(), time, table.about())
        .map_err(|problem| Error::content(table.path(), "header", problem))
}

/// Whether a table may have wanted traces: its only one is, or it has several.
pub(super) fn is_wanted(header: &Header, table: &Table, wanted: &(dyn Fn(&str) -> bool + Sync)) -> bool {
    header.trace.is_some() || wanted(stem(&table.id()))
}

/// Whether the header of a table has every wanted column.
pub(super) fn has_columns(table: &Table, channels: &Channels) -> bool {
    header_of(table, channels.time.as_deref()).is_ok_and(|header| header.signals(channels).is_ok())
}

/// Reads the wanted traces of one table, with a sample for each row that it should have; only the wanted columns must
/// be numeric.
pub(super) fn read(
    table: &Table,
    channels: &Channels,
    wanted: &(dyn Fn(&str) -> bool + Sync),
) -> Result<Vec<Trace>, Error> {
    read_rows(table, channels, wanted, Given::complete)
}

/// Reads the wanted traces of one table, with a sample for each row that it has.
pub(super) fn read_as_recorded(
    table: &Table,
    channels: &Channels,
    wanted: &(dyn Fn(&str) -> bool + Sync),
) -> Result<Vec<Trace>, Error> {
    read_rows(table, channels, wanted, |rows| rows)
}

/// Reads a piece of one or more traces, with a sample for each row; a channel may be missing all the time.
pub(super) fn read_piece(table: &Table, channels: &Channels) -> Result<Vec<Trace>, Error> {
    read_rows(table, channels, &|_| true, Given::piece)
}

fn read_rows(
    table: &Table,
    channels: &Channels,
    wanted: &(dyn Fn(&str) -> bool + Sync),
    complete: fn(Given) -> Given,
) -> Result<Vec<Trace>, Error> {
    let time = channels.time.as_deref();
    let (signals, parts) = parts(table, time, &|header| header.signals(channels), wanted)?;
    let each =
        |Part { id, columns, times_s }: Part| assemble(id, channels, &signals, complete(Given::of(columns, times_s)));
    parts.into_iter().map(each).collect()
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

/// Reads channels of each trace of a table; `rate_hz` stands for the time of a table without one.
pub fn series(
    table: &Table,
    (time, rate_hz): (Option<&str>, Option<f64>),
    channels: &[String],
) -> Result<Vec<Series>, Error> {
    let signals = |header: &Header| {
        // Of many columns each is looked up at once.
        let mut places: HashMap<&str, usize> = HashMap::new();
        for (place, name) in header.names.iter().enumerate() {
            places.entry(name).or_insert(place);
        }
        let parse = |channel: &String| match places.get(channel.as_str()) {
            Some(place) => Ok(Signal::Column(*place)),
            None => Signal::parse(channel, &header.names),
        };
        channels.iter().map(parse).collect()
    };
    let (signals, parts) = parts(table, time, &signals, &|_| true)?;
    let each = |part: Part| {
        let Part { id, columns, times_s } = part;
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

/// The names of the columns of a table that hold numbers, but for its time, and why others do not.
pub fn numeric(table: &Table, time: Option<&str>) -> Result<(Vec<String>, Vec<Error>), Error> {
    let header = header_of(table, time)?;
    if let Some(problem) = long_form(table) {
        return Err(Error::content(table.path(), "header", problem));
    }
    let own = |place: &usize| {
        Some(*place) != header.trace
            && Some(*place) != header.time()
            && !header.twins.contains(place)
            && header.fraction.is_none_or(|(fraction, _)| fraction != *place)
            && !header.names[*place].is_empty()
    };
    let places: Vec<usize> = (0..header.names.len()).filter(own).collect();
    let (mut kept, mut problems) = (Vec::new(), Vec::new());
    for (place, column) in places.iter().zip(table.read_each(&places)?) {
        match column {
            Ok(_) => kept.push(header.names[*place].clone()),
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

/// Whether a table has the columns of labels, or tells in which files signals are, and is no trace.
pub(crate) fn is_labels(table: &Table) -> bool {
    let has = |wanted: &str| table.names().iter().any(|name| name == wanted);
    has("trace") && has("class_name") || has("signal_id") && has("signal_file")
}

/// The columns of one trace.
struct Part {
    id: String,
    /// The columns that signals need, by their places in the file.
    columns: BTreeMap<usize, Vec<f64>>,
    times_s: Option<Vec<f64>>,
}

/// Number of rows, also where signals need no column.
fn rows_of(columns: &BTreeMap<usize, Vec<f64>>, times: Option<&[f64]>) -> usize {
    columns.values().next().map(Vec::len).or(times.map(<[f64]>::len)).unwrap_or(0)
}

/// Reads the columns of signals, one part for each trace.
fn parts(
    table: &Table,
    time: Option<&str>,
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
    let mut places: Vec<usize> = header.time().into_iter().chain(needed.iter().copied()).collect();
    if let Some((place, line)) = table.about().other_times.filter(|_| header.time.is_some()) {
        return Err(other_times(table, place, format!("line {line}")));
    }
    if let Some(name) = header.doubled(&places) {
        return Err(wrong(format!("column {name} comes twice; rename or remove one")));
    }
    // A table is read at once, so that its times are compared in all rows.
    let twins = if header.time.is_some() { &header.twins[..] } else { &[] };
    places.extend(twins);
    places.extend(header.fraction.map(|(place, _)| place));
    places.sort_unstable();
    places.dedup();
    let read = table.read(Wanted { numbers: &places, text: header.trace, row: &|cell| wanted(stem(cell)) });
    let mut columns = read.map_err(|problem| match (header.time(), problem) {
        // The time column was found by its name, not requested: the user can exclude it.
        (Some(own), Error::Content { path, place, problem })
            if time.is_none() && place.ends_with(&format!("column {}", header.names[own])) =>
        {
            Error::Content { path, place, problem: problem + "; --time none leaves the time out" }
        }
        (_, other) => other,
    })?;
    let of_place = |place: usize| places.binary_search(&place).ok().and_then(|at| columns.numbers.get(at));
    if let Some(times) = header.time().and_then(of_place) {
        for twin in twins {
            let row =
                of_place(*twin).and_then(|own| (0..own.len()).find(|row| own[*row].to_bits() != times[*row].to_bits()));
            if let Some(row) = row {
                return Err(other_times(table, *twin, columns.place(row)));
            }
        }
    }
    let rows = Rows::split(path, &columns, &id)?;
    report(table, &header, &rows, columns.numbers.first().map_or(0, Vec::len));
    let mut whole = Some(std::mem::take(&mut columns.numbers));
    let each = |rows: Rows| -> Result<Part, Error> {
        let own = match rows.rows {
            None => whole.take().unwrap_or_default(),
            Some(_) => whole.iter().flatten().map(|column| rows.of(column)).collect(),
        };
        let mut own: BTreeMap<usize, Vec<f64>> = places.iter().copied().zip(own).collect();
        own.retain(|place, _| !twins.contains(place) || needed.contains(place));
        let times_s = header.time.and_then(|(place, factor)| {
            let mut times = if needed.contains(&place) { own.get(&place).cloned() } else { own.remove(&place) }?;
            if factor != 1.0 {
                times.iter_mut().for_each(|t| *t *= factor);
            }
            if let Some((part, unit)) = header.fraction {
                let rest = own.get(&part)?;
                times.iter_mut().zip(rest).for_each(|(t, rest)| *t += rest * unit);
            }
            Some(times)
        });
        if let Some((place, unit)) = header.fraction {
            let is_wrong = |value: &f64| value.is_finite() && !is_below_a_second(*value, unit);
            let wrong = own.get(&place).and_then(|rest| rest.iter().position(is_wrong));
            if let Some(at) = wrong {
                let place = format!("{}, column {}", columns.place(rows.row(at)), header.names[place]);
                let problem = "more than a second, where the rows before have parts of one; name the time with --time";
                return Err(Error::content(path, place, problem));
            }
            own.retain(|own, _| *own != place || needed.contains(own));
        }
        let by_row = |step: f64| (0..rows_of(&own, None)).map(|row| row as f64 * step).collect();
        let mut times_s = times_s.or_else(|| table.about().step_s.filter(|_| time.is_none()).map(by_row));
        if let (Some(times), Some((place, factor))) = (&mut times_s, header.time) {
            let tick = table.about().ticks_s.iter().find(|(own, _)| *own == place).map_or(factor, |(_, tick)| *tick);
            let notes = [time::unwrapped(times, Some(tick)), time::evened(times)];
            notes.iter().flatten().for_each(|note| log::warn!("{}: {note}", path.display()));
        }
        let name = header.time().map_or("", |place| &header.names[place]);
        if times_s.as_ref().is_some_and(|times| !times.is_empty() && times.iter().all(|time| time.is_nan())) {
            let problem = "no row has a time; record it again, or leave the time out with --time none";
            return Err(Error::content(path, format!("column {name} of {}", rows.id), problem));
        }
        if let Some(known) = times_s.as_deref().filter(|times| header.time.is_some() && time::stands(times)) {
            let count = known.len();
            let problem = format!(
                "the time is the same in most of {count} rows, too coarse to tell the rate; export it with the parts of \
                 a second, or give --time none and --rate-hz"
            );
            return Err(Error::content(path, format!("column {name} of {}", rows.id), problem));
        }
        if let Some(at) = times_s.as_deref().and_then(time::backwards) {
            let place = format!("{}, column {name}", columns.place(rows.row(at)));
            return Err(Error::content(path, place, "time runs backwards; sort the rows or split the trace there"));
        }
        Ok(Part { id: rows.id, columns: own, times_s })
    };
    let parts = rows.into_iter().map(each).collect::<Result<_, Error>>()?;
    Ok((signals, parts))
}

/// A table whose channels have different times.
fn other_times(table: &Table, place: usize, line: String) -> Error {
    let at = format!("{line}, column {} {}", place + 1, table.names()[place]);
    let problem = "this channel has times of its own; export the channels with one time, or each in a file";
    Error::content(table.path(), at, problem)
}

/// Reports what is read of a file, and what was left out or guessed.
fn report(table: &Table, header: &Header, traces: &[Rows], rows: usize) {
    let (file, count) = (table.path().display(), traces.len());
    table.about().told().for_each(|told| log::warn!("{file}: {told}"));
    match header.time() {
        Some(time) => log::info!("read {file}: traces {count}, rows {rows}, time by column {}", header.names[time]),
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
