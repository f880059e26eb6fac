//! Traces of files, for batch methods.

use std::path::PathBuf;

use crate::command_line::output;
use model::Error;
use model::session::{irregular, refuse_gaps};
use model::settings::Signals;
use model::trace::{Channels, Trace};

/// Reads traces, warns of those with irregular sampling, and refuses those with missing samples.
pub(crate) fn read(paths: &[PathBuf], channels: &Channels) -> Result<Vec<Trace>, Error> {
    let traces = read_with_gaps(paths, channels)?;
    complete(&traces)?;
    Ok(traces)
}

/// Reads traces, warns of those with irregular sampling, and refuses those of which a front end refused samples.
pub(crate) fn read_with_gaps(paths: &[PathBuf], channels: &Channels) -> Result<Vec<Trace>, Error> {
    let traces = traces::read(paths, channels)?;
    irregular(traces.iter()).iter().for_each(output::warn);
    traces.iter().filter(|trace| trace.refused.is_some()).try_for_each(refuse_gaps)?;
    Ok(traces)
}

/// Refuses traces with missing samples.
pub(crate) fn complete(traces: &[Trace]) -> Result<(), Error> {
    traces.iter().try_for_each(refuse_gaps)
}

/// A rate above zero.
pub(crate) fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse::<f64>().ok().filter(|rate| *rate > 0.0 && rate.is_finite());
    rate.ok_or_else(|| "give a number above 0".into())
}

/// Current, velocity and load, or their usual columns.
pub(crate) fn balanced(channels: &Signals) -> [String; 3] {
    let Signals { current, velocity, load, .. } = channels;
    let usual = [(current, "current_a"), (velocity, "velocity_rad_s"), (load, "load_torque_nm")];
    usual.map(|(given, usual)| given.clone().unwrap_or_else(|| usual.into()))
}
