//! Histories of judged drives, drawn from their recorded runs, and what watches them: the core's alarm by directions.

use bearing_watch::plan::RunTime;
use bearing_watch::{Decision, Evidence};
use model::core::Embedded;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Most runs that a history with a defect lasts.
pub(super) const LONGEST: u32 = 100;

/// Runs of healthy histories, and of all of them, a drive.
const HISTORY: usize = 1500;
const TOTAL: usize = 150_000;
/// Histories of each defect a drive.
const HISTORIES: u32 = 60;

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

/// What one watch finds of one drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Healthy histories.
    pub healthy: FalseAlarms,
    /// Histories of each of the defects.
    pub defective: Vec<Vec<Outcome>>,
}

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

/// What all histories of a drive share.
#[derive(Clone, Copy)]
pub(super) struct History {
    /// Length of a run, hours.
    pub(super) run_h: f64,
    pub(super) seed: u64,
}

/// Judges a watch by healthy runs and those with each defect, of which `taken` gives what it takes.
pub(super) fn judge<R, W: Watch>(
    start: &W,
    (healthy, defects): (&[Vec<R>], &[Vec<Vec<R>>]),
    taken: impl Fn(&[R]) -> Vec<W::Record>,
    history: History,
) -> Judged {
    let all = |runs: &[Vec<R>]| -> Vec<Vec<W::Record>> { runs.iter().map(|run| taken(run)).collect() };
    let of_defect = |(runs, place): (&Vec<Vec<R>>, u64)| defective(start, &all(runs), history.seed + place);
    Judged {
        healthy: undisturbed(start, &all(healthy), history),
        defective: defects.iter().zip(0..).map(of_defect).collect(),
    }
}

/// Draws healthy histories, each from `start` until its alarm or its end.
fn undisturbed<W: Watch>(start: &W, runs: &[Vec<W::Record>], History { run_h, seed }: History) -> FalseAlarms {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut false_alarms = FalseAlarms::default();
    let (mut watch, mut age) = (start.clone(), 0);
    for _ in 0..TOTAL {
        let alarm = watch.run(&runs[random.random_range(0..runs.len())]).is_some();
        age += 1;
        false_alarms.hours += run_h;
        false_alarms.alarms += usize::from(alarm);
        if alarm || age == HISTORY {
            (watch, age) = (start.clone(), 0);
        }
    }
    false_alarms
}

/// Draws histories whose bearing is defective from the first run on.
fn defective<W: Watch>(start: &W, runs: &[Vec<W::Record>], seed: u64) -> Vec<Outcome> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut one = |_| {
        let mut watch = start.clone();
        let mut next = || watch.run(&runs[random.random_range(0..runs.len())]);
        let alarm = (1..=LONGEST).find_map(|run| next().map(|direction| (run, direction)));
        Outcome { run: alarm.map(|alarm| alarm.0), direction: alarm.map(|alarm| alarm.1) }
    };
    (0..HISTORIES).map(&mut one).collect()
}
