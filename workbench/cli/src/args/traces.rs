//! Arguments on traces: channels, structure, preparation, selection by labels, and folds.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use crate::output;
use model::Error;
use model::identify::{Structure, parse_order};
use model::trace::labels::LabelledTrace;
use model::trace::{Channels, Condition, FrontEndFile, Labels, Preparation, Recorded, Trace};
use model::train::Validation;
use traces::Source;

/// The columns of the three signals.
#[derive(Clone, Debug, Args)]
pub(crate) struct ChannelArgs {
    /// Output: a column, or a formula of columns (as a rule the quadrature current): a-b, 0.5*(a + b),
    /// "speed_rpm rad/s", "integrate(speed_rpm) rad"
    #[arg(long, value_name = "CHANNEL")]
    y: String,
    /// First input (reference, or reference-measured, of the controlled variable)
    #[arg(long, value_name = "CHANNEL")]
    u1: String,
    /// Second input (load); without one, an order with nc = 0
    #[arg(long, value_name = "CHANNEL")]
    u2: Option<String>,
    /// Recordings at the control rate pass this front end (TOML); it makes the columns current_a, velocity_rad_s and
    /// angle_rad, and decimates every other column. `simulate --rig ema` writes an example
    #[arg(long, value_name = "FILE")]
    front_end: Option<PathBuf>,
    #[command(flatten)]
    times: TimeArgs,
}

/// The time of the rows.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct TimeArgs {
    /// Time column, in s or in the unit at the end of its name; by default the one with a usual name (t_s, "Time [ms]",
    /// timestamp …). "none" leaves it out
    #[arg(long, value_name = "COLUMN")]
    pub(crate) time: Option<String>,
    /// Rows a second, for files without a time column
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate_hz: Option<f64>,
}

/// A rate above zero.
pub(crate) fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse::<f64>().ok().filter(|rate| *rate > 0.0 && rate.is_finite());
    rate.ok_or_else(|| "give a number above 0".into())
}

impl ChannelArgs {
    pub(crate) fn channels(&self) -> Result<Channels, Error> {
        let front_end = self.front_end.as_deref().map(FrontEndFile::read).transpose()?;
        Ok(Channels { front_end, ..self.signals() })
    }

    /// Returns an error if the structure has terms of a second input, and none is given.
    pub(crate) fn require(&self, structure: Structure) -> Result<(), Error> {
        if self.u2.is_some() || structure.nc == 0 {
            return Ok(());
        }
        let nc = structure.nc;
        Err(Error::Usage(format!("the order has {nc} terms of a second input; give --u2, or an order with nc = 0")))
    }

    /// The channels without the front end; without a second input the first one takes its place, which no order uses.
    pub(crate) fn signals(&self) -> Channels {
        let TimeArgs { time, rate_hz } = self.times.clone();
        Channels { time, rate_hz, ..Channels::new(&self.y, &self.u1, self.u2.as_ref().unwrap_or(&self.u1)) }
    }
}

/// Traces, and the columns of the three signals.
#[derive(Clone, Debug, Args)]
pub(crate) struct TraceArgs {
    /// Trace files or folders
    #[arg(value_name = "TRACES", required = true)]
    pub(crate) traces: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) channels: ChannelArgs,
}

impl TraceArgs {
    /// Reads the traces, and warns of those with irregular sampling.
    pub(crate) fn read(&self) -> Result<Vec<Trace>, Error> {
        self.read_with(Ok)
    }

    /// The same with further channels.
    pub(crate) fn read_with(&self, add: impl FnOnce(Channels) -> Result<Channels, Error>) -> Result<Vec<Trace>, Error> {
        let traces = traces::read(&self.traces, &add(self.channels.channels()?)?)?;
        warn_irregular(traces.iter());
        traces.iter().try_for_each(refuse_gaps)?;
        Ok(traces)
    }
}

/// The model structure.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct StructureArgs {
    /// na,nb,nc,nkb,nkc
    #[arg(long, value_parser = parse_order, value_name = "ORDER")]
    order: Structure,
    /// Estimate a constant term too (recorded signals have operating points)
    #[arg(long)]
    offset: bool,
}

impl StructureArgs {
    pub(crate) fn structure(self) -> Structure {
        Structure { offset: self.offset, ..self.order }
    }
}

/// Preparation of the traces before identification.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct PreparationArgs {
    /// Average blocks of N samples first
    #[arg(long, value_name = "N", default_value_t = 1)]
    block_mean: usize,
    /// Then apply an anti-alias filter and keep every N-th sample
    #[arg(long, value_name = "N", default_value_t = 1)]
    decimate: usize,
}

impl PreparationArgs {
    pub(crate) fn preparation(self) -> Result<Preparation, Error> {
        let preparation = Preparation { block_mean: self.block_mean, decimate: self.decimate };
        preparation.factor().map(|_| preparation)
    }
}

/// Selection of labelled traces.
#[derive(Clone, Debug, Args)]
pub(crate) struct SelectionArgs {
    /// Trace files or folders; without any, the folder of the labels
    #[arg(value_name = "TRACES")]
    traces: Vec<PathBuf>,
    /// CSV with the columns trace,class_name and any further columns for the selection
    #[arg(long, value_name = "FILE")]
    pub(crate) labels: PathBuf,
    /// Only rows that meet this condition, e.g. load_kgf=20; may be repeated, all must hold
    #[arg(long = "where", value_name = "CONDITION")]
    conditions: Vec<Condition>,
    /// Only these classes, in this order
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = trimmed)]
    classes: Vec<String>,
}

fn trimmed(text: &str) -> Result<String, std::convert::Infallible> {
    Ok(text.trim().into())
}

/// What a program that calls the workbench has in memory, in place of files.
#[derive(Clone, Debug, Default)]
pub(crate) struct Given {
    /// Tables of the traces.
    pub(crate) traces: Option<Vec<Arc<Recorded>>>,
    /// The labels.
    pub(crate) labels: Option<Arc<Recorded>>,
}

/// The labels, and where their traces are.
#[derive(Debug)]
pub(crate) struct Selection {
    /// The file of the labels, if they are in one.
    file: Option<PathBuf>,
    labels: Labels,
    source: Source,
    channels: Channels,
    conditions: Vec<Condition>,
    asked: Vec<String>,
}

/// Class names, and id and class of each trace.
pub(crate) type Chosen = (Vec<String>, Vec<(String, String)>);

impl SelectionArgs {
    pub(crate) fn read(&self, channels: &Channels, given: Given) -> Result<Selection, Error> {
        let folder = self.labels.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Ok(Selection {
            file: given.labels.is_none().then(|| self.labels.clone()),
            labels: given.labels.map_or_else(|| traces::read_labels(&self.labels), |table| Labels::of(&table))?,
            source: match given.traces {
                Some(tables) => Source::Memory(tables),
                None if self.traces.is_empty() => Source::Files(vec![folder.to_path_buf()]),
                None => Source::Files(self.traces.clone()),
            },
            channels: channels.clone(),
            conditions: self.conditions.clone(),
            asked: self.classes.clone(),
        })
    }
}

impl Selection {
    /// Returns the files that are read; no output may replace them.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        self.source.paths().iter().chain(&self.file).cloned().collect()
    }

    /// Returns the class names, and id and class of each trace that meets the common conditions and these further ones.
    pub(crate) fn chosen(&self, further: &[Condition]) -> Result<Chosen, Error> {
        let conditions = [&self.conditions, further].concat();
        let mut chosen = self.labels.select(&conditions)?;
        let classes = self.labels.classes(&chosen, &self.asked)?;
        chosen.retain(|(_, name)| classes.contains(name));
        Ok((classes, chosen))
    }

    /// Files and folders of the traces.
    pub(crate) fn paths(&self) -> &[PathBuf] {
        self.source.paths()
    }

    /// The labels.
    pub(crate) const fn labels(&self) -> &Labels {
        &self.labels
    }

    /// Returns the class names and the traces of the rows that meet the common conditions and these further ones.
    pub(crate) fn rows(&self, further: &[Condition]) -> Result<(Vec<String>, Vec<LabelledTrace>), Error> {
        let (classes, chosen) = self.chosen(further)?;
        let traces = self.read(&classes, &chosen)?;
        Ok((classes, traces))
    }

    /// Reads these of the chosen traces.
    pub(crate) fn read(&self, classes: &[String], chosen: &[(String, String)]) -> Result<Vec<LabelledTrace>, Error> {
        let wanted: std::collections::HashSet<&str> = chosen.iter().map(|(id, _)| id.as_str()).collect();
        let traces = self.source.read_wanted(&self.channels, &|id| wanted.contains(id))?;
        self.labels.join(chosen, classes, &traces)
    }

    /// Returns the cells of a column of the labels, one for each trace.
    pub(crate) fn cells(&self, column: &str, traces: &[LabelledTrace]) -> Result<Vec<String>, Error> {
        self.labels.cells(column, traces.iter().map(|t| t.trace.id.as_str()))
    }
}

/// Settings of the cross-validation.
#[derive(Clone, Debug, Args)]
pub(crate) struct ValidationArgs {
    /// Folds of the cross-validation
    #[arg(long, value_name = "N", default_value_t = 10)]
    folds: usize,
    #[command(flatten)]
    pub(crate) groups: GroupArgs,
    /// Seed of the split into folds
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    fold_seed: u64,
}

impl ValidationArgs {
    pub(crate) fn validation(&self, selection: &Selection, traces: &[LabelledTrace]) -> Result<Validation, Error> {
        if self.folds < 2 {
            return Err(Error::Usage(format!("--folds {}: at least 2", self.folds)));
        }
        let Groups { runs, units } = self.groups.read(selection, traces)?;
        let [groups, units] = [runs, units].map(Option::unwrap_or_default);
        Ok(Validation { folds: self.folds, seed: self.fold_seed, groups, units })
    }
}

/// Which traces are alike.
#[derive(Clone, Debug, Args)]
pub(crate) struct GroupArgs {
    /// Traces with the same value in this column of the labels are of one run: they stay in one fold, intervals count
    /// runs, the gate's false-alarm rate is that of the next run, and false alarms are given by run in the order of the
    /// labels
    #[arg(long, value_name = "COLUMN")]
    pub(crate) group: Option<String>,
    /// Traces with the same value in this column of the labels are of one unit (drive): units stay in one fold and are
    /// not in both training and test, and intervals count units. Without --group, units are the runs
    #[arg(long, value_name = "COLUMN")]
    pub(crate) unit: Option<String>,
}

/// The run and the unit of each trace, if they are known; the name of a run starts with that of its unit.
#[derive(Debug)]
pub(crate) struct Groups {
    pub(crate) runs: Option<Vec<String>>,
    pub(crate) units: Option<Vec<String>>,
}

impl GroupArgs {
    pub(crate) fn read(&self, selection: &Selection, traces: &[LabelledTrace]) -> Result<Groups, Error> {
        let column = |name: &Option<String>| name.as_ref().map(|name| selection.cells(name, traces)).transpose();
        let (runs, units) = (column(&self.group)?, column(&self.unit)?);
        let empty = units.iter().flatten().position(String::is_empty);
        if let (Some(place), Some(column)) = (empty, &self.unit) {
            return Err(Error::trace(&traces[place].trace.id, format!("no unit in column {column} of the labels")));
        }
        let runs = match (runs, &units) {
            (Some(runs), Some(units)) if self.group != self.unit => {
                Some(units.iter().zip(&runs).map(|(unit, run)| format!("{unit}/{run}")).collect())
            }
            (runs, units) => runs.or_else(|| units.clone()),
        };
        Ok(Groups { runs, units })
    }
}

impl Groups {
    /// What intervals count: units, or runs without them.
    pub(crate) fn clusters(&self) -> Option<&[String]> {
        self.units.as_deref().or(self.runs.as_deref())
    }

    /// Returns an error if a unit is among those of the training.
    pub(crate) fn refuse_known(&self, trained: &[String]) -> Result<(), Error> {
        let shared = self.units.iter().flatten().find(|unit| trained.contains(unit));
        shared.map_or(Ok(()), |unit| {
            let problem = format!("unit {unit} is both in training and in test; give other units to one of them");
            Err(Error::Usage(format!("{problem}, or leave out --unit to judge later runs of known drives")))
        })
    }
}

/// Returns an error if the front end refused samples within a trace: batch methods need all of them.
pub(crate) fn refuse_gaps(trace: &Trace) -> Result<(), Error> {
    trace.refused.map_or(Ok(()), |refused| {
        Err(Error::trace(&trace.id, format!("{refused}; record it again, or cut the recording around them")))
    })
}

/// Warns of traces of which the front end refused samples; the detector counts them and goes on.
pub(crate) fn warn_refused<'a>(traces: impl Iterator<Item = &'a Trace>) {
    for (trace, refused) in traces.filter_map(|trace| Some((trace, trace.refused?))) {
        output::warn(format!("trace {}: {refused}", trace.id));
    }
}

/// Warns of traces with an irregular sampling interval.
pub(crate) fn warn_irregular<'a>(traces: impl Iterator<Item = &'a Trace> + Clone) {
    let irregular = traces.clone().filter(|trace| is_irregular(trace));
    warn_of_irregular(
        irregular.clone().count(),
        traces.count(),
        irregular.clone().next().map(|first| first.id.as_str()),
    );
}

/// Whether more than 2 % of the steps are off by a tenth.
pub(crate) const fn is_irregular(trace: &Trace) -> bool {
    50 * trace.irregular_steps > trace.y.len()
}

/// Warns of so many traces with an irregular sampling interval, if there are any.
pub(crate) fn warn_of_irregular(count: usize, all: usize, first: Option<&str>) {
    if let Some(first) = first {
        output::warn(format!(
            "{count} of {all} traces are sampled irregularly (more than 2 % of the steps off by a tenth), first \
             {first}; resample them"
        ));
    }
}
