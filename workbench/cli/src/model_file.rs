//! Model files with the workbench's notes, and traces prepared as a model requires.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::output;
use model::Error;
use model::core::Embedded;
use model::evaluate::{self, TraceVerdict};
use model::trace::labels::LabelledTrace;
use model::trace::{Channels, FrontEndFile, Preparation, ShaftChannels, Trace, same_interval};
use model::train::Trained;

/// Returns an error if the sampling rate of a trace differs from that of the model. The model's interval is the one
/// after the preparation on the host.
pub(super) fn check_rate<'a>(
    model: &Embedded,
    host: Preparation,
    traces: impl Iterator<Item = &'a Trace>,
) -> Result<(), Error> {
    let fed = f64::from(model.sampling().interval_s);
    let recorded = fed / host.factor()? as f64;
    for trace in traces {
        if let Some(step) = trace.interval_s.filter(|step| fed > 0.0 && !same_interval(*step, recorded)) {
            // Single precision prints without the digits of rounding errors.
            let (step, recorded) = (step as f32, recorded as f32);
            let problem = format!("sampled every {step} s, but the model wants {recorded} s; resample or train again");
            return Err(Error::trace(&trace.id, problem));
        }
    }
    Ok(())
}

/// Prepares every trace.
pub(super) fn prepare(traces: &[LabelledTrace], preparation: Preparation) -> Result<Vec<LabelledTrace>, Error> {
    let each = |t: &LabelledTrace| Ok(LabelledTrace { trace: preparation.apply(&t.trace)?, class: t.class });
    traces.iter().map(each).collect()
}

/// Runs prepared traces through a model, if their rate is its rate.
pub(super) fn judge(model: &Embedded, traces: &[LabelledTrace], host: Preparation) -> Result<Vec<TraceVerdict>, Error> {
    check_rate(model, host, traces.iter().map(|t| &t.trace))?;
    let bar = output::progress("evaluating", traces.len());
    let verdicts = evaluate::run(model, &prepare(traces, host)?, || bar.inc(1))?;
    bar.finish_and_clear();
    Ok(verdicts)
}

/// Notes in a model file for the workbench; the firmware ignores them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Notes {
    y: String,
    u1: String,
    u2: String,
    #[serde(default)]
    shaft: Option<ShaftChannels>,
    /// Columns that are used for their averages alone.
    #[serde(default)]
    further: Vec<String>,
    /// The time column and the rate of the recordings, if they were given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    time: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rate_hz: Option<f64>,
    /// The front end that the recordings pass.
    #[serde(default)]
    pub(super) front_end: Option<FrontEndFile>,
    /// The drive file that it was trained with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    drive: Option<String>,
    /// Preparation on the host, before the detector.
    host_block_mean: usize,
    decimate: usize,
    /// Names of the tracked orders.
    #[serde(default)]
    pub(super) orders: Vec<String>,
    /// Names of the features.
    pub(super) features: Vec<String>,
    /// Ids of the training traces, used to warn if the model is evaluated on them.
    pub(super) trained_on: Vec<String>,
    /// The units (drives) of the training traces, if they were given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) units: Vec<String>,
}

impl Notes {
    /// Of a model, the ids of the traces and the units with which it was trained.
    pub(super) fn new(
        channels: &Channels,
        host: Preparation,
        trained: &Trained,
        (trained_on, units): (Vec<String>, &[String]),
    ) -> Self {
        let mut units = units.to_vec();
        units.sort_unstable();
        units.dedup();
        let Channels { y, u1, u2, shaft, further, time, rate_hz, front_end } = channels.clone();
        Self {
            y,
            u1,
            u2,
            shaft,
            further,
            time,
            rate_hz,
            front_end,
            drive: super::drive::given(),
            host_block_mean: host.block_mean,
            decimate: host.decimate,
            orders: trained.recipe.catalogue().orders.unwrap_or_default(),
            features: trained.feature_names.clone(),
            trained_on,
            units,
        }
    }

    pub(super) fn channels(&self) -> Channels {
        Channels {
            shaft: self.shaft.clone(),
            further: self.further.clone(),
            time: self.time.clone(),
            rate_hz: self.rate_hz,
            front_end: self.front_end.clone(),
            ..Channels::new(&self.y, &self.u1, &self.u2)
        }
    }

    pub(super) fn preparation(&self) -> Preparation {
        Preparation { block_mean: self.host_block_mean.max(1), decimate: self.decimate.max(1) }
    }

    /// The drive file that the model was trained with.
    pub(super) fn drive(&self) -> Option<&str> {
        self.drive.as_deref()
    }

    pub(super) fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// Reads a model file.
pub(super) fn read_model(path: &Path) -> Result<(Embedded, Notes), Error> {
    of_bytes(path, &std::fs::read(path).map_err(Error::io(path))?)
}

/// Reads the bytes of a model file.
pub(super) fn of_bytes(path: &Path, bytes: &[u8]) -> Result<(Embedded, Notes), Error> {
    let wrong = |problem: bearing_watch::ModelError| {
        let remedy = match problem {
            bearing_watch::ModelError::Version { .. } => " with `bearing-watch train`",
            _ => "; train it again with `bearing-watch train`",
        };
        Error::content(path, "model", format!("{problem}{remedy}"))
    };
    let model = Embedded::from_bytes(bytes).map_err(wrong)?;
    let notes = bearing_watch::model::notes(bytes).map_err(wrong)?;
    let notes = serde_json::from_str(notes).map_err(|_| {
        Error::content(path, "notes", "no channel names in this model; train it again with `bearing-watch train`")
    })?;
    Ok((model, notes))
}
