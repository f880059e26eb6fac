//! Options that several commands share.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::{Deserialize, Serialize};

use super::output;
use crate::Error;
use crate::embedded::Embedded;
use crate::identify::{Order, Structure, parse_order};
use crate::trace::labels::LabelledTrace;
use crate::trace::{self, Channels, Condition, Labels, Preparation, ShaftChannels, Trace, same_interval};
use crate::train::Validation;

/// Which columns are the three signals.
#[derive(Clone, Debug, Args)]
pub(super) struct ChannelArgs {
    /// Output: a column, or a difference a-b of two (as a rule the quadrature current)
    #[arg(long, value_name = "CHANNEL")]
    y: String,
    /// First input (reference, or reference-measured, of the controlled variable)
    #[arg(long, value_name = "CHANNEL")]
    u1: String,
    /// Second input (load)
    #[arg(long, value_name = "CHANNEL")]
    u2: String,
}

impl ChannelArgs {
    pub(super) fn channels(&self) -> Channels {
        Channels::new(&self.y, &self.u1, &self.u2)
    }
}

/// Traces, and which of their columns are the three signals.
#[derive(Clone, Debug, Args)]
pub(super) struct TraceArgs {
    /// Trace files or folders
    #[arg(value_name = "TRACES", required = true)]
    pub(super) traces: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) channels: ChannelArgs,
}

impl TraceArgs {
    /// Reads them, and warns of those that are sampled irregularly.
    pub(super) fn read(&self) -> Result<Vec<Trace>, Error> {
        let traces = trace::read(&self.traces, &self.channels.channels())?;
        warn_irregular(traces.iter());
        Ok(traces)
    }
}

/// The model structure.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct StructureArgs {
    /// na,nb,nc,nkb,nkc
    #[arg(long, value_parser = parse_order, value_name = "ORDER")]
    order: Order,
    /// Estimate a constant term too (recorded signals have operating points)
    #[arg(long)]
    offset: bool,
}

impl StructureArgs {
    pub(super) fn structure(self) -> Structure {
        Structure { order: self.order, offset: self.offset }
    }
}

/// What is done to traces before identification.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct PreparationArgs {
    /// Average blocks of N samples first
    #[arg(long, value_name = "N", default_value_t = 1)]
    block_mean: usize,
    /// Then keep every N-th sample behind an anti-alias filter
    #[arg(long, value_name = "N", default_value_t = 1)]
    decimate: usize,
}

impl PreparationArgs {
    pub(super) fn preparation(self) -> Result<Preparation, Error> {
        let preparation = Preparation { block_mean: self.block_mean, decimate: self.decimate };
        preparation.factor().map(|_| preparation)
    }
}

/// Which labelled traces take part.
#[derive(Clone, Debug, Args)]
pub(super) struct SelectionArgs {
    /// Trace files or folders; without any, the folder of the labels
    #[arg(value_name = "TRACES")]
    traces: Vec<PathBuf>,
    /// CSV with columns trace,class_name and any further ones to select by
    #[arg(long, value_name = "FILE")]
    pub(super) labels: PathBuf,
    /// Only rows with this, e.g. load_kgf=20; may be repeated, all must hold
    #[arg(long = "where", value_name = "CONDITION")]
    conditions: Vec<Condition>,
    /// Only these classes, in this order
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = trimmed)]
    classes: Vec<String>,
}

fn trimmed(text: &str) -> Result<String, std::convert::Infallible> {
    Ok(text.trim().into())
}

/// Labels, and where their traces are.
#[derive(Debug)]
pub(super) struct Selection {
    labels: Labels,
    paths: Vec<PathBuf>,
    channels: Channels,
    conditions: Vec<Condition>,
    asked: Vec<String>,
}

impl SelectionArgs {
    pub(super) fn read(&self, channels: &Channels) -> Result<Selection, Error> {
        let folder = self.labels.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Ok(Selection {
            labels: Labels::read(&self.labels)?,
            paths: if self.traces.is_empty() { vec![folder.to_path_buf()] } else { self.traces.clone() },
            channels: channels.clone(),
            conditions: self.conditions.clone(),
            asked: self.classes.clone(),
        })
    }
}

impl Selection {
    /// Files that are read: no output may replace them.
    pub(super) fn inputs(&self, labels: &Path) -> Vec<PathBuf> {
        [&self.paths[..], &[labels.to_path_buf()]].concat()
    }

    /// The rows that meet the common and these further conditions: class names and traces.
    pub(super) fn rows(&self, further: &[Condition]) -> Result<(Vec<String>, Vec<LabelledTrace>), Error> {
        let conditions = [&self.conditions, further].concat();
        let chosen = self.labels.select(&conditions)?;
        let classes = self.labels.classes(&chosen, &self.asked)?;
        let wanted: std::collections::HashSet<&str> =
            chosen.iter().filter(|(_, name)| classes.contains(name)).map(|(id, _)| id.as_str()).collect();
        let traces = trace::read_wanted(&self.paths, &self.channels, &|id| wanted.contains(id))?;
        let traces = self.labels.join(&chosen, &classes, &traces)?;
        Ok((classes, traces))
    }
}

/// How training judges itself.
#[derive(Clone, Debug, Args)]
pub(super) struct ValidationArgs {
    /// Folds of the cross-validation
    #[arg(long, value_name = "N", default_value_t = 10)]
    folds: usize,
    /// Keep traces with the same value in this column of the labels in one fold, e.g. run
    #[arg(long, value_name = "COLUMN")]
    group: Option<String>,
    /// Seed of the split into folds
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    fold_seed: u64,
}

impl ValidationArgs {
    pub(super) fn validation(&self, selection: &Selection, traces: &[LabelledTrace]) -> Result<Validation, Error> {
        if self.folds < 2 {
            return Err(Error::Usage(format!("--folds {}: at least 2", self.folds)));
        }
        let ids = || traces.iter().map(|t| t.trace.id.as_str());
        let groups = self.group.as_ref().map(|column| selection.labels.cells(column, ids()));
        Ok(Validation { folds: self.folds, seed: self.fold_seed, groups: groups.transpose()?.unwrap_or_default() })
    }
}

/// Warns of traces whose samples do not come at a constant rate.
pub(super) fn warn_irregular<'a>(traces: impl Iterator<Item = &'a Trace> + Clone) {
    let irregular = traces.clone().filter(|trace| 50 * trace.irregular_steps > trace.y.len());
    let count = irregular.clone().count();
    if let Some(first) = irregular.clone().next() {
        output::warn(format!(
            "{count} of {} traces are sampled irregularly (more than 2 % of the steps off by a tenth), first {}; resample them",
            traces.count(),
            first.id
        ));
    }
}

/// Refuses traces of another rate than the model's. What an interval in the model means is after the preparation on
/// the host.
pub(super) fn check_rate<'a>(
    model: &Embedded,
    host: Preparation,
    traces: impl Iterator<Item = &'a Trace>,
) -> Result<(), Error> {
    let fed = f64::from(model.sampling().interval_s);
    let recorded = fed / host.factor()? as f64;
    for trace in traces {
        if let Some(step) = trace.interval_s.filter(|step| fed > 0.0 && !same_interval(*step, recorded)) {
            // Single precision prints without the digits that rounding has made.
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

/// What a model file says of itself to the workbench; the firmware ignores it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Notes {
    y: String,
    u1: String,
    u2: String,
    #[serde(default)]
    shaft: Option<ShaftChannels>,
    /// Preparation outside the detector.
    host_block_mean: usize,
    decimate: usize,
    /// Names of the tracked orders.
    #[serde(default)]
    pub(super) orders: Vec<String>,
    /// Names of the features.
    pub(super) features: Vec<String>,
    /// Ids of the training traces, to warn of evaluating on them.
    pub(super) trained_on: Vec<String>,
}

impl Notes {
    pub(super) fn new(
        channels: &Channels,
        host: Preparation,
        (features, orders): (&[String], Vec<String>),
        training: &[LabelledTrace],
    ) -> Self {
        let Channels { y, u1, u2, shaft } = channels.clone();
        Self {
            y,
            u1,
            u2,
            shaft,
            host_block_mean: host.block_mean,
            decimate: host.decimate,
            orders,
            features: features.to_vec(),
            trained_on: training.iter().map(|t| trace::stem(&t.trace.id).to_string()).collect(),
        }
    }

    pub(super) fn channels(&self) -> Channels {
        Channels { shaft: self.shaft.clone(), ..Channels::new(&self.y, &self.u1, &self.u2) }
    }

    pub(super) fn preparation(&self) -> Preparation {
        Preparation { block_mean: self.host_block_mean.max(1), decimate: self.decimate.max(1) }
    }

    pub(super) fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// Reads a model file.
pub(super) fn read_model(path: &Path) -> Result<(Embedded, Notes), Error> {
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    let wrong = |problem: bearing_watch::ModelError| {
        Error::content(path, "model", format!("{problem}; train it again with `bearing-watch train`"))
    };
    let model = Embedded::from_bytes(&bytes).map_err(wrong)?;
    let notes = bearing_watch::model::notes(&bytes).map_err(wrong)?;
    let notes = serde_json::from_str(notes).map_err(|_| {
        Error::content(path, "notes", "no channel names in this model; train it again with `bearing-watch train`")
    })?;
    Ok((model, notes))
}
