//! Recorded rows as a drive reads them, for firmware that replays a recording.
//!
//! ```text
//! file    "BWR1", number F of further channels (u32), rows
//! row     number (u32); counts of phases a, b, c (u16 each); flags (u16); angle (u32, 2⁻³² turn); F channels (f32)
//! flags   1: no angle; 2: no sensor of phase c; 4: a and b are the lower and upper half of a quadrature current (f32)
//! ```
//!
//! All numbers are little-endian.

use std::path::Path;

use bearing_watch::drive::{PhaseCounts, Position, RawSample};

use crate::front_end::clean::{is_sampled, raw_sample};
use crate::reader;
use crate::reader::header::header_of;
use crate::table::Table;
use model::Error;
use model::trace::Channels;
use model::trace::front_end::FrontEndFile;

/// Returns the rows of the only trace of a file, with the further channels in the given order.
///
/// # Errors
/// A file without these columns or with several traces; a front end that reads sine and cosine of a resolver.
pub fn raw_rows(path: &Path, front_end: &FrontEndFile, further: &[String]) -> Result<Vec<u8>, Error> {
    let table = Table::open(path)?;
    let header = header_of(&table, None)?;
    let own = front_end.columns();
    let timed = header.time().map(|place| header.names()[place].as_str());
    let names: Vec<String> =
        own.iter().copied().chain(further.iter().map(String::as_str)).chain(timed).map(String::from).collect();
    let channels = Channels { further: names, ..Channels::new(own[0], own[0], own[0]) };
    let traces = reader::read_as_recorded(&table, &channels, &|_| true)?;
    let [trace] = &traces[..] else {
        return Err(Error::content(path, "trace", "contains several traces; give a file of one"));
    };
    let columns: Vec<&[f64]> = trace.further.iter().map(Vec::as_slice).collect();
    let (recorded, rest) = columns.split_at(own.len());
    let (values, times) = rest.split_at(further.len());
    let mut bytes = b"BWR1".to_vec();
    bytes.extend(u32::try_from(further.len()).unwrap_or(u32::MAX).to_le_bytes());
    let times = times.first().copied();
    for row in (0..trace.y.len()).filter(|row| is_sampled(front_end, recorded, times, *row)) {
        let raw = raw_sample(front_end, recorded, values, times, row);
        put(&mut bytes, &raw, further.len()).map_err(|problem| Error::trace(&trace.id, problem))?;
    }
    Ok(bytes)
}

fn put<const F: usize>(bytes: &mut Vec<u8>, raw: &RawSample<F>, further: usize) -> Result<(), String> {
    let (counts, two) = match raw.currents {
        PhaseCounts::Three(counts) => (counts, 0_u16),
        PhaseCounts::Two([a, b]) => ([a, b, 0], 2),
        PhaseCounts::Quadrature(current_a) => {
            let [a, b, c, d] = current_a.to_le_bytes();
            ([u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]), 0], 4)
        }
    };
    let (angle, missing) = match raw.position {
        Position::Absolute(angle) => (angle.bits(), 0),
        Position::Missing => (0, 1),
        Position::Resolver { .. } => return Err("rows have an angle, not the sine and cosine of a resolver".into()),
    };
    bytes.extend(raw.number.to_le_bytes());
    counts.into_iter().chain([two | missing]).for_each(|word| bytes.extend(word.to_le_bytes()));
    bytes.extend(angle.to_le_bytes());
    raw.further.iter().take(further).for_each(|value| bytes.extend(value.to_le_bytes()));
    Ok(())
}
