//! How good a trained model is, on traces that it was not trained on.

use super::result::Training;
use crate::Error;
use crate::evaluate::{Confusion, FalseAlarms, Judged, TraceVerdict};
use crate::session::judging::judge;
use crate::session::log::Log;
use crate::session::selection::Groups;
use crate::trace::labels::LabelledTrace;
use crate::train::{Forward, Ranking, Scores};

/// Traces that were not used in training, with their verdicts.
#[derive(Debug)]
pub struct HeldOut {
    /// Decisions by true class.
    pub confusion: Confusion,
    /// Verdicts.
    pub verdicts: Vec<TraceVerdict>,
    /// Scores of the posteriors.
    pub scores: Scores,
    /// False alarms by run, if the runs are known.
    pub false_alarms: Option<FalseAlarms>,
}

impl HeldOut {
    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        let mut value = self.confusion.to_json();
        self.scores.add_to(&mut value);
        if let Some(found) = &self.false_alarms {
            value["false_alarms_by_run"] = found.to_json();
        }
        value
    }
}

/// Results on the quality of the model.
#[derive(Debug)]
pub struct Found {
    /// On the traces that were held out, if any were.
    pub held_out: Option<HeldOut>,
    /// Only if no traces were held out.
    pub cross_validated: Option<Result<Scores, Error>>,
    /// Healthy segments that a gate of the other folds calls novel; only with a gate, and if no traces were held out.
    pub false_alarms: Option<Result<FalseAlarms, Error>>,
    /// Gates of the first runs on later ones; only if no traces were held out.
    pub forward: Vec<Forward>,
    /// The features by what they contribute, if wanted.
    pub ranking: Option<Ranking>,
}

/// Traces that are held out, with their groups.
pub(crate) type Held = (Vec<LabelledTrace>, Groups);

/// The verdicts of a model on traces that were not used in its training.
pub(crate) fn evaluate((traces, groups): &Held, own: &Training, log: &Log<'_>) -> Result<HeldOut, Error> {
    let Training { trained, host, .. } = own;
    let model = trained.embed()?;
    let verdicts = judge(&model, traces, *host, log)?;
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
