//! Traces recorded at the control rate, through the front end of the drive.

use std::path::Path;

use super::csv_reader::{self, Collector, Header};
use super::front_end::{FrontEndFile, OWN, clean};
use super::{Channels, Trace, same_interval};
use crate::Error;

/// The recorded columns that a front end and the channels behind it need.
struct Wanted {
    /// Those of the front end first, then the further ones.
    raw: Channels,
    /// Number of columns that the front end reads.
    own: usize,
    /// Number of further columns.
    further: usize,
    /// Whether the last column is the time.
    timed: bool,
    /// Places in the columns behind the front end: plus, and minus of a difference.
    sources: Vec<(usize, Option<usize>)>,
}

impl Wanted {
    /// Returns the name of a channel that the header lacks.
    fn new(header: &Header, channels: &Channels, front_end: &FrontEndFile) -> Result<Self, String> {
        let own: Vec<String> = front_end.columns().into_iter().map(String::from).collect();
        if let Some(missing) = own.iter().find(|name| header.place(name).is_none()) {
            return Err(missing.clone());
        }
        let both = Header::of(OWN.iter().map(ToString::to_string).chain(header.names().to_vec()).collect());
        let mut further: Vec<usize> = Vec::new();
        let mut place = |column: usize| {
            if column < OWN.len() {
                return column;
            }
            let known = further.iter().position(|other| *other == column);
            OWN.len()
                + known.unwrap_or_else(|| {
                    further.push(column);
                    further.len() - 1
                })
        };
        let sources = both.sources(channels)?;
        let sources = sources.iter().map(|source| (place(source.plus), source.minus.map(&mut place))).collect();
        let timed = header.place("t_s").is_some();
        let names = further.iter().map(|column| both.names()[*column].clone());
        let all: Vec<String> = own.iter().cloned().chain(names).chain(timed.then(|| "t_s".into())).collect();
        let first = &own[0];
        let raw = Channels { further: all, ..Channels::new(first, first, first) };
        Ok(Self { raw, own: own.len(), further: further.len(), timed, sources })
    }
}

/// Whether the file can be read and its header has every wanted column.
pub(super) fn has_columns(path: &Path, channels: &Channels, front_end: &FrontEndFile) -> bool {
    csv_reader::header_of(path).is_ok_and(|header| Wanted::new(&header, channels, front_end).is_ok())
}

/// Reads the wanted traces of one file.
pub(super) fn read(
    path: &Path,
    channels: &Channels,
    front_end: &FrontEndFile,
    id: &dyn Fn(&str) -> bool,
) -> Result<Vec<Trace>, Error> {
    let header = csv_reader::header_of(path)?;
    let wanted = Wanted::new(&header, channels, front_end)
        .map_err(|missing| Error::content(path, "header", header.lacks(&missing)))?;
    let mut traces = Vec::new();
    for raw in csv_reader::read(path, &wanted.raw, id)? {
        traces.push(cleaned(path, &raw, channels, front_end, &wanted)?);
    }
    Ok(traces)
}

fn cleaned(
    path: &Path,
    raw: &Trace,
    channels: &Channels,
    front_end: &FrontEndFile,
    wanted: &Wanted,
) -> Result<Trace, Error> {
    let interval_s = 1.0 / f64::from(front_end.control_rate_hz);
    if let Some(step) = raw.interval_s.filter(|step| !same_interval(*step, interval_s)) {
        let (step, interval) = (step as f32, interval_s as f32);
        let problem = format!("recorded every {step} s, but the front end takes a row every {interval} s");
        return Err(Error::trace(&raw.id, problem));
    }
    let columns: Vec<&[f64]> = raw.further.iter().map(Vec::as_slice).collect();
    let (own, rest) = columns.split_at(wanted.own);
    let (further, times) = rest.split_at(wanted.further);
    let times = times.first().copied().filter(|_| wanted.timed);
    let clean = clean(front_end, own, further, times).map_err(|problem| Error::trace(&raw.id, problem))?;
    let mut collector = Collector::new(path, channels);
    for row in 0..clean.columns[0].len() {
        let value = |place: usize| clean.columns[place][row];
        let signal = |(plus, minus): &(usize, Option<usize>)| value(*plus) - minus.map_or(0.0, value);
        let values: Vec<f64> = wanted.sources.iter().map(signal).collect();
        let in_order = collector.push(Some(&raw.id), Some(row as f64 * front_end.interval_s()), &values);
        debug_assert!(in_order, "times grow");
    }
    let trace = collector.finish().pop().ok_or_else(|| Error::trace(&raw.id, "no samples"))?;
    Ok(Trace { refused: clean.refused, ..trace })
}
