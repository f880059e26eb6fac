//! The evaluation of a model on labelled traces, and what it finds, as text and as JSON.

use serde_json::{Map, Value};

use super::doubts::{irregular, refused};
use super::judging::judge;
use super::log::Log;
use super::model_file::ModelFile;
use super::notes::seen;
use super::selection::{Groups, Selection};
use super::source::Given;
use crate::Error;
use crate::core::features::Catalogue;
use crate::evaluate::{
    Breakdown, Chance, Confusion, Control, Discrimination, FalseAlarms, Judged, Rate, Stability, TraceVerdict,
    stability,
};
use crate::settings::Settings;
use crate::trace::Tally;
use crate::trace::labels::LabelledTrace;
use crate::train::label::label;
use crate::train::{Scores, features_of};

/// What is counted.
#[derive(Clone, Copy, Debug, Default, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JudgingOptions {
    /// Count segments instead of traces
    #[serde(default)]
    pub per_segment: bool,
}

/// A model, and what it is judged on.
#[derive(Debug)]
pub struct Judging<'a> {
    file: &'a ModelFile,
    settings: Settings,
    selection: Selection,
    options: JudgingOptions,
}

/// The verdicts of a model on labelled traces, and their rates.
#[derive(Debug)]
pub struct Evaluation {
    /// Trained classes, then others.
    pub classes: Vec<String>,
    /// Verdicts.
    pub verdicts: Vec<TraceVerdict>,
    /// The run of each trace, if it is known.
    pub runs: Option<Vec<String>>,
    /// Decisions by true class.
    pub confusion: Confusion,
    /// Scores of the posteriors.
    pub scores: Scores,
    /// What else is found.
    pub found: Findings,
    /// Column of the labels whose values the intervals count.
    column: Option<String>,
    /// Number of traces that the model was trained on.
    seen: usize,
    /// Number of segments with a covariate out of its range.
    outside: usize,
    /// What is missing in the recordings.
    missing: Tally,
}

impl<'a> Judging<'a> {
    /// By a model, settings, labels and a source of traces; the front end is that of the model.
    #[must_use]
    pub fn new(file: &'a ModelFile, settings: Settings, given: Given, options: JudgingOptions) -> Self {
        let selection = Selection::new(&settings, given, file.channels().clone());
        Self { file, settings, selection, options }
    }

    /// The labels and their traces.
    #[must_use]
    pub const fn selection(&self) -> &Selection {
        &self.selection
    }

    /// Reads the traces and judges them.
    ///
    /// # Errors
    /// Traces that cannot be read; labels or settings that do not fit the model.
    pub fn evaluate(&self, log: &Log<'_>) -> Result<Evaluation, Error> {
        let ModelFile { model, notes } = self.file;
        let (classes, traces) = self.traces()?;
        let groups = self.selection.groups(&self.settings.validation, &traces)?;
        groups.refuse_known(&notes.units)?;
        let (seen, words) = seen(&traces, (&notes.trained_on, &notes.contents));
        log.warn(words);
        log.warn(self.selection.left_out()?);
        log.warn(irregular(traces.iter().map(|t| &t.trace)));
        log.warn(refused(traces.iter().map(|t| &t.trace)));
        let verdicts = judge(model, &traces, notes.preparation(), log)?;
        let outside = outside(&verdicts, log);
        self.refuse_control_classes(&classes)?;
        let judged = Judged {
            verdicts: &verdicts,
            classes: &classes,
            trained: model.classes.len(),
            healthy: model.healthy(),
            groups: groups.clusters(),
            per_segment: self.options.per_segment,
        };
        let found = self.findings(&judged, &groups, &traces)?;
        let confusion = judged.confusion();
        let scores = Scores::of_verdicts(&verdicts, &model.priors(), self.options.per_segment);
        let by = &self.settings.validation;
        let column = by.unit.as_ref().or(by.group.as_ref()).cloned();
        let missing = traces.iter().map(|own| &own.trace).collect();
        Ok(Evaluation {
            classes,
            verdicts,
            runs: groups.runs,
            confusion,
            scores,
            found,
            column,
            seen,
            outside,
            missing,
        })
    }

    /// The classes, trained ones first, and the traces; untrained classes follow, since a gate can still distinguish
    /// them from healthy.
    fn traces(&self) -> Result<(Vec<String>, Vec<LabelledTrace>), Error> {
        let model = &self.file.model;
        let (names, mut traces) = self.selection.rows(&self.settings.validation.test_where)?;
        let mut classes = model.classes.clone();
        for labelled in &mut traces {
            let long = &names[labelled.class];
            // A class that the model does not have keeps its whole name.
            let cut = label(long).into_owned();
            let name = if model.classes.contains(&cut) { &cut } else { long };
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
        Ok((classes, traces))
    }

    fn refuse_control_classes(&self, classes: &[String]) -> Result<(), Error> {
        let untrained = &classes[self.file.model.classes.len()..];
        let stranger = self.settings.validation.control_classes.iter().find(|name| !untrained.contains(name));
        stranger.map_or(Ok(()), |name| {
            let problem = "is no class of these traces that the model was not trained on";
            Err(Error::Usage(format!("--control-classes: {name} {problem}")))
        })
    }

    fn findings(&self, judged: &Judged<'_>, groups: &Groups, traces: &[LabelledTrace]) -> Result<Findings, Error> {
        let ModelFile { model, notes } = self.file;
        let (by, verdicts) = (&self.settings.validation, judged.verdicts);
        let cells = |column: &String| Ok((column.clone(), self.selection.cells(column, traces)?));
        let columns = |names: &[String]| names.iter().map(cells).collect::<Result<Vec<_>, Error>>();
        let runs = groups.runs.as_ref();
        let by_run = runs.zip(model.healthy());
        // Without a named column, the one that told the runs of the training, if these labels have it too.
        let known = || notes.group.as_ref().and_then(|column| self.selection.cells(column, traces).ok());
        let units = judged.groups.map(<[String]>::to_vec).or_else(known);
        let (rates, controls) = (columns(&by.by)?, columns(&by.controls)?);
        Ok(Findings {
            by_run: by_run.map(|(runs, healthy)| FalseAlarms::of(verdicts, runs, healthy, self.options.per_segment)),
            chance: Chance::of(judged),
            roc_areas: Discrimination::all(&Judged { groups: units.as_deref(), ..*judged }, model, &notes.orders),
            by: rates.iter().map(|(column, cells)| Breakdown::of(judged, column, cells)).collect(),
            controls: controls.iter().map(|(column, cells)| Control::of(judged, column, cells)).collect(),
            untrained: untrained(judged, &by.control_classes),
            stability: runs.map_or_else(Vec::new, |runs| {
                stabilities(judged, runs, &model.catalogue(&notes.orders), &notes.features)
            }),
        })
    }
}

/// The number of segments with a covariate out of its range.
fn outside(verdicts: &[TraceVerdict], log: &Log<'_>) -> usize {
    let segments = || verdicts.iter().flat_map(|verdict| &verdict.segments);
    let outside = segments().filter(|segment| segment.outside.contains(&true)).count();
    if outside > 0 {
        let of = segments().count();
        log.warn([format!(
            "in {outside} of {of} segments a covariate is missing or outside the range of the training traces: the \
             verdict lacks the features that it explains"
        )]);
    }
    outside
}

impl Evaluation {
    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        let mut value = self.confusion.to_json();
        value["trained_on"] = self.seen.into();
        value["covariates_out_of_range"] = self.outside.into();
        value["missing_samples"] = self.missing.sum().to_json();
        self.found.add_to(&mut value);
        self.scores.add_to(&mut value);
        value
    }

    /// What is missing in the recordings as a line, if anything is.
    #[must_use]
    pub fn told_missing(&self) -> Option<String> {
        self.missing.line()
    }

    /// As lines.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![];
        // The confusion matrix is empty without a trace of a trained class.
        if self.confusion.total() > 0 {
            lines.push(format!("{}\n{}", self.confusion, self.scores.summary()));
            lines.extend(self.column.as_ref().map(|column| format!("intervals count values of {column}")));
        }
        lines.extend(self.told_missing());
        lines.extend(self.found.lines());
        lines
    }
}

/// What is found beside the confusion matrix.
#[derive(Debug)]
pub struct Findings {
    /// False alarms by run, if the runs are known.
    pub by_run: Option<FalseAlarms>,
    /// What chance alone would give.
    pub chance: Option<Chance>,
    /// How well each score distinguishes each class from healthy.
    pub roc_areas: Vec<Discrimination>,
    /// Rates by the values of columns.
    pub by: Vec<Breakdown>,
    /// Negative controls.
    pub controls: Vec<Control>,
    /// Classes that the model was not trained on.
    pub untrained: Vec<Untrained>,
    /// By class; only those classes that have enough runs.
    pub stability: Vec<(String, Vec<Stability>)>,
}

impl Findings {
    pub(crate) fn add_to(&self, value: &mut Value) {
        let rates = |control: bool| -> Map<_, _> {
            let own = self.untrained.iter().filter(|one| one.control == control);
            own.map(|one| (one.name.clone(), one.rate.to_json())).collect()
        };
        value["untrained_not_called_healthy"] = rates(false).into();
        value["controls_not_called_healthy"] = rates(true).into();
        value["chance"] = self.chance.as_ref().map_or(Value::Null, Chance::to_json);
        value["roc_areas"] = self.roc_areas.iter().map(Discrimination::to_json).collect();
        value["controls"] = self.controls.iter().map(Control::to_json).collect();
        let by = self.by.iter().map(|one| (one.column.clone(), one.to_json()));
        value["by"] = by.collect::<Map<_, _>>().into();
        if let Some(found) = &self.by_run {
            value["false_alarms_by_run"] = found.to_json();
            let each = |(class, rows): &(String, Vec<Stability>)| {
                (class.clone(), rows.iter().map(Stability::to_json).collect())
            };
            value["features_by_run"] = self.stability.iter().map(each).collect::<Map<_, _>>().into();
        }
    }

    /// Chance, false alarms, controls and untrained classes, as sentences.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let chance = self.chance.iter().map(ToString::to_string);
        let by_run = self.by_run.iter().map(|found| format!("false alarms {found}"));
        let controls = self.controls.iter().map(ToString::to_string);
        let untrained = self.untrained.iter().map(|Untrained { name, rate, control }| {
            let what = if *control { "negative control" } else { "not trained" };
            format!("{name}, {what}: not called healthy {rate}")
        });
        chance.chain(by_run).chain(controls).chain(untrained).collect()
    }

    pub(crate) fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.by.iter().map(ToString::to_string).chain(self.notes()).collect();
        lines.extend(self.roc_areas.iter().map(ToString::to_string));
        // The first class stands for the others of a model without a healthy one; JSON has all.
        for (class, rows) in self.stability.iter().take(1) {
            let runs = rows[0].runs;
            lines.push(format!("features of {class} over {runs} runs: likeness within a run (ICC), drift a run in"));
            lines.push("  standard deviations within a run, its p".into());
            lines.extend(rows.iter().map(|row| format!("  {row}")));
        }
        lines
    }
}

/// A class that the model was not trained on, and the rate of its traces or segments that are not called healthy.
#[derive(Debug)]
pub struct Untrained {
    name: String,
    rate: Rate,
    /// Whether it has no defect.
    control: bool,
}

pub(crate) fn untrained(judged: &Judged<'_>, controls: &[String]) -> Vec<Untrained> {
    let one = |(class, name): (usize, &String)| {
        let rate = judged.right(|k| judged.verdicts[k].class == class)?;
        Some(Untrained { name: name.clone(), rate, control: controls.contains(name) })
    };
    judged.classes.iter().enumerate().skip(judged.trained).filter_map(one).collect()
}

/// The stability of the model's features over runs: of the healthy class, or of each class without one.
pub(crate) fn stabilities(
    judged: &Judged<'_>,
    runs: &[String],
    catalogue: &Catalogue,
    features: &[String],
) -> Vec<(String, Vec<Stability>)> {
    let names = catalogue.names();
    let places: Vec<usize> = features.iter().filter_map(|name| names.iter().position(|own| own == name)).collect();
    let of_class = |class: usize| {
        let (mut rows, mut of_row) = (vec![], vec![]);
        for (verdict, run) in judged.verdicts.iter().zip(runs).filter(|(verdict, _)| verdict.class == class) {
            for segment in &verdict.segments {
                let (values, variances) = features_of(segment, catalogue);
                rows.push(places.iter().map(|&k| variances[k].is_finite().then_some(values[k])).collect());
                of_row.push(run.clone());
            }
        }
        let names: Vec<String> = places.iter().map(|&k| names[k].clone()).collect();
        (judged.classes[class].clone(), stability(&names, &rows, &of_row))
    };
    let classes = judged.healthy.map_or_else(|| (0..judged.trained).collect(), |healthy| vec![healthy]);
    classes.into_iter().map(of_class).filter(|(_, rows)| !rows.is_empty()).collect()
}
