//! `train-features`: the model of parts.

use std::path::PathBuf;
use std::time::Instant;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::plan_files::files;
use crate::{Choice, Fit, Independent, Part, Plan, Sums, Tails, Wanted, fingerprint, fold};
use model::Error;
use model::outputs::{self, Exports};
use model::session::description;
use model::session::{Log, Notes, read_by, rust_source};
use model::settings::{Settings, Validation};
use model::train::c_header::c_header;
use model::train::{Alarms, Recipe, Trained};

/// What is trained on.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PartOptions {
    /// Parts (`features`), or folders of them
    #[cfg_attr(feature = "schema", schemars(extend("x-value" = "PARTS", "x-positional" = true)))]
    pub parts: Vec<PathBuf>,
    /// Leave out the second pass over the parts: tails of the gate's law have their prior probabilities
    #[serde(default)]
    pub one_pass: bool,
}

/// A model that is written.
#[derive(Debug)]
pub struct TrainedOnParts {
    /// The model.
    pub trained: Trained,
    /// The sums of its training.
    pub sums: Sums,
    /// Size of the model file.
    pub bytes: usize,
    /// Seconds after the first pass, and in all.
    pub seconds: [f64; 2],
    /// Largest resident memory of this process, where the system gives it.
    pub peak_memory_mb: Option<f64>,
    /// A number that differs between different models.
    pub fingerprint: String,
    model: PathBuf,
    /// Whether the tails of the gate's law are those of segments.
    tails: bool,
}

/// Trains from parts, and writes the model; the text of a drive file goes into its notes.
///
/// # Errors
/// What cannot be read or written, other plans, or settings that do not fit.
pub fn train_features(
    settings: &Settings,
    options: &PartOptions,
    exports: &Exports,
    drive: Option<String>,
    log: &Log<'_>,
) -> Result<TrainedOnParts, Error> {
    let start = Instant::now();
    outputs::plan(&exports.files().collect::<Vec<_>>(), &options.parts)?;
    exports.check()?;
    let parts: Vec<Part> = files(&options.parts)?.iter().map(|path| Part::open(path)).collect::<Result<_, _>>()?;
    let plan = parts.first().ok_or_else(|| Error::Usage("no part is given".into()))?.plan.clone();
    let independent = independent(&settings.validation, &plan)?;
    let wanted = wanted(settings, &plan)?;
    let rows = parts.iter().map(Part::rows).sum::<u64>() as usize;
    let sums = fold(&parts, &wanted, &*log.steps("summing", rows))?;
    let fit = fit(settings, &sums, &plan, independent)?;
    let first_s = start.elapsed().as_secs_f64();
    let tails = if options.one_pass { None } else { second_pass((&parts, rows), &fit, &wanted, log)? };
    let (trained, host) = fit.train(tails.as_ref())?;
    let channels = read_by(&trained, plan.channels.clone());
    let description = description::lines(&trained, &channels, host);
    let notes = Notes::new(&channels, host, &trained, (vec![], &[]), drive);
    let exported = exports.exported(
        trained.to_bytes(&notes.to_text())?,
        || rust_source(&trained, &description, &channels),
        |name| c_header(&trained.to_core()?, (&description, &notes.orders), Some(&channels), name),
    )?;
    outputs::write_all(&exports.contents(&exported))?;
    log.warn(description::of_host(host, &description));
    log.warn(description::doubts(&trained));
    Ok(TrainedOnParts {
        fingerprint: fingerprint(&trained)?,
        bytes: exported.model.len(),
        seconds: [first_s, start.elapsed().as_secs_f64()],
        tails: tails.is_some(),
        peak_memory_mb: peak_memory_mb(),
        model: exports.model.clone(),
        trained,
        sums,
    })
}

/// The features and segments that are needed. The classes are not known yet; names and counts of priors and costs are
/// checked when the model is fitted.
fn wanted(settings: &Settings, plan: &Plan) -> Result<Wanted, Error> {
    let (features, covariates) = (settings.model.features.clone(), settings.model.covariates.clone());
    let first = Recipe { features, covariates, ..plan.recipe() };
    Ok(Wanted { features: Choice::new(plan, &first)?.features, conditions: settings.validation.train_where.clone() })
}

/// The fit of a model to sums.
fn fit(settings: &Settings, sums: &Sums, plan: &Plan, independent: Independent) -> Result<Fit, Error> {
    settings.check()?;
    let classes = crate::classes(sums, &settings.data.classes)?;
    let by_run = independent != Independent::Segments;
    let alarms = Alarms { by_run, ..settings.alarm.alarms(&classes)? };
    let base = Recipe { alarms, covariates: settings.model.covariates.clone(), ..plan.recipe() };
    Fit::new(sums, &classes, &settings.classifier(base, &classes)?, independent)
}

/// The left-out distances, if the order of the rows allows it.
fn second_pass(
    (parts, rows): (&[Part], usize),
    fit: &Fit,
    wanted: &Wanted,
    log: &Log<'_>,
) -> Result<Option<Tails>, Error> {
    if fit.counts_groups() && parts.iter().any(|part| !part.sorted) {
        log.warn(["units do not ascend: no second pass, and tails have their prior probabilities"]);
        return Ok(None);
    }
    crate::tails(parts, fit, wanted, &*log.steps("distances", rows))
}

/// What counts as independent.
fn independent(by: &Validation, plan: &Plan) -> Result<Independent, Error> {
    let known = |name: &str| plan.unit.as_deref() == Some(name) || plan.group.as_deref() == Some(name);
    for (option, name) in [("--group", &by.group), ("--unit", &by.unit)] {
        if let Some(name) = name.as_deref().filter(|name| !known(name)) {
            let own = plan.unit.iter().chain(&plan.group).map(String::as_str).collect::<Vec<_>>().join(" and ");
            let own = if own.is_empty() { "none".to_string() } else { own };
            let problem = format!("{option} {name}: the parts have {own} as drives and runs");
            return Err(Error::Usage(format!("{problem}; name that, or compute the features with {option} {name}")));
        }
    }
    Ok(match (&by.group, &by.unit) {
        (None, None) => Independent::Segments,
        (Some(group), _) if plan.unit.as_ref() != Some(group) => Independent::Runs,
        _ => Independent::Units,
    })
}

impl TrainedOnParts {
    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Self { trained, sums, seconds: [first, all], .. } = self;
        json!({
            "model": self.model,
            "bytes": self.bytes,
            "fingerprint": self.fingerprint,
            "classes": trained.classes,
            "segments": trained.statistics.counts,
            "rows": sums.rows,
            "left_out": trained.left_out.count,
            "features": trained.feature_names,
            "method": description::method(trained),
            "segment_samples": trained.segment_samples,
            "novelty": description::gate_to_json(trained),
            "tails_from_segments": self.tails,
            "seconds": all,
            "seconds_of_first_pass": first,
            "rows_a_second": sums.rows as f64 / all,
            "peak_memory_mb": self.peak_memory_mb,
        })
    }
}

/// The largest resident memory of this process, MB; `None` where the system does not give it.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
}
