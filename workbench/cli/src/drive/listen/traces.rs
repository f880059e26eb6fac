//! Blocks of samples and of raw samples → CSV files, one for each series without a gap.
//!
//! A file is complete or absent: it gets its name when its series has ended.

use std::borrow::Cow;
use std::fs::File;
use std::path::{Path, PathBuf};

use bearing_watch::telemetry::{Block, RawBlock};
use tempfile::{NamedTempFile, PersistError};

use super::names::Names;
use super::raw;
use crate::command_line::output;
use model::Error;
use model::outputs::cell;
use traces::LARGEST;

/// A written file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Written {
    pub(super) file: String,
    /// Number of its first sample.
    pub(super) first: u32,
    pub(super) samples: u64,
}

/// A series whose end has not come.
struct Series {
    writer: csv::Writer<NamedTempFile>,
    stream: u32,
    first: u32,
    /// Number of the sample that continues it.
    next: u32,
    samples: u64,
}

/// The files of one kind of samples.
struct Track {
    /// What their names start with.
    prefix: &'static str,
    open: Option<Series>,
    /// Number of the next file, if that is free.
    number: u32,
}

/// What the columns of a block are, and how far its samples are apart.
struct Heading {
    stream: u32,
    interval_s: Option<f64>,
    columns: Vec<String>,
}

/// The traces of a folder.
pub(super) struct Traces {
    folder: PathBuf,
    own: Track,
    raw: Track,
    pub(super) samples: u64,
    pub(super) files: u32,
    /// Samples that are no numbers, or larger than any measured value.
    pub(super) unusable: u64,
}

impl Traces {
    pub(super) fn new(folder: &Path) -> Result<Self, Error> {
        if folder.exists() && !folder.is_dir() {
            return Err(Error::Usage(format!("--out {} is a file; name a folder", folder.display())));
        }
        let track = |prefix| Track { prefix, open: None, number: 0 };
        Ok(Self { folder: folder.into(), own: track("trace"), raw: track("raw"), samples: 0, files: 0, unusable: 0 })
    }

    /// Appends a block of the named stream; returns the files that it completes.
    pub(super) fn take(&mut self, stream: u32, names: &Names, block: &Block<'_>) -> Result<Vec<Written>, Error> {
        let mut columns: Vec<String> = names.channel_names().into_iter().map(String::from).collect();
        columns.extend(names.with_angle.then(|| "angle_rad".into()));
        let heading = Heading { stream, interval_s: names.interval_s, columns };
        self.append(|traces| &mut traces.own, &heading, (block.first, block.len()), |place| values(block, place))
    }

    /// Appends a block of raw samples, with the names of their further channels.
    pub(super) fn take_raw(
        &mut self,
        stream: u32,
        further: &[String],
        block: &RawBlock<'_>,
    ) -> Result<Vec<Written>, Error> {
        let heading = Heading {
            stream,
            interval_s: Some(1.0 / f64::from(block.control_rate_hz)),
            columns: raw::columns(block, further),
        };
        self.append(
            |traces| &mut traces.raw,
            &heading,
            (block.first, block.len()),
            |place| Some(raw::values(block, place)),
        )
    }

    /// Appends the samples of a block; one without values is unusable.
    fn append(
        &mut self,
        track: fn(&mut Self) -> &mut Track,
        heading: &Heading,
        (first, samples): (u32, usize),
        values: impl Fn(usize) -> Option<Vec<f64>>,
    ) -> Result<Vec<Written>, Error> {
        let mut written = Vec::new();
        for place in 0..samples {
            let number = first.wrapping_add(place as u32);
            let continues = |series: &Series| series.stream == heading.stream && series.next == number;
            if !track(self).open.as_ref().is_some_and(continues) {
                written.extend(self.end(track)?);
            }
            let Some(values) = values(place) else {
                self.unusable += 1;
                written.extend(self.end(track)?);
                continue;
            };
            let mut series = match track(self).open.take() {
                Some(series) => series,
                None => self.start(heading, number)?,
            };
            let time = heading.interval_s.map(|step| (series.samples as f64 * step).to_string());
            let row = time.into_iter().chain(values.iter().map(f64::to_string));
            series.writer.write_record(row).map_err(|error| self.error(&error))?;
            series.next = number.wrapping_add(1);
            series.samples += 1;
            track(self).open = Some(series);
        }
        Ok(written)
    }

    fn start(&self, heading: &Heading, first: u32) -> Result<Series, Error> {
        std::fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder))?;
        let file = output::temporary(&self.folder.join("trace"))?;
        let mut writer = csv::Writer::from_writer(file);
        let time = heading.interval_s.map(|_| "t_s");
        let names = time.into_iter().chain(heading.columns.iter().map(String::as_str)).map(cell);
        writer.write_record(names.map(Cow::into_owned)).map_err(|error| self.error(&error))?;
        Ok(Series { writer, stream: heading.stream, first, next: first, samples: 0 })
    }

    /// Completes the open files.
    pub(super) fn close(&mut self) -> Result<Vec<Written>, Error> {
        let own = self.end(|traces| &mut traces.own)?;
        let raw = self.end(|traces| &mut traces.raw)?;
        Ok(own.into_iter().chain(raw).collect())
    }

    /// Completes the open file of a track, if there is one.
    fn end(&mut self, track: fn(&mut Self) -> &mut Track) -> Result<Option<Written>, Error> {
        let Some(Series { writer, first, samples, .. }) = track(self).open.take() else { return Ok(None) };
        let folder = self.folder.clone();
        let named = Error::io(&folder);
        let mut file = match writer.into_inner() {
            Ok(file) => file,
            Err(error) => return Err(named(error.into_error())),
        };
        loop {
            let Track { prefix, number, .. } = track(self);
            let name = format!("{prefix}_{number:03}.csv");
            *number += 1;
            match persist(file, &folder.join(&name)) {
                Ok(_) => {
                    self.files += 1;
                    self.samples += samples;
                    return Ok(Some(Written { file: name, first, samples }));
                }
                Err(taken) if taken.error.kind() == std::io::ErrorKind::AlreadyExists => file = taken.file,
                Err(failed) => return Err(named(failed.error)),
            }
        }
    }

    fn error(&self, error: &csv::Error) -> Error {
        Error::Usage(format!("{}: {error}", self.folder.display()))
    }
}

/// Gives a file its name, unless another one has it.
#[cfg(not(target_family = "wasm"))]
fn persist(file: NamedTempFile, place: &Path) -> Result<File, PersistError> {
    file.persist_noclobber(place)
}

/// The same without links: in a browser no other program takes the name meanwhile.
#[cfg(target_family = "wasm")]
fn persist(file: NamedTempFile, place: &Path) -> Result<File, PersistError> {
    if place.exists() {
        return Err(PersistError { error: std::io::ErrorKind::AlreadyExists.into(), file });
    }
    file.persist(place)
}

/// A count of the angle, rad.
const COUNT: f64 = std::f64::consts::TAU / 4_294_967_296.0;

/// The values of a sample, and its angle; `None` if a value cannot be in a trace. The decimals of each are those of
/// double precision, so that reading them gives the same bits.
fn values(block: &Block<'_>, place: usize) -> Option<Vec<f64>> {
    let channels = usize::from(block.channels);
    let mut values: Vec<f64> = (0..channels).map_while(|channel| block.value(place, channel)).map(f64::from).collect();
    // The middle of a count, which no rounding leads out of it.
    values.extend(block.angle(place).map(|angle| (f64::from(angle.bits()) + 0.5) * COUNT));
    values.iter().all(|value| value.abs() <= LARGEST).then_some(values)
}
