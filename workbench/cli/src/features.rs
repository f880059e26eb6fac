//! `bearing-watch features`

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use serde_json::json;

use super::args::alarms::healthy_class;
use super::args::classifier::Averages;
use super::args::estimation::EstimationArgs;
use super::args::park::ParkArgs;
use super::args::shaft::ShaftArgs;
use super::args::traces::{
    ChannelArgs, Given, GroupArgs, PreparationArgs, Selection, SelectionArgs, StructureArgs, is_irregular,
    warn_of_irregular,
};
use super::call::Report;
use super::output;
use fleet::{Origin, Part, Plan, RESERVED, Row, Writer};
use model::Error;
use model::core::Embedded;
use model::core::features::Catalogue;
use model::trace::labels::LabelledTrace;
use model::trace::{Channels, Condition, Preparation, Trace, same_interval, stem};
use model::train::{self, Recipe, ShaftPlan};
use pages::page::counted;
use traces::{Candidate, Origins};

/// Files that are read at a time.
const FILES: usize = 16;

/// Compute the features of labelled traces, one row a segment, for training from tables of any size
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  bearing-watch features drive.toml --unit drive --out a.parquet
  bearing-watch features drive.toml --unit drive --plan a.parquet --out b.parquet
  bearing-watch train-features a.parquet b.parquet --features a,b --model out.bwm

The first part takes the constants of the detector (scales, lags, filters, nominal model) from its traces and has them \
as the plan in its metadata; further parts, on any machine, take the plan of the first one by --plan. All features of \
the detector are computed, by the core as in firmware. Traces are read and written in turn: memory does not grow with \
their number. Rows are written by unit if each file is one trace; a table of several traces should have its rows by \
unit, so that parts are read back in constant memory.")]
pub(super) struct Args {
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    channels: ChannelArgs,
    #[command(flatten)]
    structure: StructureArgs,
    #[command(flatten)]
    estimation: EstimationArgs,
    #[command(flatten)]
    shaft: ShaftArgs,
    #[command(flatten)]
    preparation: PreparationArgs,
    #[command(flatten)]
    park: ParkArgs,
    /// Only the rows with this, e.g. 'run<=4'; may be repeated, all must hold
    #[arg(long, value_name = "CONDITION")]
    train_where: Vec<Condition>,
    /// Averages of columns are computed if they are named here: mean_CHANNEL, rms_CHANNEL; all other features always
    /// are
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    features: Vec<String>,
    /// The same
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    covariates: Vec<String>,
    /// The healthy class, whose mean is the nominal model unless --nominal is given
    #[arg(long, value_name = "CLASS")]
    healthy: Option<String>,
    #[command(flatten)]
    groups: GroupArgs,
    /// Take the detector's constants from this part instead of the traces
    #[arg(long, value_name = "PART")]
    plan: Option<PathBuf>,
    /// Largest number of traces from which the constants are taken, at equal steps through all
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(2..))]
    plan_traces: u32,
    /// The part, a Parquet file
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    output::report(made(args)?, args.json)
}

/// Writes the part, and returns what there is to say.
pub(super) fn made(args: &Args) -> Result<Report, Error> {
    let start = Instant::now();
    args.channels.require(args.structure.structure())?;
    let mut channels = args.channels.channels()?;
    let (shaft_channels, shaft) = args.shaft.shaft(&channels.y)?.unzip();
    channels.shaft = shaft_channels;
    let preparation = args.preparation.preparation()?;
    let averages = Averages { features: &args.features, covariates: &args.covariates };
    channels = averages.columns((args.structure.structure(), shaft.as_ref()), channels, preparation)?;
    let selection = args.selection.read(&channels, Given::default())?;
    let inputs = [selection.inputs(), args.plan.iter().cloned().collect()].concat();
    output::plan(&[&args.out], &inputs)?;
    if args.out.extension().is_none_or(|end| !end.eq_ignore_ascii_case("parquet")) {
        return Err(Error::Usage(format!("{}: a part is a Parquet file; name it .parquet", args.out.display())));
    }
    let (classes, chosen) = selection.chosen(&args.train_where)?;
    let plan = match &args.plan {
        Some(path) => args.known(path, (&channels, preparation), shaft.as_ref())?,
        None => args.new_plan((&selection, &classes, &chosen), (channels.clone(), preparation), shaft)?,
    };
    let labels = Labelled::new(args, &selection, &chosen, &plan)?;
    let mut file = output::temporary(&args.out)?;
    let mut writer = Writer::new(file.as_file_mut(), &args.out, &plan, &labels.columns)?;
    let found = write(&mut writer, &selection, (&channels, preparation), &labels, &plan)?;
    if let Some((id, _)) = chosen.iter().find(|(id, _)| !found.origins.has(id)) {
        let problem = format!("{id} is labelled, but there is no such trace; give its file or folder");
        return Err(Error::content(&args.selection.labels, "column trace", problem));
    }
    let (rows, sorted) = writer.finish()?;
    file.persist(&args.out).map_err(|e| Error::Io { path: args.out.clone(), source: e.error })?;
    let (irregular, first) = &found.irregular;
    warn_of_irregular(*irregular, chosen.len(), first.as_deref());
    if found.refused > 0 {
        output::warn(format!("the front end refused samples of {} traces", found.refused));
    }
    if !sorted {
        output::warn("units do not ascend: training keeps the sums of all of this part's units in memory");
    }
    let json = json!({
        "part": args.out, "rows": rows, "traces": chosen.len(), "features": plan.features,
        "without_features": found.empty, "units_ascend": sorted, "seconds": start.elapsed().as_secs_f64(),
    });
    let counts =
        [counted(rows as usize, "segment"), counted(chosen.len(), "trace"), counted(plan.features.len(), "feature")];
    let [segments, traces, features] = counts;
    let said = format!("{segments} of {traces} with {features} in {}", args.out.display());
    let without = format!("{} segments have none: {}", found.empty, found.reason.unwrap_or_default());
    let lines = [Some(said), (found.empty > 0).then_some(without)];
    Ok(Report { lines: lines.into_iter().flatten().collect(), json })
}

impl Args {
    /// The plan of another part, for the same channels and structure.
    fn known(
        &self,
        path: &Path,
        (channels, preparation): (&Channels, Preparation),
        shaft: Option<&ShaftPlan>,
    ) -> Result<Plan, Error> {
        let plan = Part::open(path)?.plan;
        let differs = [
            ("the channels", plan.channels() != *channels),
            ("the order", plan.structure() != self.structure.structure()),
            ("--block-mean or --decimate", plan.preparation() != preparation),
            (
                "the orders of the bearing",
                plan.recipe().shaft.map(|own| own.orders) != shaft.map(|own| own.orders.clone()),
            ),
            ("--segment", self.estimation.segment().is_some_and(|segment| segment != plan.segment_samples())),
            ("--method", plan.recipe().estimation.method != self.estimation.method.core()),
            ("--unit", plan.unit != self.groups.unit),
            ("--group", plan.group != self.groups.group),
        ];
        match differs.iter().find(|(_, differs)| *differs) {
            Some((what, _)) => {
                Err(Error::content(path, "plan", format!("{what} of this command are others than the plan's")))
            }
            None => Ok(plan),
        }
    }

    /// The plan with constants from some of the traces.
    fn new_plan(
        &self,
        (selection, classes, chosen): (&Selection, &[String], &[(String, String)]),
        (channels, preparation): (Channels, Preparation),
        shaft: Option<ShaftPlan>,
    ) -> Result<Plan, Error> {
        let (most, all) = (self.plan_traces as usize, chosen.len());
        let some: Vec<(String, String)> =
            if all > most { (0..most).map(|k| chosen[k * all / most].clone()).collect() } else { chosen.to_vec() };
        let traces = selection.read(classes, &some)?;
        let recorded_interval_s = traces.iter().find_map(|own| own.trace.interval_s).unwrap_or(0.0);
        let prepared = super::model_file::prepare(&traces, preparation)?;
        let structure = self.structure.structure();
        let healthy = healthy_class(self.healthy.as_deref(), classes)?;
        let recipe = Recipe {
            columns: channels.clone(),
            park: self.park.of(&channels)?,
            shaft,
            estimation: self.estimation.estimation(structure, classes, healthy)?,
            features: self.features.clone(),
            covariates: self.covariates.clone(),
            ..Recipe::new(structure)
        };
        let found = train::estimating(&prepared, classes, &recipe)?;
        let (unit, group) = (self.groups.unit.clone(), self.groups.group.clone());
        let origin = Origin { channels, preparation, recorded_interval_s, unit, group };
        let mut plan = Plan::new(&found, classes, origin)?;
        plan.usual = train::usual_errors(&prepared, classes, &found)?;
        Ok(plan)
    }
}

/// What the labels say of the traces.
struct Labelled {
    /// Further columns of the labels.
    columns: Vec<String>,
    /// Class, unit, run and further cells of each trace.
    of: HashMap<String, ([String; 3], Vec<String>)>,
}

impl Labelled {
    fn new(args: &Args, selection: &Selection, chosen: &[(String, String)], plan: &Plan) -> Result<Self, Error> {
        let labels = selection.labels();
        let ids = || chosen.iter().map(|(id, _)| id.as_str());
        let given = [&plan.unit, &plan.group].map(Option::as_deref);
        let own = |name: &&String| {
            !RESERVED[..3].contains(&name.as_str())
                && (!RESERVED.contains(&name.as_str()) || !given.contains(&Some(name)))
        };
        let columns: Vec<String> = labels.columns().iter().filter(own).cloned().collect();
        let cells = columns.iter().map(|name| labels.cells(name, ids())).collect::<Result<Vec<_>, _>>()?;
        let column = |name: &Option<String>| name.as_ref().map(|name| labels.cells(name, ids())).transpose();
        let (units, runs) = (column(&plan.unit)?, column(&plan.group)?);
        let each = |(k, (id, class)): (usize, &(String, String))| {
            let cell = |of: &Option<Vec<String>>| of.as_ref().map(|cells| cells[k].clone());
            let (unit, run) = (cell(&units), cell(&runs));
            if unit.as_deref() == Some("") || run.as_deref() == Some("") {
                let name = if unit.as_deref() == Some("") { &args.groups.unit } else { &args.groups.group };
                let problem = format!("nothing in column {} of the labels", name.as_deref().unwrap_or_default());
                return Err(Error::trace(id, problem));
            }
            let own = unit.clone().or_else(|| run.clone()).unwrap_or_else(|| id.clone());
            let run = run.or(unit).unwrap_or_else(|| id.clone());
            Ok((id.clone(), ([class.clone(), own, run], cells.iter().map(|cells| cells[k].clone()).collect())))
        };
        Ok(Self { columns, of: chosen.iter().enumerate().map(each).collect::<Result<_, _>>()? })
    }
}

/// What was met on the way.
#[derive(Default)]
struct Met {
    origins: Origins,
    /// Traces that are sampled irregularly, and the first of them.
    irregular: (usize, Option<String>),
    /// Traces of which the front end refused samples.
    refused: usize,
    /// Segments without features, and why the first has none.
    empty: usize,
    reason: Option<String>,
}

/// Writes the rows of all traces.
fn write<W: std::io::Write + Send>(
    writer: &mut Writer<W>,
    selection: &Selection,
    (channels, preparation): (&Channels, Preparation),
    labels: &Labelled,
    plan: &Plan,
) -> Result<Met, Error> {
    let (estimator, catalogue) = (plan.estimator()?, plan.catalogue());
    let wanted = |id: &str| labels.of.contains_key(id);
    let mut files = traces::candidates(selection.paths())?;
    // Files of one trace each, in the order of their units.
    files.sort_by_cached_key(|candidate| {
        let own = labels.of.get(stem(&candidate.file.file_name().unwrap_or_default().to_string_lossy()));
        own.map(|([_, unit, run], _)| (unit.clone(), run.clone()))
    });
    let bar = output::progress("features", files.len());
    let mut met = Met::default();
    for some in files.chunks(FILES) {
        let read = |candidate: &Candidate| candidate.read(channels, Some(&wanted));
        let traces: Vec<Result<Option<Vec<Trace>>, Error>> = some.par_iter().map(read).collect();
        for (candidate, traces) in some.iter().zip(traces) {
            let traces = traces?.unwrap_or_default();
            let rows = |trace: &Trace| rows((&estimator, &catalogue), plan, labels, trace, preparation);
            let found: Vec<_> = traces.par_iter().map(rows).collect();
            for (trace, found) in traces.iter().zip(found) {
                met.origins.add(&trace.id, &candidate.file)?;
                met.refused += usize::from(trace.refused.is_some());
                if is_irregular(trace) {
                    met.irregular.0 += 1;
                    met.irregular.1.get_or_insert_with(|| trace.id.clone());
                }
                for (row, reason) in found? {
                    if row.values.iter().all(|x| x.is_nan()) {
                        met.empty += 1;
                        met.reason.get_or_insert_with(|| format!("{}, {}", trace.id, reason.unwrap_or_default()));
                    }
                    writer.add(row)?;
                }
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(met)
}

/// The rows of a trace, with the reason if a segment has no features.
fn rows(
    (estimator, catalogue): (&Embedded, &Catalogue),
    plan: &Plan,
    labels: &Labelled,
    trace: &Trace,
    preparation: Preparation,
) -> Result<Vec<(Row, Option<String>)>, Error> {
    let [recorded_s, _] = plan.intervals_s();
    if let Some(step) = trace.interval_s.filter(|step| recorded_s > 0.0 && !same_interval(*step, recorded_s)) {
        let (step, recorded_s) = (step as f32, recorded_s as f32);
        let problem = format!("sampled every {step} s, but the plan is for {recorded_s} s; resample it");
        return Err(Error::trace(&trace.id, problem));
    }
    let id = stem(&trace.id).to_string();
    let Some(([class, unit, run], cells)) = labels.of.get(&id) else { return Ok(vec![]) };
    let prepared = LabelledTrace { trace: preparation.apply(trace)?, class: 0 };
    let segments = estimator.run(&prepared.trace);
    let each = |(k, segment): (usize, &model::core::SegmentReport)| {
        let (value, variance) = train::features_of(segment, catalogue);
        let values = value.iter().zip(variance.iter()).map(|(x, v)| if v.is_finite() { *x } else { f64::NAN });
        let lost = segment.counts.rejected + segment.counts.saturated;
        let row = Row {
            texts: [id.clone(), class.clone(), unit.clone(), run.clone()],
            segment: k as u32,
            usable: 1.0 - lost as f32 / segment.length.max(1) as f32,
            values: values.collect(),
            variances: variance.iter().copied().collect(),
            labels: cells.clone(),
        };
        (row, segment.verdict.as_ref().err().cloned())
    };
    Ok(segments.iter().enumerate().map(each).collect())
}
