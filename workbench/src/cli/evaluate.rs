//! `bearing-watch evaluate`

use std::path::PathBuf;

use bearing_watch::Counts;

use super::args::traces::{SelectionArgs, warn_irregular, warn_refused};
use super::model_file::{check_rate, prepare, read_model};
use super::output;
use crate::Error;
use crate::core::{Embedded, Finding, stuck_channels};
use crate::evaluate::{self, Confusion, FalseAlarms, Rate, TraceVerdict};
use crate::trace::{Condition, stem};
use crate::train::Scores;

/// Classify labelled traces by the embedded detector: confusion matrix and rates with 95 % intervals
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch evaluate --model model.bwm --labels held-out/labels.csv --json")]
pub(super) struct Args {
    /// The binary model; it contains its channels and preparation
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    selection: SelectionArgs,
    /// Only the rows with this, e.g. 'run>4'; may be repeated, all must hold
    #[arg(long, value_name = "CONDITION")]
    test_where: Vec<Condition>,
    /// Count segments instead of traces
    #[arg(long)]
    per_segment: bool,
    /// Give false alarms of healthy traces by the value in this column of the labels, e.g. run, in the order of the
    /// labels
    #[arg(long, value_name = "COLUMN")]
    group: Option<String>,
    /// Write every verdict to this CSV
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print JSON: classes, confusion, error_rate, balanced_accuracy, log_score, brier_score, each with its interval;
    /// with --group false_alarms_by_run
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let (model, notes) = read_model(&args.model)?;
    let selection = args.selection.read(&notes.channels())?;
    let inputs = [selection.inputs(&args.selection.labels), vec![args.model.clone()]].concat();
    output::plan(&args.out.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &inputs)?;
    let (names, mut traces) = selection.rows(&args.test_where)?;
    // Untrained classes follow the trained ones: a gate can still distinguish them from healthy.
    let mut classes = model.classes.clone();
    for labelled in &mut traces {
        let name = &names[labelled.class];
        if !classes.contains(name) {
            if model.healthy().is_none() {
                let known = model.classes.join(", ");
                let problem = format!("unknown class {name}: the model has {known}; select with --classes");
                return Err(Error::trace(&labelled.trace.id, problem));
            }
            classes.push(name.clone());
        }
        labelled.class = classes.iter().position(|class| class == name).unwrap_or(0);
    }
    let seen = traces.iter().filter(|t| notes.trained_on.iter().any(|id| id == stem(&t.trace.id))).count();
    if seen > 0 {
        output::warn(format!("{seen} of {} traces were trained on: the rates flatter the model", traces.len()));
    }
    warn_irregular(traces.iter().map(|t| &t.trace));
    warn_refused(traces.iter().map(|t| &t.trace));
    check_rate(&model, notes.preparation(), traces.iter().map(|t| &t.trace))?;
    let mut runs = selection.groups(args.group.as_deref(), &traces)?;
    if runs.is_some() && model.healthy().is_none() {
        if super::drive::given().is_none() {
            return Err(Error::Usage("--group gives false alarms, but the model has no healthy class".into()));
        }
        output::warn("the model has no healthy class: no false alarms by run");
        runs = None;
    }
    let bar = output::progress("evaluating", traces.len());
    let verdicts = evaluate::run(&model, &prepare(&traces, notes.preparation())?, || bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(path) = &args.out {
        output::write(path, csv(&model, &classes, &verdicts)?)?;
    }
    let segments = || verdicts.iter().flat_map(|verdict| &verdict.segments);
    let outside = segments().filter(|segment| segment.outside.contains(&true)).count();
    if outside > 0 {
        let of = segments().count();
        output::warn(format!(
            "in {outside} of {of} segments a covariate is missing or outside the range of the training traces: the \
             verdict lacks the features that it explains"
        ));
    }
    let by_run = runs.zip(model.healthy());
    let by_run = by_run.map(|(runs, healthy)| FalseAlarms::of(&verdicts, &runs, healthy, args.per_segment));
    let (verdicts, strange): (Vec<_>, Vec<_>) = verdicts.into_iter().partition(|v| v.class < model.classes.len());
    let untrained = untrained(&model, &classes, &strange, args.per_segment);
    let confusion =
        Confusion { healthy: model.healthy(), ..evaluate::count(&model.classes, &verdicts, args.per_segment) };
    let scores = Scores::of_verdicts(&verdicts, &model.priors(), args.per_segment);
    if args.json {
        let mut value = confusion.to_json();
        let rates = untrained.iter().map(|(name, rate)| (name.clone(), rate.to_json()));
        value["untrained_not_called_healthy"] = serde_json::Value::Object(rates.collect());
        value["trained_on"] = seen.into();
        value["covariates_out_of_range"] = outside.into();
        if let Some(found) = &by_run {
            value["false_alarms_by_run"] = found.to_json();
        }
        scores.add_to(&mut value);
        output::json(&value)
    } else {
        // The confusion matrix is empty without a trace of a trained class.
        if confusion.total() > 0 {
            output::say(format!("{confusion}\n{}", scores.summary()))?;
        }
        by_run.map_or(Ok(()), |found| output::say(format!("false alarms {found}")))?;
        untrained
            .iter()
            .try_for_each(|(name, rate)| output::say(format!("{name}, not trained: not called healthy {rate}")))
    }
}

/// Returns, for each untrained class, the rate of traces or segments that are not classified as healthy.
fn untrained(
    model: &Embedded,
    classes: &[String],
    verdicts: &[TraceVerdict],
    per_segment: bool,
) -> Vec<(String, Rate)> {
    let healthy = model.healthy().map(Finding::Class);
    let rate = |(class, name): (usize, &String)| {
        let own = verdicts.iter().filter(|v| v.class == class);
        let found: Vec<Option<Finding>> = if per_segment {
            own.flat_map(|v| v.segments.iter().map(|s| s.verdict.clone().ok())).collect()
        } else {
            own.map(|v| v.decided).collect()
        };
        (name.clone(), Rate::wilson(found.iter().filter(|found| **found != healthy).count(), found.len()))
    };
    classes.iter().enumerate().skip(model.classes.len()).map(rate).collect()
}

/// Returns a CSV table with one row per segment.
fn csv(model: &Embedded, truths: &[String], verdicts: &[TraceVerdict]) -> Result<String, Error> {
    let (classes, names) = (&model.classes, &model.channel_names());
    let texts = |cells: &[&str]| cells.iter().map(ToString::to_string).collect::<Vec<_>>();
    let posteriors = classes.iter().map(|class| format!("p_{class}"));
    let odds: Vec<String> = posteriors.chain(texts(&["distance", "surprise"])).collect();
    let denied = texts(&["rows", "rejected", "saturated", "downweighted", "still", "stuck"]);
    let header = [texts(&["trace", "segment", "true_class", "decided"]), odds, denied];
    let mut rows = vec![header.concat()];
    for verdict in verdicts {
        for (k, segment) in verdict.segments.iter().enumerate() {
            let decided = segment.verdict.as_ref().map_or("undetermined", |finding| finding.name(classes));
            let posterior = |k: usize| segment.posteriors.get(k).map_or_else(String::new, ToString::to_string);
            let Counts { rejected, saturated, downweighted, resting, stuck, .. } = segment.counts;
            let numbers = [segment.rows, rejected, saturated, downweighted, resting].map(|count| count.to_string());
            let denied = [&numbers[..], &[stuck_channels(stuck, names).join(" ")]].concat();
            let place = texts(&[&verdict.id, &k.to_string(), &truths[verdict.class], decided]);
            let far = [segment.distance, segment.surprise].map(|x| x.to_string());
            rows.push([place, (0..classes.len()).map(posterior).chain(far).collect(), denied].concat());
        }
    }
    output::csv(&rows)
}
