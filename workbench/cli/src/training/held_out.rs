//! How good a trained model is, on traces that it was not trained on.

use super::{Session, Training};
use crate::args::traces::Groups;
use crate::model_file::judge;
use model::Error;
use model::evaluate::{Confusion, FalseAlarms, Judged, TraceVerdict};
use model::trace::labels::LabelledTrace;
use model::train::{Forward, Ranking, Scores};
use pages::training::Worth;

/// Traces that were not used in training, with their verdicts.
pub(crate) struct HeldOut {
    pub(crate) confusion: Confusion,
    verdicts: Vec<TraceVerdict>,
    pub(crate) scores: Scores,
    /// False alarms by run, if the runs are known.
    pub(crate) false_alarms: Option<FalseAlarms>,
}

impl HeldOut {
    pub(crate) fn to_json(&self) -> serde_json::Value {
        let mut value = self.confusion.to_json();
        self.scores.add_to(&mut value);
        if let Some(found) = &self.false_alarms {
            value["false_alarms_by_run"] = found.to_json();
        }
        value
    }
}

/// Results on the quality of the model.
pub(crate) struct Found {
    pub(crate) held_out: Option<HeldOut>,
    /// Only if no traces were held out.
    pub(crate) cross_validated: Option<Result<Scores, Error>>,
    /// Gates of the first runs on later ones; only if no traces were held out.
    pub(crate) forward: Vec<Forward>,
    pub(crate) ranking: Option<Ranking>,
}

impl Found {
    pub(crate) fn worth(&self) -> Worth<'_> {
        Worth {
            training: &[],
            held_out: self.held_out.as_ref().map(|h| (&h.confusion, h.verdicts.as_slice(), &h.scores)),
            cross_validated: self.cross_validated.as_ref().map(Result::as_ref),
            ranking: self.ranking.as_ref(),
        }
    }
}

impl Session {
    /// Evaluates the model on the traces that the settings hold out, if they do; otherwise cross-validates it.
    pub(crate) fn found(&self, own: &Training, rank: bool) -> Result<Found, Error> {
        let trained = &own.trained;
        let held_out = own.held_out.as_ref().map(|held_out| evaluate(held_out, own)).transpose()?;
        Ok(Found {
            cross_validated: held_out.is_none().then(|| trained.cross_validated()),
            forward: if held_out.is_none() { trained.forward() } else { vec![] },
            ranking: rank.then(|| trained.rank()).transpose()?,
            held_out,
        })
    }

    /// Reads the traces of `--test-where`; those of training, and units of theirs, are refused.
    pub(super) fn held_out(
        &self,
        (classes, training): (&[String], &[LabelledTrace]),
        units: &[String],
    ) -> Result<Option<(Vec<LabelledTrace>, Groups)>, Error> {
        let Self { settings, selection, .. } = self;
        if settings.test_where.is_empty() {
            return Ok(None);
        }
        let (names, mut traces) = selection.rows(&settings.test_where)?;
        for held_out in &mut traces {
            let name = &names[held_out.class];
            held_out.class = classes.iter().position(|class| class == name).ok_or_else(|| {
                Error::Usage(format!("--test-where selects class {name}, which has no training traces"))
            })?;
        }
        if let Some(both) = traces.iter().find(|t| training.iter().any(|s| s.trace.id == t.trace.id)) {
            let id = &both.trace.id;
            return Err(Error::Usage(format!(
                "trace {id} is in both --train-where and --test-where; make them disjoint"
            )));
        }
        let groups = settings.validation.groups.read(selection, &traces)?;
        groups.refuse_known(units)?;
        Ok(Some((traces, groups)))
    }
}

fn evaluate((traces, groups): &(Vec<LabelledTrace>, Groups), own: &Training) -> Result<HeldOut, Error> {
    let Training { trained, host, .. } = own;
    let model = trained.embed()?;
    let verdicts = judge(&model, traces, *host)?;
    let scores = Scores::of_verdicts(&verdicts, &model.priors(), false);
    let judged = Judged {
        verdicts: &verdicts,
        classes: &trained.classes,
        trained: trained.classes.len(),
        healthy: model.healthy(),
        groups: groups.clusters(),
        per_segment: false,
    };
    let confusion = judged.confusion();
    let by_run = groups.runs.as_ref().zip(model.healthy());
    let false_alarms = by_run.map(|(runs, healthy)| FalseAlarms::of(&verdicts, runs, healthy, false));
    Ok(HeldOut { confusion, verdicts, scores, false_alarms })
}
