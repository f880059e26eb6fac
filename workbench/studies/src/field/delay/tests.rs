use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::render::{delay, hours};
use super::twin::{Record, Twin};
use super::*;
use model::train::directions::{Direction, Levels};

fn outcome(run: u32) -> Outcome {
    Outcome { run: (run > 0).then_some(run), direction: (run > 0).then_some(run as usize % 2) }
}

#[test]
fn histories_without_an_alarm_count_as_none() {
    let delays = delay(&[1, 3, 3, 5, 7, 0, 0, 0, 0, 0].map(outcome), |direction| direction == 1);
    assert_eq!((delays.median, delays.most, delays.soon, delays.right), (None, None, 0.5, 1.0));
    let delays = delay(&[2, 3, 3, 5, 7, 30, 9, 9, 4, 0].map(outcome), |direction| direction == 1);
    assert_eq!((delays.median, delays.most, delays.soon), (Some(7), None, 0.8));
    assert!((delays.right - 6.0 / 9.0).abs() < 1e-12);
}

#[test]
fn hours_by_hand() {
    let drive = |alarms| FalseAlarms { alarms, hours: 5000.0 };
    let hours_of = hours(&[drive(0), drive(1), drive(10)], 1000.0);
    assert_eq!((hours_of.below, hours_of.median, hours_of.worst), ([1, 3], 5000.0, 500.0));
    // Eleven alarms: 95 % of Poisson means from 5.49 to 19.68.
    let [mean, low, high] = hours_of.pooled;
    assert!((mean - 15_000.0 / 11.0).abs() < 1e-6 && (low - 15_000.0 / 19.68).abs() < 1.0, "{low}");
    assert!((high - 15_000.0 / 5.49).abs() < 3.0, "{high}");
}

#[test]
fn training_and_judged_drives_differ_and_sessions_have_their_own_temperature() {
    let condition = conditions()[0];
    let cell = |purpose| Cell { purpose, repetition: 0, condition, defect: Defect::HEALTHY };
    let current = |purpose, place| record(cell(purpose), place).expect("simulates").trace.y;
    assert_ne!(current(Purpose::Training, [0, 0, 0]), current(Purpose::Validation, [0, 0, 0]));
    assert_eq!(current(Purpose::Training, [0, 0, 0]), current(Purpose::Training, [0, 0, 0]));
    assert!(record(cell(Purpose::Training), [0, 0, 99]).is_err());
    assert_eq!(conditions().iter().map(|condition| condition.name).collect::<Vec<_>>(), ["field-sine", "field-any"]);
}

#[test]
fn a_small_fleet_finds_what_is_large_and_keeps_its_hours() {
    let training = Fleet { units: 18, sessions: 3 };
    let settings = Settings { training, records: 4, drives: 2, healthy: 12, defective: 2, ..Settings::STANDARD };
    let draws = draw(conditions()[0], 0, &settings).expect("simulates");
    println!("{}", text(std::slice::from_ref(&draws), &settings));
    let runs = |drive: &Judgement, place: usize| -> Vec<u32> {
        drive.judged[1].defective[place].iter().map(|outcome| outcome.run.unwrap_or(u32::MAX)).collect()
    };
    for drive in &draws.drives {
        // Full size takes two runs: one run never suffices, and three are plenty.
        assert!(runs(drive, 0).iter().all(|run| (2..=3).contains(run)), "{:?}", runs(drive, 0));
        // What no record tells is not found at once either.
        assert!(runs(drive, 4).iter().filter(|run| **run <= 2).count() <= 6, "{:?}", runs(drive, 4));
        // Two runs tell the mean of a sixteenth no better than to half a deviation of runs.
        assert!(drive.bounds[0] < 1.0 && drive.bounds[4] > 10.0 * drive.bounds[0], "{:?}", drive.bounds);
    }
    // Set to 1000 h: of two drives, one with twelve runs may lie below, both far below may not.
    let hours: Vec<f64> = draws.drives.iter().map(|drive| drive.judged[1].healthy.mean()).collect();
    assert!(hours.iter().any(|hours| *hours > 500.0), "{hours:?}");
}

/// Values of some records of a run that is risen by so many deviations; some are missing, some are unsure.
fn records(random: &mut ChaCha8Rng, list: &[Direction], rise: f64) -> Vec<Record> {
    let offset: f64 = random.sample(StandardNormal);
    let mut value = |direction: &Direction| {
        let Levels { centre, run, record, .. } = direction.levels;
        let noise: f64 = random.sample(StandardNormal);
        let value = centre + (offset + rise) * run.sqrt() + noise * record.sqrt();
        (noise < 2.0).then_some([value, 0.3 * record * noise.abs()])
    };
    (0..3).map(|_| list.iter().map(&mut value).collect()).collect()
}

/// The same record as the core's decision.
fn decided(decision: &Decision<RunTime>, list: &[Direction], record: &Record) -> Decision<RunTime> {
    let value = |(value, direction): (&Option<[f64; 2]>, &Direction)| {
        value.map_or(FeatureValue::MISSING, |[value, variance]| FeatureValue {
            value: (value - direction.levels.centre) as f32,
            variance: variance as f32,
        })
    };
    let mut decision = decision.clone();
    // The directions alone are compared.
    decision.fall = Default::default();
    decision.set_directed(&record.iter().zip(list).map(value).collect::<Vec<_>>());
    decision
}

#[test]
fn the_core_alarms_as_its_twin() {
    let settings = Settings { training: Fleet { units: 18, sessions: 3 }, records: 3, ..Settings::STANDARD };
    let bench = Bench::new(conditions()[0], 0, &settings).expect("trains");
    let healthy =
        Cell { purpose: Purpose::Validation, repetition: 0, condition: conditions()[0], defect: Defect::HEALTHY };
    let runs = bench.runs(healthy, 0, 0..1).expect("simulates");
    let some = runs[0][0].decision.clone().expect("a decision");
    let list = &bench.trained.watch.directions.as_ref().expect("directions").list;
    let (mut random, mut alarms, mut different) = (ChaCha8Rng::seed_from_u64(3), 0, 0);
    for history in 0..200 {
        let mut core = Core::new(&bench.model);
        let mut twin = Twin::new(&bench.trained.watch).expect("directions");
        for run in 0..30 {
            let rise = if run < 10 { 0.0 } else { f64::from(history % 5) };
            let records = records(&mut random, list, rise);
            let taken: Vec<_> = records.iter().map(|record| Some(decided(&some, list, record))).collect();
            let (by_core, by_twin) = (core.run(&taken), twin.run(&records));
            different += usize::from(by_core != by_twin);
            alarms += usize::from(by_core.is_some());
            if by_core.is_some() || by_twin.is_some() {
                break;
            }
        }
    }
    // Single precision decides otherwise only where a score meets the limit to six digits.
    assert!(alarms > 80 && alarms < 200 && different <= 1, "{alarms} {different}");
}
