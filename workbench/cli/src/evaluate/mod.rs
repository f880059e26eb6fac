//! `bearing-watch evaluate`

mod found;

use std::path::PathBuf;

use bearing_watch::Counts;

use crate::args::traces::{Given, GroupArgs, Selection, SelectionArgs, warn_irregular, warn_refused};
use crate::drive::on_page;
use crate::model_file::{Notes, judge, read_model};
use crate::output;
use found::{Found, stabilities, untrained};
use model::Error;
use model::core::{Embedded, stuck_channels};
use model::evaluate::{Breakdown, Chance, Confusion, Control, FalseAlarms, Judged, TraceVerdict};
use model::trace::{Condition, stem};
use model::train::Scores;
use pages::evaluation;
use pages::page::counted;
use pages::segments::Chosen;

/// Classify labelled traces by the embedded detector: confusion matrix and rates with 95 % intervals
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch evaluate --model model.bwm --labels held-out/labels.csv --json")]
pub(crate) struct Args {
    /// The binary model; it contains its channels and preparation
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    choice: Choice,
    /// Write every verdict to this CSV
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write a page with tables and plots
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print JSON: classes, confusion, error_rate, balanced_accuracy, log_score, brier_score, each with its interval,
    /// and chance; with --group false_alarms_by_run and features_by_run; with --by and --controls by and controls
    #[arg(long)]
    json: bool,
}

/// What a model is evaluated on, and what is counted.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Choice {
    #[command(flatten)]
    selection: SelectionArgs,
    /// Only the rows with this, e.g. 'run>4'; may be repeated, all must hold
    #[arg(long, value_name = "CONDITION")]
    test_where: Vec<Condition>,
    /// Count segments instead of traces
    #[arg(long)]
    per_segment: bool,
    #[command(flatten)]
    groups: GroupArgs,
    /// Break the rates down by the values of these columns of the labels, e.g. load_kgf,level
    #[arg(long, value_name = "COLUMNS", value_delimiter = ',')]
    by: Vec<String>,
    /// Negative controls: columns of the labels that are unrelated to the bearing, e.g. session; verdicts on healthy
    /// traces should not depend on them
    #[arg(long, value_name = "COLUMNS", value_delimiter = ',')]
    controls: Vec<String>,
    /// Negative controls: classes without a defect that the model was not trained on, e.g. regreased; they should be
    /// called healthy
    #[arg(long, value_name = "CLASSES", value_delimiter = ',')]
    control_classes: Vec<String>,
}

/// The verdicts of a model on labelled traces, and their rates.
pub(crate) struct Evaluation {
    /// Trained classes, then others.
    classes: Vec<String>,
    verdicts: Vec<TraceVerdict>,
    /// The run of each trace, if it is known.
    runs: Option<Vec<String>>,
    confusion: Confusion,
    scores: Scores,
    found: Found,
    /// Column of the labels whose values the intervals count.
    column: Option<String>,
    /// Number of traces that the model was trained on.
    seen: usize,
    /// Number of segments with a covariate out of its range.
    outside: usize,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let (model, notes) = read_model(&args.model)?;
    let selection = args.choice.selection.read(&notes.channels(), Given::default())?;
    let inputs = [selection.inputs(), vec![args.model.clone()]].concat();
    output::plan(&[&args.out, &args.report].into_iter().flatten().map(PathBuf::as_path).collect::<Vec<_>>(), &inputs)?;
    let found = args.choice.of_selection((&model, &notes), &selection)?;
    if let Some(path) = &args.out {
        output::write(path, csv(&model, &found.classes, &found.verdicts)?)?;
    }
    if let Some(path) = &args.report {
        let traces = counted(found.verdicts.len(), "trace");
        let lead = format!("{traces} through the embedded detector of {}.", args.model.display());
        output::write(path, on_page(found.page(&lead, &model, &notes)))?;
    }
    if args.json { output::json(&found.to_json()) } else { found.lines().iter().try_for_each(output::say) }
}

impl Choice {
    /// Evaluates a model on what is given in memory, and on files for the rest.
    pub(crate) fn evaluate(&self, model: (&Embedded, &Notes), given: Given) -> Result<Evaluation, Error> {
        self.of_selection(model, &self.selection.read(&model.1.channels(), given)?)
    }

    fn of_selection(&self, (model, notes): (&Embedded, &Notes), selection: &Selection) -> Result<Evaluation, Error> {
        let (names, mut traces) = selection.rows(&self.test_where)?;
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
        let groups = self.groups.read(selection, &traces)?;
        groups.refuse_known(&notes.units)?;
        let seen = traces.iter().filter(|t| notes.trained_on.iter().any(|id| id == stem(&t.trace.id))).count();
        if seen > 0 {
            output::warn(format!("{seen} of {} traces were trained on: the rates flatter the model", traces.len()));
        }
        warn_irregular(traces.iter().map(|t| &t.trace));
        warn_refused(traces.iter().map(|t| &t.trace));
        let verdicts = judge(model, &traces, notes.preparation())?;
        let segments = || verdicts.iter().flat_map(|verdict| &verdict.segments);
        let outside = segments().filter(|segment| segment.outside.contains(&true)).count();
        if outside > 0 {
            let of = segments().count();
            output::warn(format!(
                "in {outside} of {of} segments a covariate is missing or outside the range of the training traces: the \
                 verdict lacks the features that it explains"
            ));
        }
        if let Some(name) = self.control_classes.iter().find(|name| !classes[model.classes.len()..].contains(name)) {
            let problem = "is no class of these traces that the model was not trained on";
            return Err(Error::Usage(format!("--control-classes: {name} {problem}")));
        }
        let judged = Judged {
            verdicts: &verdicts,
            classes: &classes,
            trained: model.classes.len(),
            healthy: model.healthy(),
            groups: groups.clusters(),
            per_segment: self.per_segment,
        };
        let cells = |column: &String| Ok((column.clone(), selection.cells(column, &traces)?));
        let columns = |names: &[String]| names.iter().map(cells).collect::<Result<Vec<_>, Error>>();
        let found = Found {
            by_run: groups
                .runs
                .as_ref()
                .zip(model.healthy())
                .map(|(runs, healthy)| FalseAlarms::of(&verdicts, runs, healthy, self.per_segment)),
            chance: Chance::of(&judged),
            by: columns(&self.by)?.iter().map(|(column, cells)| Breakdown::of(&judged, column, cells)).collect(),
            controls: columns(&self.controls)?
                .iter()
                .map(|(column, cells)| Control::of(&judged, column, cells))
                .collect(),
            untrained: untrained(&judged, &self.control_classes),
            stability: groups.runs.as_ref().map_or_else(Vec::new, |runs| {
                stabilities(&judged, runs, &model.catalogue(&notes.orders), &notes.features)
            }),
        };
        let confusion = judged.confusion();
        let scores = Scores::of_verdicts(&verdicts, &model.priors(), self.per_segment);
        let column = self.groups.unit.as_ref().or(self.groups.group.as_ref()).cloned();
        Ok(Evaluation { classes, verdicts, runs: groups.runs, confusion, scores, found, column, seen, outside })
    }
}

impl Evaluation {
    fn page(&self, lead: &str, model: &Embedded, notes: &Notes) -> String {
        let catalogue = model.catalogue(&notes.orders);
        let all = evaluation::Evaluation {
            model,
            chosen: Chosen { catalogue: &catalogue, names: &notes.features },
            classes: &self.classes,
            verdicts: &self.verdicts,
            runs: self.runs.as_deref(),
            confusion: &self.confusion,
            scores: &self.scores,
            notes: &self.found.notes(),
            by: &self.found.by,
            stability: &self.found.stability,
        };
        evaluation::page(lead, all).render()
    }

    pub(crate) fn to_json(&self) -> serde_json::Value {
        let mut value = self.confusion.to_json();
        value["trained_on"] = self.seen.into();
        value["covariates_out_of_range"] = self.outside.into();
        self.found.add_to(&mut value);
        self.scores.add_to(&mut value);
        value
    }

    pub(crate) fn lines(&self) -> Vec<String> {
        let mut lines = vec![];
        // The confusion matrix is empty without a trace of a trained class.
        if self.confusion.total() > 0 {
            lines.push(format!("{}\n{}", self.confusion, self.scores.summary()));
            lines.extend(self.column.as_ref().map(|column| format!("intervals count values of {column}")));
        }
        lines.extend(self.found.lines());
        lines
    }
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
