//! Performance of a model on traces that were not used for training, by running the core on them.

mod breakdown;
mod by_run;
mod chance;
mod confusion;
mod judged;
mod rate;
mod stability;

use std::collections::HashMap;

use crate::Error;
use crate::core::{Embedded, Finding, SegmentReport};
use crate::trace::labels::LabelledTrace;
use rayon::prelude::*;

pub use breakdown::Breakdown;
pub use by_run::{FalseAlarms, RunAlarms};
pub use chance::{Chance, Control, Exchange};
pub use confusion::Confusion;
pub use judged::Judged;
pub use rate::Rate;
pub use stability::{Stability, stability};

/// Verdicts on one labelled trace.
#[derive(Clone, Debug)]
pub struct TraceVerdict {
    /// Trace id.
    pub id: String,
    /// True class.
    pub class: usize,
    /// Verdict over the whole trace.
    pub decided: Option<Finding>,
    /// Posteriors over the whole trace; empty if undetermined.
    pub posteriors: Vec<f32>,
    /// Its segments.
    pub segments: Vec<SegmentReport>,
}

impl TraceVerdict {
    /// The finding on the trace, or those on its segments; `None` is undetermined.
    #[must_use]
    pub fn findings(&self, per_segment: bool) -> Vec<Option<Finding>> {
        if per_segment {
            self.segments.iter().map(|segment| segment.verdict.as_ref().ok().copied()).collect()
        } else {
            vec![self.decided]
        }
    }
}

/// Runs traces through the core; `done` is called once per trace.
///
/// # Errors
/// The core rejects the model.
pub fn run(model: &Embedded, traces: &[LabelledTrace], done: impl Fn() + Sync) -> Result<Vec<TraceVerdict>, Error> {
    let each = |labelled: &LabelledTrace| {
        let segments = model.run(&labelled.trace);
        let (decided, posteriors) = model.combine(&segments).unzip();
        done();
        Ok(TraceVerdict {
            id: labelled.trace.id.clone(),
            class: labelled.class,
            decided,
            posteriors: posteriors.unwrap_or_default(),
            segments,
        })
    };
    traces.par_iter().map(each).collect()
}

/// Counts verdicts per trace or per segment. `groups` names the group (run, drive) of each verdict; without it,
/// segments of a trace are alike and traces independent.
#[must_use]
pub fn count(classes: &[String], verdicts: &[TraceVerdict], groups: Option<&[String]>, per_segment: bool) -> Confusion {
    Judged { verdicts, classes, trained: classes.len(), healthy: None, groups, per_segment }.confusion()
}

/// The number of each name in the order of first appearance, and how many different ones there are.
fn numbered(names: &[String]) -> (Vec<usize>, usize) {
    let mut known: HashMap<&str, usize> = HashMap::new();
    let mut places = Vec::with_capacity(names.len());
    for name in names {
        let next = known.len();
        places.push(*known.entry(name).or_insert(next));
    }
    (places, known.len())
}
