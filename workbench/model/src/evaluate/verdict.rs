//! Labelled traces → verdicts of the core.

use rayon::prelude::*;

use crate::Error;
use crate::core::{Embedded, Finding, SegmentReport};
use crate::trace::labels::LabelledTrace;

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
