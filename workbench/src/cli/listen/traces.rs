//! Blocks of samples → CSV files, one for each series without a gap.
//!
//! A file is complete or absent: it gets its name when its series has ended.

use std::path::{Path, PathBuf};

use bearing_watch::telemetry::Block;
use tempfile::NamedTempFile;

use super::names::Names;
use crate::Error;
use crate::cli::output;
use crate::trace::LARGEST;

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

/// The traces of a folder.
pub(super) struct Traces {
    folder: PathBuf,
    open: Option<Series>,
    /// Number of the next file, if that is free.
    number: u32,
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
        Ok(Self { folder: folder.into(), open: None, number: 0, samples: 0, files: 0, unusable: 0 })
    }

    /// Appends a block of the named stream; returns the files that it completes.
    pub(super) fn take(&mut self, stream: u32, names: &Names, block: &Block<'_>) -> Result<Vec<Written>, Error> {
        let mut written = Vec::new();
        for place in 0..block.len() {
            let number = block.first.wrapping_add(place as u32);
            let continues = |series: &Series| series.stream == stream && series.next == number;
            if !self.open.as_ref().is_some_and(continues) {
                written.extend(self.close()?);
            }
            let Some(values) = values(block, place) else {
                self.unusable += 1;
                written.extend(self.close()?);
                continue;
            };
            let mut series = match self.open.take() {
                Some(series) => series,
                None => self.start(stream, names, number)?,
            };
            let time = names.interval_s.map(|step| (series.samples as f64 * step).to_string());
            let row = time.into_iter().chain(values.iter().map(f64::to_string));
            series.writer.write_record(row).map_err(|error| self.error(&error))?;
            series.next = number.wrapping_add(1);
            series.samples += 1;
            self.open = Some(series);
        }
        Ok(written)
    }

    fn start(&self, stream: u32, names: &Names, first: u32) -> Result<Series, Error> {
        std::fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder))?;
        let file = output::temporary(&self.folder.join("trace"))?;
        let mut writer = csv::Writer::from_writer(file);
        let mut heading = names.channel_names();
        if names.interval_s.is_some() {
            heading.insert(0, "t_s");
        }
        if names.with_angle {
            heading.push("angle_rad");
        }
        writer.write_record(heading).map_err(|error| self.error(&error))?;
        Ok(Series { writer, stream, first, next: first, samples: 0 })
    }

    /// Completes the open file, if there is one.
    pub(super) fn close(&mut self) -> Result<Option<Written>, Error> {
        let Some(Series { writer, first, samples, .. }) = self.open.take() else { return Ok(None) };
        let named = Error::io(&self.folder);
        let mut file = match writer.into_inner() {
            Ok(file) => file,
            Err(error) => return Err(named(error.into_error())),
        };
        loop {
            let name = format!("trace_{:03}.csv", self.number);
            self.number += 1;
            match file.persist_noclobber(self.folder.join(&name)) {
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
