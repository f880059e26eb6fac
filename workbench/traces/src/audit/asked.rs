//! What an audit is asked for.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use super::audited::Audited;
use crate::listing::labels::read_labels;
use crate::listing::{Candidate, Listing};
use crate::resample::unwrapped;
use model::Error;
use model::audit::orders::angle;
use model::outputs::folder_of;
use model::session::Log;
use model::settings::{Settings, TIMES, Use};

/// False-alarm rate of the smallest line.
const FALSE_ALARM: f64 = 0.01;

/// The settings that it takes.
pub const USE: Use = Use {
    name: "audit",
    keys: &[
        &["traces", "labels", "where", "healthy", "false_alarm"],
        TIMES,
        &["front_end", "current", "velocity", "velocity_ref", "angle", "load", "gear_ratio"],
    ],
    required: &[],
};

/// An audit: the recordings, the labels, and the channels that are looked at.
#[derive(Clone, Debug)]
pub struct Audit {
    /// The settings.
    pub settings: Settings,
}

impl Audit {
    /// Of one file, with the usual settings.
    #[must_use]
    pub fn usual(file: &Path) -> Self {
        let mut settings = Settings::default();
        settings.data.traces = vec![file.to_path_buf()];
        Self { settings }
    }

    /// Files and folders with the traces: those of the settings, or the folder of the labels.
    ///
    /// # Errors
    /// Neither is given, or a rate is out of range.
    pub fn paths(&self) -> Result<Vec<PathBuf>, Error> {
        let Settings { data, .. } = &self.settings;
        if !(1e-9..=0.5).contains(&self.false_alarm()) {
            return Err(Error::Usage("--false-alarm: give a rate from 1e-9 to 0.5".into()));
        }
        if data.labels.is_none() && (data.traces.is_empty() || !data.conditions.is_empty()) {
            let missing = if data.traces.is_empty() { "TRACES, or --labels" } else { "--labels, for --where" };
            return Err(Error::Usage(format!("the following required arguments were not provided: {missing}")));
        }
        let folder = data.labels.iter().map(|labels| folder_of(labels).to_path_buf());
        Ok(if data.traces.is_empty() { folder.collect() } else { data.traces.clone() })
    }

    /// The files that are audited, with the names that the labels give; what is left out is told.
    ///
    /// # Errors
    /// Those of [`Audit::paths`], and labels or folders that cannot be read.
    pub fn listing(&self, log: &Log<'_>) -> Result<Vec<Candidate>, Error> {
        let labels = self.settings.data.labels.as_deref().map(read_labels).transpose()?;
        let names = labels.map(|labels| labels.names());
        let listing = Listing::without_labels(&self.paths()?, names.as_ref())?;
        log.warn(listing.left_out.iter().cloned());
        Ok(listing.candidates)
    }

    /// The false-alarm rate of the smallest line.
    #[must_use]
    pub fn false_alarm(&self) -> f64 {
        self.settings.alarm.false_alarm.unwrap_or(FALSE_ALARM)
    }

    /// Rows a second of a trace.
    #[must_use]
    pub fn rate_of(&self, trace: &Audited, rotor: Option<f64>) -> Option<f64> {
        trace.times.map(|times| times.rate_hz).or(rotor).or(self.settings.data.rate_hz)
    }

    /// The current and the angle of the shaft, given or integrated.
    #[must_use]
    pub fn with_angle<'a>(&self, trace: &'a Audited, rotor: Option<f64>) -> Option<(&'a [f64], Vec<f64>)> {
        let y = trace.current.as_deref()?.as_slice();
        let integrated = || Some(angle(trace.velocity.as_deref()?, self.rate_of(trace, rotor)?));
        let angle = trace.angle.as_ref().map(|angle| unwrapped(angle, TAU)).or_else(integrated)?;
        Some((y, angle))
    }
}
