use super::render::{delay, hours};
use super::*;

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
