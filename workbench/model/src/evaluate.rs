//! Performance of a model on traces that were not used for training, by running the core on them.

mod breakdown;
mod by_run;
mod chance;
mod confusion;
mod discrimination;
mod judged;
mod rate;
mod roc;
mod stability;
mod verdict;

pub use breakdown::Breakdown;
pub use by_run::{FalseAlarms, RunAlarms};
pub use chance::{Chance, Control, Exchange};
pub use confusion::Confusion;
pub use discrimination::{Discrimination, area_words};
pub use judged::Judged;
pub use rate::Rate;
pub use roc::{Areas, Scored};
pub use stability::{Stability, stability};
pub use verdict::{TraceVerdict, run};

/// Counts verdicts per trace or per segment. `groups` names the group (run, drive) of each verdict; without it,
/// segments of a trace are alike and traces independent.
#[must_use]
pub fn count(classes: &[String], verdicts: &[TraceVerdict], groups: Option<&[String]>, per_segment: bool) -> Confusion {
    Judged { verdicts, classes, trained: classes.len(), healthy: None, groups, per_segment }.confusion()
}
