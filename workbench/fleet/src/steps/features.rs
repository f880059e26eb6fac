//! `features`: the features of traces as a part.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};

use super::labelled::Labelled;
use super::plans::{known, new_plan};
use crate::{Plan, Row, Writer, plan_file};
use model::Error;
use model::core::Embedded;
use model::core::features::Catalogue;
use model::outputs;
use model::session::{Given, Log, Selection, TraceSource, is_irregular, of_irregular, refuse_held};
use model::settings::{Reading, Settings};
use model::trace::Tally;
use model::trace::labels::LabelledTrace;
use model::trace::{Preparation, Trace, same_interval, trace_name};
use model::train;
use traces::Origins;

/// Files that are read at a time.
const FILES: usize = 16;
/// Traces from which the constants are taken.
const PLAN_TRACES: u32 = 500;

/// Where the features go, and where the constants of the detector come from.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FeaturesOptions {
    /// Take the detector's constants from this part, or the .plan.json beside it, instead of the traces
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "PART")))]
    pub plan: Option<PathBuf>,
    /// Largest number of traces from which the constants are taken, at equal steps through all
    #[serde(default = "plan_traces")]
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "N")))]
    pub plan_traces: u32,
    /// The part, a Parquet file; its plan is also written beside it, as FILE.plan.json
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "FILE")))]
    pub out: PathBuf,
}

const fn plan_traces() -> u32 {
    PLAN_TRACES
}

/// A part that is written.
#[derive(Debug)]
pub struct Featured {
    /// Segments.
    pub rows: u64,
    /// Traces.
    pub traces: usize,
    /// Names of the features.
    pub features: Vec<String>,
    /// Segments without features, and why the first has none.
    pub empty: (usize, Option<String>),
    /// Whether the units of the rows ascend.
    pub sorted: bool,
    out: PathBuf,
    seconds: f64,
}

/// Computes the features of labelled traces, and writes the part.
///
/// # Errors
/// What cannot be read or written; settings that do not fit the traces or the plan.
pub fn features(
    settings: &Settings,
    mut given: Given,
    options: &FeaturesOptions,
    log: &Log<'_>,
) -> Result<Featured, Error> {
    let start = Instant::now();
    if options.plan_traces < 2 {
        return Err(Error::Usage(format!("--plan-traces {}: at least 2", options.plan_traces)));
    }
    let Reading { channels, shaft, preparation, .. } = settings.reading(given.front_end.take())?;
    log.warn(settings.bearing.bearing.note());
    let file = given.file.clone();
    let selection = Selection::new(settings, given, channels.clone());
    check_out(options, &selection)?;
    let (classes, chosen) = selection.chosen(&settings.validation.train_where)?;
    let plan = match &options.plan {
        Some(path) => known(settings, path, (&channels, preparation), shaft.as_ref())?,
        None => {
            let some = some(&chosen, options.plan_traces as usize);
            new_plan(settings, (&selection, &classes, &some), (channels, preparation), shaft)?
        }
    };
    let labels = Labelled::new(&selection, &chosen, &plan)?;
    log.warn(selection.left_out()?);
    let mut part = outputs::Staged::new(&options.out)?;
    let mut writer = Writer::new(part.file(), &options.out, &plan, &labels.columns)?;
    let met = write(&mut writer, selection.source(), (&labels, &plan), log)?;
    if let Some((id, _)) = chosen.iter().find(|(id, _)| !met.origins.has(id)) {
        let problem = format!("{id} is labelled, but there is no such trace; give its file or folder");
        return Err(Error::content(file.as_deref().unwrap_or(Path::new("labels")), "column trace", problem));
    }
    let (rows, sorted) = writer.finish()?;
    part.finish()?;
    outputs::write(&plan_file(&options.out), plan.to_json() + "\n")?;
    met.warn(chosen.len(), sorted, log);
    Ok(Featured {
        rows,
        traces: chosen.len(),
        features: plan.features,
        empty: (met.empty, met.reason),
        sorted,
        out: options.out.clone(),
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// Returns an error, before any work is done, if the part cannot be written.
fn check_out(options: &FeaturesOptions, selection: &Selection) -> Result<(), Error> {
    let out = &options.out;
    let inputs = [selection.inputs(), options.plan.iter().cloned().collect()].concat();
    outputs::plan(&[out, &plan_file(out)], &inputs)?;
    if out.extension().is_none_or(|end| !end.eq_ignore_ascii_case("parquet")) {
        return Err(Error::Usage(format!("{}: a part is a Parquet file; name it .parquet", out.display())));
    }
    Ok(())
}

/// At most so many of the traces, at equal steps through all.
fn some(chosen: &[(String, String)], most: usize) -> Vec<(String, String)> {
    let all = chosen.len();
    if all > most { (0..most).map(|k| chosen[k * all / most].clone()).collect() } else { chosen.to_vec() }
}

impl Featured {
    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> Value {
        json!({
            "part": self.out, "plan": plan_file(&self.out), "rows": self.rows, "traces": self.traces, "features": self.features,
            "without_features": self.empty.0, "units_ascend": self.sorted, "seconds": self.seconds,
        })
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
    /// What is missing in the traces.
    missing: Tally,
    /// Segments without features, and why the first has none.
    empty: usize,
    reason: Option<String>,
}

impl Met {
    /// Warns of what was met among so many traces.
    fn warn(&self, traces: usize, sorted: bool, log: &Log<'_>) {
        let (irregular, first) = &self.irregular;
        log.warn(of_irregular(*irregular, traces, first.as_deref()));
        log.warn(self.missing.line());
        if self.refused > 0 {
            log.warn([format!("the front end refused samples of {} traces", self.refused)]);
        }
        if !sorted {
            log.warn(["units do not ascend: training keeps the sums of all of this part's units in memory"]);
        }
    }
}

/// Writes the rows of all traces.
fn write<W: std::io::Write + Send>(
    writer: &mut Writer<W>,
    source: &dyn TraceSource,
    (labels, plan): (&Labelled, &Plan),
    log: &Log<'_>,
) -> Result<Met, Error> {
    let (estimator, catalogue) = (plan.estimator()?, plan.catalogue());
    let (channels, preparation) = (&plan.channels, plan.preparation());
    let wanted = |id: &str| labels.of.contains_key(id);
    let mut files = source.pieces()?;
    // Files of one trace each, in the order of their units.
    files.sort_by_cached_key(|piece| {
        let own = labels.of.get(&piece.name());
        own.map(|([_, unit, run], _)| (unit.clone(), run.clone()))
    });
    let steps = log.steps("features", files.len());
    let mut met = Met::default();
    for some in files.chunks(FILES) {
        let traces: Vec<Result<Option<Vec<Trace>>, Error>> =
            some.par_iter().map(|piece| piece.read(channels, &wanted)).collect();
        for (piece, traces) in some.iter().zip(traces) {
            let traces = traces?.unwrap_or_default();
            let rows = |trace: &Trace| rows((&estimator, &catalogue), plan, labels, trace, preparation);
            let found: Vec<_> = traces.par_iter().map(rows).collect();
            for (trace, found) in traces.iter().zip(found) {
                met.origins.add(&trace.id, piece.file())?;
                met.refused += usize::from(trace.refused.is_some());
                met.missing.add(&trace.id, trace.missing);
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
            steps(1);
        }
    }
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
    refuse_held(trace, &plan.channels)?;
    let id = trace_name(&trace.id).into_owned();
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
