//! Traces recorded at the control rate, through the front end of the drive.

use crate::front_end::clean::{Clean, OWN, clean};
use crate::reader;
use crate::reader::assemble::{Rows, assemble};
use crate::reader::header::{Header, header_of};
use crate::signal::{self, Signal};
use crate::table::Table;
use model::Error;
use model::trace::front_end::FrontEndFile;
use model::trace::{Channels, Missing, Trace, same_interval};

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
    /// Signals of the columns behind the front end.
    signals: Vec<Signal>,
}

impl Wanted {
    /// Returns what the header lacks as an error.
    fn new(header: &Header, channels: &Channels, front_end: &FrontEndFile) -> Result<Self, String> {
        let own: Vec<String> = front_end.columns().into_iter().map(String::from).collect();
        if let Some(missing) = own.iter().find(|name| header.place(name).is_none()) {
            return Err(signal::missing(missing, header.names()));
        }
        let both = OWN.iter().map(ToString::to_string).chain(header.names().to_vec()).collect();
        let both = Header::of(both, Some(reader::NO_TIME), &crate::table::About::default())?;
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
        let signals = both.signals(channels)?;
        let signals = signals.iter().map(|signal| signal.at(&mut place)).collect();
        let time = header.time().map(|place| header.names()[place].clone());
        let timed = time.is_some();
        let names = further.iter().map(|column| both.names()[*column].clone());
        let all: Vec<String> = own.iter().cloned().chain(names).chain(time).collect();
        let first = &own[0];
        let Channels { time, rate_hz, .. } = channels.clone();
        let raw = Channels { further: all, time, rate_hz, ..Channels::new(first, first, first) };
        Ok(Self { raw, own: own.len(), further: further.len(), timed, signals })
    }
}

/// Whether the header of a table has every wanted column.
pub(crate) fn has_columns(table: &Table, channels: &Channels, front_end: &FrontEndFile) -> bool {
    let header = header_of(table, channels.time.as_deref());
    header.is_ok_and(|header| Wanted::new(&header, channels, front_end).is_ok())
}

/// Reads the wanted traces of one table.
pub(crate) fn read(
    table: &Table,
    channels: &Channels,
    front_end: &FrontEndFile,
    id: &(dyn Fn(&str) -> bool + Sync),
) -> Result<Vec<Trace>, Error> {
    let header = header_of(table, channels.time.as_deref())?;
    let wanted =
        Wanted::new(&header, channels, front_end).map_err(|problem| Error::content(table.path(), "header", problem))?;
    let mut traces = Vec::new();
    for raw in reader::read_as_recorded(table, &wanted.raw, id)? {
        traces.push(cleaned(&raw, channels, front_end, &wanted)?);
    }
    Ok(traces)
}

fn cleaned(raw: &Trace, channels: &Channels, front_end: &FrontEndFile, wanted: &Wanted) -> Result<Trace, Error> {
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
    let Clean { columns, refused, found_late, wiring } =
        clean(front_end, own, further, times).map_err(|problem| Error::trace(&raw.id, problem))?;
    let times: Vec<f64> = (0..columns[0].len()).map(|row| row as f64 * front_end.interval_s()).collect();
    // Rows before the first number are left out.
    let first = columns[0].iter().zip(&columns[1]).position(|(current, velocity)| (current + velocity).is_finite());
    let first = first.unwrap_or(0);
    let found_late = found_late.iter().map(|row| row.saturating_sub(first)).collect();
    let wiring = wiring.iter().map(|(row, known)| (row.saturating_sub(first), *known)).collect();
    let rows = Rows::of(columns.into_iter().enumerate().collect(), Some(times));
    let given = Channels { rate_hz: None, ..channels.clone() };
    let trace = assemble(raw.id.clone(), &given, &wanted.signals, rows)?;
    // The front end counts the samples that it refused.
    let missing = if refused.is_some() { Missing::default() } else { trace.missing };
    Ok(Trace { refused, missing, found_late, wiring, ..trace })
}
