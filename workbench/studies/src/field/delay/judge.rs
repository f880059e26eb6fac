//! Histories of judged drives, drawn from their recorded runs.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::watch::{Record, Watch};

/// Most runs that a history with a defect lasts.
pub(super) const LONGEST: u32 = 100;

/// Runs of one drive.
pub(super) type Runs = Vec<Vec<Record>>;

/// Alarms of healthy histories.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FalseAlarms {
    /// Number of alarms.
    pub alarms: usize,
    /// Hours of all histories.
    pub hours: f64,
}

impl FalseAlarms {
    /// Mean hours between false alarms; without one, at least this.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.hours / self.alarms.max(1) as f64
    }
}

/// End of a history with a defect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Number of the run with the alarm, the first with the defect is 1; `None` without one.
    pub run: Option<u32>,
    /// The direction that raised it.
    pub direction: Option<usize>,
}

/// Draws healthy histories of so many runs in all, each from `start` until its alarm or its end.
pub(super) fn healthy(
    start: &Watch<'_>,
    runs: &Runs,
    (total, length): (usize, usize),
    (run_h, seed): (f64, u64),
) -> FalseAlarms {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut false_alarms = FalseAlarms::default();
    let (mut watch, mut age) = (start.clone(), 0);
    for _ in 0..total {
        let alarm = one_run(&mut watch, &runs[random.random_range(0..runs.len())]).is_some();
        age += 1;
        false_alarms.hours += run_h;
        false_alarms.alarms += usize::from(alarm);
        if alarm || age == length {
            (watch, age) = (start.clone(), 0);
        }
    }
    false_alarms
}

/// Draws histories whose bearing is defective from the first run on.
pub(super) fn defective(start: &Watch<'_>, runs: &Runs, histories: u32, seed: u64) -> Vec<Outcome> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut one = |_| {
        let mut watch = start.clone();
        let mut next = || one_run(&mut watch, &runs[random.random_range(0..runs.len())]);
        let alarm = (1..=LONGEST).find_map(|run| next().map(|direction| (run, direction)));
        Outcome { run: alarm.map(|alarm| alarm.0), direction: alarm.map(|alarm| alarm.1) }
    };
    (0..histories).map(&mut one).collect()
}

/// Observes a run and ends it; gives the direction that raised an alarm.
pub(super) fn one_run(watch: &mut Watch<'_>, run: &[Record]) -> Option<usize> {
    let mut raised = None;
    for record in run {
        raised = raised.or(watch.observe(record));
    }
    watch.end_run();
    raised
}
