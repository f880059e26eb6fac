//! `bearing-watch train-features`

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;

use super::args::alarms::AlarmArgs;
use super::args::classifier::ClassifierArgs;
use super::args::exports::ExportArgs;
use super::args::traces::GroupArgs;
use super::call::Report;
use super::description::{self, method_word};
use super::model_file::Notes;
use super::{output, training};
use fleet::{Choice, Fit, Independent, Part, Plan, Sums, Tails, Units, Wanted, fingerprint};
use model::Error;
use model::trace::{Condition, Preparation};
use model::train::c_header::c_header;
use model::train::{Recipe, Trained};

/// Train a model from tables of features, or from their sums, in constant memory
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  bearing-watch train-features a.parquet b.parquet --features a,b --unit drive --model out.bwm --rust model.rs

Means, covariances, projection, discriminant, and the spread of runs or drives are functions of sums: they are those \
of `train` on the same segments. Different are:
  - the features are always those of the core in single precision; `train` takes plain least squares in double \
precision;
  - the tails of the gate's law come from a second pass over the parts (skipped by --one-pass); sums alone leave their \
prior probabilities, and the gate is a little further out;
  - errors of features enter as the mean excess over the usual ones of the plan, by class, not by segment;
  - segments that lack a feature do not count for the spread of runs and drives;
  - trends of runs are not found, and the draws for the likelihood ratios of the alarm are of means and covariances;
  - there is no cross-validation, no --rank, no --covariates and no --discriminant shrunk; the model does not list the \
traces or drives of its training, so that `evaluate` cannot warn of them.

One file of features has one plan; parts of other plans are refused.")]
pub(super) struct Args {
    /// Parts (`features`), or sums (`features-sum`)
    #[arg(value_name = "PARTS", required = true)]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    classifier: ClassifierArgs,
    /// Not for sums: refused, unless empty
    #[arg(long, value_name = "NAMES", value_delimiter = ',', hide = true)]
    covariates: Vec<String>,
    /// Only these classes, in this order
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    classes: Vec<String>,
    /// Only segments with this in a column of the parts, e.g. 'run<=4'; may be repeated, all must hold
    #[arg(long, value_name = "CONDITION")]
    train_where: Vec<Condition>,
    #[command(flatten)]
    groups: GroupArgs,
    #[command(flatten)]
    alarms: AlarmArgs,
    /// Leave out the second pass over the parts: tails of the gate's law have their prior probabilities
    #[arg(long)]
    one_pass: bool,
    #[command(flatten)]
    exports: ExportArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Files that are trained on.
pub(super) struct Inputs {
    pub(super) parts: Vec<Part>,
    sums: Vec<(PathBuf, Sums)>,
}

impl Inputs {
    /// Opens parts and reads sums.
    pub(super) fn open(paths: &[PathBuf]) -> Result<Self, Error> {
        let mut inputs = Self { parts: vec![], sums: vec![] };
        for path in paths {
            let mut head = [0; 16];
            let mut file = std::fs::File::open(path).map_err(Error::io(path))?;
            let read = std::io::Read::read(&mut file, &mut head).map_err(Error::io(path))?;
            if Sums::are_sums(&head[..read]) || path.extension().is_some_and(|end| end == "sums") {
                let bytes = std::fs::read(path).map_err(Error::io(path))?;
                let sums = Sums::from_bytes(&bytes).map_err(|problem| Error::content(path, "content", problem))?;
                inputs.sums.push((path.clone(), sums));
            } else {
                inputs.parts.push(Part::open(path)?);
            }
        }
        Ok(inputs)
    }

    fn plan(&self) -> Result<&Plan, Error> {
        let first = self.parts.first().map(|part| &part.plan).or_else(|| self.sums.first().map(|(_, sums)| &sums.plan));
        first.ok_or_else(|| Error::Usage("no part is given".into()))
    }

    /// Sums everything; the features are those of the parts.
    pub(super) fn sums(self, wanted: (Vec<String>, Vec<Condition>), units: Units) -> Result<Sums, Error> {
        let wanted = Wanted { features: wanted.0, conditions: wanted.1 };
        self.folded(&wanted, units).map(|(sums, _)| sums)
    }

    fn folded(self, wanted: &Wanted, units: Units) -> Result<(Sums, Vec<Part>), Error> {
        let Self { parts, sums } = self;
        let mut all = None;
        if !parts.is_empty() {
            all = Some((PathBuf::new(), fold(&parts, wanted, units)?));
        }
        for (path, more) in sums {
            match &mut all {
                None => all = Some((path, more)),
                Some((first, all)) => all.merge(more).map_err(|problem| {
                    let with =
                        if first.as_os_str().is_empty() { "the parts".into() } else { first.display().to_string() };
                    Error::Usage(format!("{} and {with}: {problem}", path.display()))
                })?,
            }
        }
        let (_, sums) = all.ok_or_else(|| Error::Usage("no part is given".into()))?;
        Ok((sums, parts))
    }
}

fn rows_of(parts: &[Part]) -> usize {
    parts.iter().map(Part::rows).sum::<u64>() as usize
}

fn fold(parts: &[Part], wanted: &Wanted, units: Units) -> Result<Sums, Error> {
    let bar = output::progress("summing", rows_of(parts));
    let sums = fleet::fold(parts, wanted, units, &|rows| bar.inc(rows))?;
    bar.finish_and_clear();
    Ok(sums)
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    output::report(made(args)?, args.json)
}

/// Writes the model, and returns what there is to say.
pub(super) fn made(args: &Args) -> Result<Report, Error> {
    let start = Instant::now();
    output::plan(&args.exports.files().collect::<Vec<_>>(), &args.parts)?;
    let inputs = Inputs::open(&args.parts)?;
    let plan = inputs.plan()?.clone();
    let independent = args.independent(&plan)?;
    // The classes are not known yet; names and counts of priors and costs are checked below.
    let first =
        Recipe { features: args.classifier.features.clone(), covariates: args.covariates.clone(), ..plan.recipe() };
    let needed = match inputs.parts.is_empty() {
        // The sums' own features, if none are chosen.
        true => vec![],
        false => Choice::new(&plan, &first)?.features,
    };
    let wanted = Wanted { features: needed, conditions: args.train_where.clone() };
    if inputs.parts.is_empty() && !args.train_where.is_empty() {
        return Err(Error::Usage("--train-where chooses segments of parts; sums have theirs".into()));
    }
    let units = if inputs.sums.is_empty() { Units::Closed } else { Units::Remembered };
    let (sums, parts) = inputs.folded(&wanted, units)?;
    let from_parts = !parts.is_empty() && units == Units::Closed;
    let sums = sums.finish()?;
    let classes = fleet::classes(&sums, &args.classes)?;
    let alarms = model::train::Alarms { by_run: independent != Independent::Segments, ..args.alarms.alarms(&classes)? };
    let base = Recipe { alarms, covariates: args.covariates.clone(), ..plan.recipe() };
    let recipe = args.classifier.apply(base, &classes)?;
    let fit = Fit::new(&sums, &classes, &recipe, independent)?;
    let first_s = start.elapsed().as_secs_f64();
    let tails = if from_parts && !args.one_pass { second_pass(&parts, &fit, &wanted)? } else { None };
    let (trained, host) = fit.train(tails.as_ref())?;
    let channels = plan.channels();
    let channels = training::read_by(&trained, channels);
    let description = description::lines(&trained, &channels, host);
    let notes = Notes::new(&channels, host, &trained, (vec![], &[]));
    let exported = args.exports.exported(
        trained.to_bytes(&notes.to_text())?,
        |segments| training::rust_source(&trained, (&description, &channels), segments),
        || c_header(&trained.to_core()?, &description, Some(&channels)),
    )?;
    output::write_all(&args.exports.contents(&exported))?;
    if host != Preparation::NONE {
        output::warn(format!("the detector does not decimate: {}", description[3]));
    }
    let told = Told { sums: &sums, seconds: [first_s, start.elapsed().as_secs_f64()], tails: tails.is_some() };
    args.report(&trained, exported.model.len(), &told)
}

/// The left-out distances, if the order of the rows allows it.
fn second_pass(parts: &[Part], fit: &Fit, wanted: &Wanted) -> Result<Option<Tails>, Error> {
    if fit.counts_groups() && parts.iter().any(|part| !part.sorted) {
        output::warn("units do not ascend: no second pass, and tails have their prior probabilities");
        return Ok(None);
    }
    let bar = output::progress("distances", rows_of(parts));
    let tails = fleet::tails(parts, fit, wanted, &|rows| bar.inc(rows))?;
    bar.finish_and_clear();
    Ok(tails)
}

struct Told<'a> {
    sums: &'a Sums,
    /// After the first pass, and in all.
    seconds: [f64; 2],
    tails: bool,
}

impl Args {
    /// What counts as independent.
    fn independent(&self, plan: &Plan) -> Result<Independent, Error> {
        let known = |name: &str| plan.unit.as_deref() == Some(name) || plan.group.as_deref() == Some(name);
        for (option, name) in [("--group", &self.groups.group), ("--unit", &self.groups.unit)] {
            if let Some(name) = name.as_deref().filter(|name| !known(name)) {
                let own = plan.unit.iter().chain(&plan.group).map(String::as_str).collect::<Vec<_>>().join(" and ");
                let own = if own.is_empty() { "none".to_string() } else { own };
                let problem = format!("{option} {name}: the parts have {own} as drives and runs");
                return Err(Error::Usage(format!(
                    "{problem}; name that, or compute the features with {option} {name}"
                )));
            }
        }
        Ok(match (&self.groups.group, &self.groups.unit) {
            (None, None) => Independent::Segments,
            (Some(group), _) if plan.unit.as_ref() != Some(group) => Independent::Runs,
            _ => Independent::Units,
        })
    }

    fn report(&self, trained: &Trained, bytes: usize, told: &Told<'_>) -> Result<Report, Error> {
        let Told { sums, seconds: [first, all], tails } = told;
        let (print, peak) = (fingerprint(trained)?, peak_memory_mb());
        let rotor = description::rotor_warnings(trained);
        trained.left_out.summary().iter().chain(&trained.watch.warning).chain(&rotor).for_each(output::warn);
        let counts = &trained.statistics.counts;
        let json = json!({
            "model": self.exports.model,
            "bytes": bytes,
            "fingerprint": print,
            "classes": trained.classes,
            "segments": counts,
            "rows": sums.rows,
            "left_out": trained.left_out.count,
            "features": trained.feature_names,
            "method": method_word(trained.recipe.estimation.method),
            "segment_samples": trained.segment_samples,
            "novelty": description::gate_to_json(trained),
            "tails_from_segments": tails,
            "seconds": all,
            "seconds_of_first_pass": first,
            "rows_a_second": sums.rows as f64 / all,
            "peak_memory_mb": peak,
        });
        let segments: Vec<String> = trained.classes.iter().zip(counts).map(|(name, n)| format!("{n} {name}")).collect();
        let mut lines = vec![format!(
            "trained on segments: {}; features {}",
            segments.join(", "),
            trained.feature_names.join(", ")
        )];
        lines.extend(description::built(trained, bytes, &format!(" in {}", self.exports.model.display())));
        lines.extend(description::gate(trained));
        let peak = peak.map_or_else(String::new, |peak| format!(", {peak:.0} MB at most"));
        lines.push(format!("fingerprint {print}; {} rows in {all:.2} s{peak}", sums.rows));
        Ok(Report { lines, json })
    }
}

/// The largest resident memory of this process, MB; `None` where the system does not give it.
pub(super) fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string(Path::new("/proc/self/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
}
