//! Traces in CSV format: one file per trace, or a tidy table with a `trace` column.

use std::collections::HashMap;
use std::path::Path;

use super::{Channels, MotionTrace, ShaftChannels, Trace, stem};
use crate::Error;

/// Column of one signal: `plus`, or the difference `plus` − `minus`.
#[derive(Clone, Copy)]
pub(super) struct Source {
    pub(super) plus: usize,
    pub(super) minus: Option<usize>,
}

/// The names of the columns.
pub(super) struct Header {
    names: Vec<String>,
    trace: Option<usize>,
    time: Option<usize>,
}

impl Header {
    fn new(record: &csv::StringRecord) -> Self {
        Self::of(record.iter().map(|name| name.trim().trim_start_matches('\u{feff}').into()).collect())
    }

    pub(super) fn of(names: Vec<String>) -> Self {
        let find = |wanted: &str| names.iter().position(|name| name == wanted);
        Self { trace: find("trace"), time: find("t_s"), names }
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    pub(super) fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|column| column == name)
    }

    /// Reason why the header does not contain a channel.
    pub(super) fn lacks(&self, channel: &str) -> String {
        let wrong_separator = self.names.iter().find_map(|name| name.chars().find(|c| matches!(c, ';' | '\t')));
        match wrong_separator {
            _ if self.names.iter().all(String::is_empty) => "the file is empty".into(),
            Some(';') => "cells are separated by semicolons; write commas, and decimals with a point".into(),
            Some(_) => "cells are separated by tabs; write commas".into(),
            None => {
                format!("no column (or difference of columns) {channel}; there are {}", self.names.join(", "))
            }
        }
    }

    /// A wanted column whose name occurs twice.
    fn doubled(&self, sources: &[Source]) -> Option<&str> {
        let wanted = sources.iter().flat_map(|source| [Some(source.plus), source.minus]).flatten();
        let wanted = wanted.chain(self.trace).chain(self.time);
        let name_of = wanted.map(|place| self.names[place].as_str());
        let count = |name: &str| self.names.iter().filter(|other| *other == name).count();
        name_of.into_iter().find(|name| count(name) > 1)
    }

    /// A column with the whole name takes precedence over a difference, since names may contain a dash.
    fn source(&self, channel: &str) -> Option<Source> {
        if let Some(plus) = self.place(channel) {
            return Some(Source { plus, minus: None });
        }
        channel.match_indices('-').find_map(|(at, _)| {
            let (plus, minus) = (self.place(channel[..at].trim())?, self.place(channel[at + 1..].trim())?);
            Some(Source { plus, minus: Some(minus) })
        })
    }

    /// Sources of y, u1, u2, of the further columns, and, if the shaft is watched, of current and angle, and of
    /// velocity, load and reference if they are given.
    pub(super) fn sources(&self, channels: &Channels) -> Result<Vec<Source>, String> {
        let find = |channel: &String| self.source(channel).ok_or_else(|| channel.clone());
        let shaft = channels.shaft.iter().flat_map(|shaft| {
            let ShaftChannels { current, velocity, load, angle, reference } = shaft;
            [current, angle].into_iter().chain(velocity).chain(load).chain(reference)
        });
        [&channels.y, &channels.u1, &channels.u2].into_iter().chain(&channels.further).chain(shaft).map(find).collect()
    }
}

fn open(path: &Path) -> Result<csv::Reader<std::fs::File>, Error> {
    let file = std::fs::File::open(path).map_err(Error::io(path))?;
    Ok(csv::ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(file))
}

pub(super) fn csv_error(path: &Path, error: &csv::Error) -> Error {
    let line = error.position().map_or_else(|| "content".into(), |p| format!("line {}", p.line()));
    Error::content(path, line, format!("not readable as CSV: {}", describe(error)))
}

pub(super) fn describe(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "the text is not UTF-8".into(),
        csv::ErrorKind::Io(io) => io.to_string(),
        _ => error.to_string(),
    }
}

fn header(path: &Path, reader: &mut csv::Reader<std::fs::File>) -> Result<Header, Error> {
    Ok(Header::new(reader.headers().map_err(|e| csv_error(path, &e))?))
}

/// The names of the columns of a file.
pub(super) fn header_of(path: &Path) -> Result<Header, Error> {
    header(path, &mut open(path)?)
}

/// Whether the file can be read and its header has every wanted column.
pub(super) fn has_columns(path: &Path, channels: &Channels) -> bool {
    header_of(path).is_ok_and(|header| header.sources(channels).is_ok())
}

/// Reads the wanted traces of one file; only the wanted columns must be numeric.
pub(super) fn read(path: &Path, channels: &Channels, wanted: &dyn Fn(&str) -> bool) -> Result<Vec<Trace>, Error> {
    let mut reader = open(path)?;
    let header = header(path, &mut reader)?;
    let mut collector = Collector::new(path, channels);
    if header.trace.is_none() && !wanted(stem(&collector.file_id)) {
        return Ok(vec![]);
    }
    let sources = header.sources(channels).map_err(|missing| Error::content(path, "header", header.lacks(&missing)))?;
    if let Some(name) = header.doubled(&sources) {
        return Err(Error::content(path, "header", format!("column {name} comes twice; rename or remove one")));
    }
    let mut rows = 0;
    for record in reader.records() {
        let record = record.map_err(|e| csv_error(path, &e))?;
        let row = Row { path, header: &header, record: &record };
        row.check_width()?;
        rows += 1;
        let id = header.trace.map(|column| &record[column]);
        if id.is_some_and(|id| !wanted(stem(id))) {
            continue;
        }
        let time = header.time.map(|column| row.number(column)).transpose()?;
        let mut values = vec![0.0; sources.len()];
        for (value, source) in values.iter_mut().zip(&sources) {
            *value = row.number(source.plus)?;
            if let Some(minus) = source.minus {
                *value -= row.number(minus)?;
            }
        }
        if id.is_some_and(str::is_empty) {
            let place = format!("line {}, column trace", row.line());
            return Err(Error::content(path, place, "no trace id; fill it in or remove the row"));
        }
        if !collector.push(id, time, &values) {
            let place = format!("line {}, column t_s", row.line());
            return Err(Error::content(path, place, "time runs backwards; sort the rows or split the trace there"));
        }
    }
    if rows == 0 {
        return Err(Error::content(path, "line 2", "no rows after the header; record the trace again"));
    }
    Ok(collector.finish())
}

/// No sensor measures larger values in any unit; their squares and products would overflow single precision.
pub(crate) const LARGEST: f64 = 1e15;

struct Row<'a> {
    path: &'a Path,
    header: &'a Header,
    record: &'a csv::StringRecord,
}

impl Row<'_> {
    fn line(&self) -> u64 {
        self.record.position().map_or(0, csv::Position::line)
    }

    fn check_width(&self) -> Result<(), Error> {
        let (found, wanted) = (self.record.len(), self.header.names.len());
        if found == wanted {
            return Ok(());
        }
        let problem = format!(
            "{found} cells where the header has {wanted}; complete the row or remove it (decimals take a point)"
        );
        Err(Error::content(self.path, format!("line {}", self.line()), problem))
    }

    fn number(&self, column: usize) -> Result<f64, Error> {
        let (cell, name) = (&self.record[column], &self.header.names[column]);
        let wrong =
            |problem: String| Error::content(self.path, format!("line {}, column {name}", self.line()), problem);
        match cell.parse::<f64>() {
            Ok(value) if value.abs() <= LARGEST => Ok(value),
            Ok(value) if value.is_finite() => Err(wrong(format!("{cell} is no measured value; repair the sample"))),
            Ok(_) => Err(wrong(format!("{cell} is not a finite number; cut the trace there or repair the sample"))),
            Err(_) if cell.is_empty() => Err(wrong("empty cell; cut the trace there or repair the sample".into())),
            Err(_) => Err(wrong(format!("\"{cell}\" is not a number (write decimals with a point)"))),
        }
    }
}

/// Collects rows by trace id, in the order of the first occurrence of each id.
pub(super) struct Collector {
    file_id: String,
    /// Number of further columns.
    further: usize,
    /// Whether the shaft's velocity and its load are measured.
    velocity: bool,
    load: bool,
    places: HashMap<String, usize>,
    traces: Vec<(Trace, Vec<f64>)>,
}

impl Collector {
    pub(super) fn new(path: &Path, channels: &Channels) -> Self {
        let file_id = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let has = |pick: fn(&ShaftChannels) -> &Option<String>| {
            channels.shaft.as_ref().is_some_and(|own| pick(own).is_some())
        };
        let (velocity, load) = (has(|own| &own.velocity), has(|own| &own.load));
        Self { file_id, further: channels.further.len(), velocity, load, places: HashMap::new(), traces: Vec::new() }
    }

    /// Adds a row; returns `false` if its time is before that of the previous row.
    pub(super) fn push(&mut self, id: Option<&str>, time: Option<f64>, values: &[f64]) -> bool {
        let id = id.unwrap_or(&self.file_id);
        let place = self.places.get(id).copied().unwrap_or_else(|| {
            let id_of = id.into();
            let trace = Trace { id: id_of, further: vec![vec![]; self.further], ..Trace::default() };
            self.traces.push((trace, vec![]));
            self.places.insert(id.into(), self.traces.len() - 1);
            self.traces.len() - 1
        });
        let (trace, times) = &mut self.traces[place];
        let (signals, rest) = values.split_at(3);
        let (further, shaft) = rest.split_at(self.further);
        for (column, value) in trace.further.iter_mut().zip(further) {
            column.push(*value);
        }
        for (column, value) in [&mut trace.y, &mut trace.u1, &mut trace.u2].into_iter().zip(signals) {
            column.push(*value);
        }
        if let [current, angle, rest @ ..] = shaft {
            let (velocity, rest) = rest.split_at(usize::from(self.velocity));
            let (load, reference) = rest.split_at(usize::from(self.load));
            let one = |measured: &[f64]| measured.first().copied().unwrap_or(0.0);
            let motion = trace.motion.get_or_insert_with(MotionTrace::default);
            motion.current_a.push(*current);
            motion.angle_rad.push(*angle);
            motion.velocity_rad_s.push(one(velocity));
            motion.load_nm.push(one(load));
            motion.reference_rad_s.extend(reference);
        }
        let forward = times.last().zip(time).is_none_or(|(before, now)| now >= *before);
        times.extend(time);
        forward
    }

    pub(super) fn finish(self) -> Vec<Trace> {
        let finish = |(mut trace, times): (Trace, Vec<f64>)| {
            let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
            steps.sort_by(f64::total_cmp);
            trace.interval_s = steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0);
            let median = trace.interval_s.unwrap_or(0.0);
            trace.irregular_steps = steps.iter().filter(|step| (*step - median).abs() > 0.1 * median).count();
            trace
        };
        self.traces.into_iter().map(finish).collect()
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

    fn message(content: &str) -> String {
        read(file(content).path(), &channels(), &|_| true).expect_err("bad input").to_string()
    }

    #[test]
    fn single_file_with_difference_and_dashed_name() {
        let f = file("t_s,i,ref,v,load-cell,comment\n0,1,10,4,7,start\n0.5,2,11,4,8,\n");
        let traces = read(f.path(), &channels(), &|_| true).expect("good file");
        assert_eq!(traces.len(), 1);
        assert_eq!((traces[0].y.clone(), traces[0].u1.clone()), (vec![1.0, 2.0], vec![6.0, 7.0]));
        assert_eq!((traces[0].u2.clone(), traces[0].interval_s), (vec![7.0, 8.0], Some(0.5)));
    }

    #[test]
    fn tidy_table_keeps_first_appearance_order() {
        let f = file("trace,i,ref,v,load-cell\nb,1,0,0,0\na,2,0,0,0\nb,3,0,0,0\n");
        let traces = read(f.path(), &channels(), &|_| true).expect("good file");
        let ids: Vec<_> = traces.iter().map(|t| t.id.as_str()).collect();
        assert_eq!((ids, traces[0].y.clone()), (vec!["b", "a"], vec![1.0, 3.0]));
    }

    #[test]
    fn bad_content_names_line_and_column() {
        let good = "t_s,i,ref,v,load-cell\n0,1,2,3,4\n";
        assert!(message("t_s,i,ref,v\n0,1,2,3\n").contains("header: no column (or difference of columns) load-cell"));
        assert!(message(&format!("{good}0,1,2\n")).contains("line 3: 3 cells where the header has 5"));
        assert!(message(&format!("{good}0,x,2,3,4\n")).contains("line 3, column i: \"x\" is not a number"));
        assert!(message(&format!("{good}0,1,NaN,3,4\n")).contains("line 3, column ref: NaN is not a finite"));
        assert!(message(&format!("{good}0,1,2,inf,4\n")).contains("column v: inf is not a finite"));
        assert!(message(&format!("{good}0,1,2,,4\n")).contains("column v: empty cell"));
        assert!(message("t_s,i,ref,v,load-cell\n").contains("no rows"));
        assert!(message(&format!("{good}0,1e300,2,3,4\n")).contains("column i: 1e300 is no measured value"));
        assert!(message(&format!("{good}-1,1,2,3,4\n")).contains("line 3, column t_s: time runs backwards"));
        assert!(message("t_s;i;ref;v;load-cell\n0;1;2;3;4\n").contains("separated by semicolons"));
        assert!(message("i,ref,v,load-cell,i\n1,2,3,4,5\n").contains("column i comes twice"));
        assert!(message("").contains("the file is empty"));
        assert!(message("trace,i,ref,v,load-cell\n,1,2,3,4\n").contains("line 2, column trace: no trace id"));
    }
}
