//! What an audit is asked for.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use super::audited::Audited;
use crate::jobs::Audit;
use crate::options::Taken;
use model::audit::orders::angle;
use model::settings::Settings;
use traces::resample::unwrapped;

/// What recordings are worth: rate, gaps, held and saturated samples, lags, equal traces, the smallest line of an order
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Ends with exit code 1 if it finds something.\n\nExample:\n  bearing-watch audit drive.toml --json"
)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) taken: Taken<Audit>,
    /// Write a page with signals, spectra over orders and the smallest lines
    #[arg(long, value_name = "FILE")]
    pub(super) report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// False-alarm rate of the smallest line.
const FALSE_ALARM: f64 = 0.01;

impl Args {
    /// Of one file, with the usual settings.
    pub(super) fn usual(file: &Path) -> Self {
        let mut settings = Settings::default();
        settings.data.traces = vec![file.to_path_buf()];
        Self { taken: Taken::of(settings), report: None, json: false }
    }

    pub(super) fn false_alarm(&self) -> f64 {
        self.taken.settings.alarm.false_alarm.unwrap_or(FALSE_ALARM)
    }

    pub(super) fn rate_of(&self, trace: &Audited, rotor: Option<f64>) -> Option<f64> {
        trace.times.map(|times| times.rate_hz).or(rotor).or(self.taken.settings.data.rate_hz)
    }

    /// The current and the angle of the shaft, given or integrated.
    pub(super) fn with_angle<'a>(&self, trace: &'a Audited, rotor: Option<f64>) -> Option<(&'a [f64], Vec<f64>)> {
        let y = trace.current.as_deref()?;
        let integrated = || Some(angle(trace.velocity.as_deref()?, self.rate_of(trace, rotor)?));
        let angle = trace.angle.as_ref().map(|angle| unwrapped(angle, TAU)).or_else(integrated)?;
        Some((y, angle))
    }
}
