//! What a run says and teaches, and what a denial or a reset leaves of it.

use super::*;

/// Takes a segment whose value has an error of this variance.
fn segment(evidence: &mut Evidence<RunTime>, value: f32, variance: f32) {
    evidence.observe(Some(&Decision { directed: vec![FeatureValue { value, variance }], ..decision(&[0.0]) }));
}

/// A fresh evidence with one direction.
fn fresh() -> Evidence<RunTime> {
    evidence_of(vec![DIRECTION], 1.645, 100)
}

/// The state as words.
fn words(evidence: &Evidence<RunTime>) -> Vec<u32> {
    let mut words = Vec::new();
    evidence.save_words(&mut |word| words.push(word));
    words
}

/// Takes two runs that raise the alarm.
fn alarmed(evidence: &mut Evidence<RunTime>) {
    assert!((0..2).find_map(|_| run(evidence, &[12.0])).is_some());
}

/// ω = 1/(1 + v/W) with W = 1, U = 4 and B = 1/4: N = 1 + 1 + ½ + ½, x = 1, and 1/√(1/4 + 1/3) deviations.
#[test]
fn a_segment_weighs_by_its_error_beside_that_of_segments() {
    let mut evidence = evidence_of(vec![Direction { between: 4.0, ..DIRECTION }], 0.0, 100);
    [(0.0, 0.0), (3.0, 1.0), (0.0, 0.0), (3.0, 1.0)].iter().for_each(|(y, v)| segment(&mut evidence, *y, *v));
    evidence.end_run();
    let deviations = evidence.contribution(0).unwrap().deviations;
    assert!((deviations - 1.309_307).abs() < 1e-5, "{deviations}");
}

#[test]
fn the_growth_of_a_drive_is_relative_to_its_own_mean() {
    let of_drive = |usual: f32| {
        let mut evidence = fresh().of_model(1, 360.0);
        for step in 0..120_u8 {
            let grown = 1.2 * f32::from(step.saturating_sub(110));
            run(&mut evidence, &[usual + grown + if step % 2 == 0 { 0.3 } else { -0.3 }]);
        }
        assert_eq!(evidence.learned_runs(), 60);
        evidence.growth_to(0, 40.0).unwrap()
    };
    let (usual, apart) = (of_drive(0.0), of_drive(3.0));
    let near = |one: f32, other: f32| (one / other - 1.0).abs() < 0.05;
    assert!(near(apart.size.value, usual.size.value) && near(apart.slope.value, usual.slope.value));
    let [usual, apart] = [usual, apart].map(|growth| growth.left.unwrap());
    assert!(near(apart.low, usual.low) && near(apart.high, usual.high), "{apart:?} {usual:?}");
}

/// The last word of a state is the age of the growth.
#[test]
fn the_age_of_a_growth_does_not_count_runs_that_are_usual_for_the_drive() {
    for usual in [0.0, 3.0] {
        let mut evidence = fresh();
        (0..30).for_each(|_| _ = run(&mut evidence, &[usual]));
        assert_eq!(words(&evidence).pop().map(f32::from_bits), Some(0.0), "{usual}");
        (0..20).for_each(|_| _ = run(&mut evidence, &[usual + 3.0]));
        assert!(words(&evidence).pop().map(f32::from_bits) > Some(0.0), "{usual}");
    }
}

#[test]
fn a_state_is_restored_however_many_alarms_were_denied() {
    let mut evidence = fresh();
    for denial in 1..7 {
        alarmed(&mut evidence);
        assert!(evidence.deny());
        run(&mut evidence, &[0.0]);
        let (mut words, mut restored) = (words(&evidence).into_iter(), fresh());
        assert_eq!(restored.restore_words(&mut || words.next()), Some(()), "{denial}");
        assert_eq!(restored, evidence, "{denial}");
    }
}

#[test]
fn a_denial_ends_the_run_that_raised_the_alarm() {
    let mut evidence = fresh();
    run(&mut evidence, &[12.0]);
    assert!((0..RUN).find_map(|_| evidence.observe(Some(&decision(&[12.0])))).is_some());
    assert!(evidence.deny());
    let denied = evidence.clone();
    assert_eq!((evidence.end_run(), &evidence), (None, &denied), "no segment is left of it");
    run(&mut evidence, &[0.0]);
    assert!(evidence.contribution(0).unwrap().deviations.abs() < 0.1, "{evidence:?}");
}

/// A run that is usual after a denial teaches the drive's mean, 20 of 0.8 nearly all of it.
#[test]
fn a_later_denial_takes_back_nothing_that_usual_runs_have_taught_since_the_first() {
    let mut evidence = fresh();
    for denial in 1..4 {
        alarmed(&mut evidence);
        assert!(evidence.deny());
        run(&mut evidence, &[0.8]);
        let deviations = evidence.contribution(0).unwrap().deviations;
        assert_eq!(deviations.abs() < 0.1, denial > 1, "denial {denial}: {deviations}");
        (0..20).for_each(|_| _ = run(&mut evidence, &[0.8]));
    }
}

#[test]
fn an_alarm_after_a_denial_is_of_a_change_since_the_denial() {
    let mut evidence = fresh();
    for _ in 0..3 {
        let before = evidence.segments().0;
        alarmed(&mut evidence);
        assert_eq!(evidence.main_contribution().unwrap().since, before);
        assert!(evidence.deny() && evidence.contribution(0).unwrap().score == 0.0);
    }
}

#[test]
fn a_denial_without_an_alarm_changes_nothing() {
    let mut evidence = fresh();
    run(&mut evidence, &[2.5]);
    let before = evidence.clone();
    assert!(evidence.score() > 0.0 && !evidence.deny());
    assert_eq!(evidence, before);
}

#[test]
fn no_more_runs_are_learned_than_the_model_allows() {
    let mut evidence = fresh();
    (0..61).for_each(|_| _ = run(&mut evidence, &[0.0]));
    let mut deviations = || {
        run(&mut evidence, &[0.3]);
        (evidence.learned_runs(), evidence.contribution(0).unwrap().deviations)
    };
    let first = deviations();
    assert_eq!(first.0, 60);
    assert!((0..50).all(|_| deviations() == first));
}

#[test]
fn nothing_is_learned_while_falls_are_above_half_of_the_limit() {
    let mut evidence = fresh();
    let learned = [0.0, 30.0, 0.0].map(|surprise| {
        let fallen = Decision { fall: Fall { surprise, coordinate: 3 }, ..decision(&[0.0]) };
        (0..RUN).for_each(|_| _ = evidence.observe(Some(&fallen)));
        assert_eq!(evidence.end_run(), None);
        evidence.learned_runs()
    });
    assert_eq!(learned, [1, 1, 2]);
}

#[test]
fn an_alarm_keeps_its_cause_and_its_contribution_until_it_is_reset() {
    let mut evidence = evidence_of(vec![DIRECTION, Direction { coordinate: 1, ..DIRECTION }], 1.645, 100);
    (0..2).for_each(|_| _ = run(&mut evidence, &[0.0, 9.0]));
    let raised = (evidence.alarm(), evidence.main_contribution());
    assert_eq!(raised.0.map(|alarm| alarm.cause), Some(Cause::Coordinate(1)));
    (0..9).for_each(|_| _ = run(&mut evidence, &[90.0, 0.0]));
    assert_eq!((evidence.alarm(), evidence.main_contribution()), raised);
    evidence.reset();
    assert_eq!((evidence.alarm(), evidence.main_contribution()), (None, None));
}

/// ω = 1/(1 + v/W) with W = 4, U = 4 and B = 1/4: N = 1 + 1 + ½ + ½, x = 1, and 1/√(1/4 + 4/3) deviations.
#[test]
fn what_an_error_is_worth_depends_on_how_much_segments_differ() {
    let mut evidence = evidence_of(vec![Direction { between: 4.0, segment: 4.0, ..DIRECTION }], 0.0, 100);
    [(0.0, 0.0), (3.0, 4.0), (0.0, 0.0), (3.0, 4.0)].iter().for_each(|(y, v)| segment(&mut evidence, *y, *v));
    evidence.end_run();
    let deviations = evidence.contribution(0).unwrap().deviations;
    assert!((deviations - 0.794_719).abs() < 1e-5, "{deviations}");
}
