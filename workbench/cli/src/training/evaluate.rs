//! `bearing-watch evaluate`

use std::path::{Path, PathBuf};

use bearing_watch::Counts;

use crate::command_line::jobs::Evaluate;
use crate::command_line::options::{Own, Taken};
use crate::command_line::output;
use model::Error;
use model::core::{Embedded, stuck_channels};
use model::evaluate::TraceVerdict;
use model::session::{Evaluation, Judging, JudgingOptions, ModelFile};
use pages::evaluation;
use pages::page::counted;
use pages::segments::Chosen;
use traces::given::{Memory, given_without_front_end};

/// Classify labelled traces by the embedded detector: confusion matrix and rates with 95 % intervals
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch evaluate --model model.bwm --labels held-out/labels.csv --json")]
pub(crate) struct Args {
    /// The binary model; it contains its channels and preparation
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    pub(crate) taken: Taken<Evaluate>,
    #[command(flatten)]
    options: Own<JudgingOptions>,
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

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let file = ModelFile::read(&args.model)?;
    let settings = args.taken.settings.clone();
    let given = given_without_front_end(&settings, Memory::default())?;
    let judging = Judging::new(&file, settings, given, args.options.0);
    let inputs = [judging.selection().inputs(), vec![args.model.clone()]].concat();
    output::plan(&[&args.out, &args.report].into_iter().flatten().map(PathBuf::as_path).collect::<Vec<_>>(), &inputs)?;
    let found = output::logged(|log| judging.evaluate(log))?;
    if let Some(path) = &args.out {
        output::write(path, csv(&file.model, &found.classes, &found.verdicts)?)?;
    }
    if let Some(path) = &args.report {
        output::write(path, args.taken.on_page(page(&args.model, &file, &found)))?;
    }
    if args.json { output::json("evaluate", found.to_json()) } else { found.lines().iter().try_for_each(output::say) }
}

fn page(path: &Path, file: &ModelFile, found: &Evaluation) -> String {
    let traces = counted(found.verdicts.len(), "trace");
    let lead = format!("{traces} through the embedded detector of {}.", path.display());
    let catalogue = file.model.catalogue(&file.notes.orders);
    let all = evaluation::Evaluation {
        model: &file.model,
        chosen: Chosen { catalogue: &catalogue, names: &file.notes.features },
        classes: &found.classes,
        verdicts: &found.verdicts,
        runs: found.runs.as_deref(),
        confusion: &found.confusion,
        scores: &found.scores,
        notes: &[found.told_missing().into_iter().collect(), found.found.notes()].concat(),
        by: &found.found.by,
        roc_areas: &found.found.roc_areas,
        stability: &found.found.stability,
    };
    evaluation::page(&lead, all).render()
}

/// Returns a CSV table with one row per segment.
fn csv(model: &Embedded, truths: &[String], verdicts: &[TraceVerdict]) -> Result<String, Error> {
    let (classes, names) = (&model.classes, &model.channel_names());
    let texts = |cells: &[&str]| cells.iter().map(ToString::to_string).collect::<Vec<_>>();
    let posteriors = classes.iter().map(|class| format!("p_{class}"));
    let odds: Vec<String> = posteriors.chain(texts(&["distance", "surprise"])).collect();
    let denied = texts(&["rows", "rejected", "saturated", "still", "stuck"]);
    let header = [texts(&["trace", "segment", "true_class", "decided"]), odds, denied];
    let mut rows = vec![header.concat()];
    for verdict in verdicts {
        for (k, segment) in verdict.segments.iter().enumerate() {
            let decided = segment.verdict.as_ref().map_or("undetermined", |finding| finding.name(classes));
            let posterior = |k: usize| segment.posteriors.get(k).map_or_else(String::new, ToString::to_string);
            let Counts { rejected, saturated, resting, stuck, .. } = segment.counts;
            let numbers = [segment.rows, rejected, saturated, resting].map(|count| count.to_string());
            let denied = [&numbers[..], &[stuck_channels(stuck, names).join(" ")]].concat();
            let place = texts(&[&verdict.id, &k.to_string(), &truths[verdict.class], decided]);
            let far = [segment.distance, segment.surprise].map(|x| x.to_string());
            rows.push([place, (0..classes.len()).map(posterior).chain(far).collect(), denied].concat());
        }
    }
    output::csv(&rows)
}
