//! What watches the runs of a drive: the core's alarm by directions.

use bearing_watch::plan::RunTime;
use bearing_watch::{Decision, Evidence};
use model::core::Embedded;

/// A monitor of one drive, on records that are drawn again and again.
pub(super) trait Watch: Clone {
    /// What it takes of a record.
    type Record;

    /// Observes the records of a run, and ends it; gives what raised an alarm.
    fn run(&mut self, records: &[Self::Record]) -> Option<usize>;
}

/// The core's alarm.
#[derive(Clone, Debug)]
pub(super) struct Core(Evidence<RunTime>);

impl Core {
    /// Of a drive that is not yet known.
    pub(super) fn new(model: &Embedded) -> Self {
        Self(model.evidence())
    }
}

impl Watch for Core {
    /// `None` for a record without a verdict.
    type Record = Option<Decision<RunTime>>;

    fn run(&mut self, records: &[Self::Record]) -> Option<usize> {
        for record in records {
            self.0.observe(record.as_ref());
        }
        self.0.end_run()?;
        self.0.main_contribution().map(|main| main.direction.into())
    }
}
