use super::*;
use crate::alarm::SilenceLimits;
use crate::plan::{Layout, Memory, Method, RunTime, Structure, testing};

/// With ln p* = −8.261798, ln μ = −0.166382 (7).
const CONSTANTS: EvidenceConstants =
    EvidenceConstants { bet: 0.2, limit: 10.0, cap: 5.0, log_mean: -0.166_382, ..EvidenceConstants::NONE };

fn plan() -> RunTime {
    let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
    RunTime::of(Layout { classes: 3, ..plain }).unwrap()
}

fn evidence(healthy: Option<u8>) -> Evidence<RunTime> {
    Evidence::empty(plan(), CONSTANTS, &Directions::none(plan()), healthy)
}

fn of_runs(segments_a_run: u32) -> Evidence<RunTime> {
    Evidence::empty(plan(), EvidenceConstants { segments_a_run, ..CONSTANTS }, &Directions::none(plan()), Some(0))
}

fn decision(surprise: f32, log_likelihoods: [f32; 3]) -> Decision<RunTime> {
    let log_likelihoods = log_likelihoods.to_vec();
    let distance_surprise = surprise;
    Decision { log_likelihoods, distance: surprise, distance_surprise, ..Decision::empty(plan()) }
}

#[test]
fn scores_by_hand() {
    let mut evidence = evidence(Some(0));
    // ln 0.2 = −1.609438: 4 nats add 1.756944, then 1 nat subtracts 0.643056, and 0 nats all the rest.
    assert_eq!(evidence.observe(Some(&decision(4.0, [0.0, -9.0, -9.0]))), None);
    assert!((evidence.score() - 1.756_944).abs() < 1e-5);
    evidence.observe(Some(&decision(1.0, [0.0, -9.0, -9.0])));
    assert!((evidence.score() - 1.113_888).abs() < 1e-5);
    evidence.observe(Some(&decision(0.0, [0.0, -9.0, -9.0])));
    assert_eq!(evidence.score(), 0.0);
}

#[test]
fn the_alarm_names_the_likelier_defect_and_is_latched() {
    let mut evidence = evidence(Some(0));
    let spalled = decision(1.0, [0.0, 30.0, 20.0]);
    assert_eq!(evidence.observe(Some(&spalled)), None, "capped");
    let alarm = Some(Alarm { segment: 2, cause: Cause::Class(1) });
    assert_eq!(evidence.observe(Some(&spalled)), alarm);
    for _ in 0..50 {
        assert_eq!(evidence.observe(Some(&decision(0.1, [0.0, -30.0, -20.0]))), alarm);
    }
    assert_eq!(evidence.score(), 0.0);
    evidence.reset();
    assert_eq!(evidence, self::evidence(Some(0)));
}

#[test]
fn what_resembles_no_defect_is_unknown() {
    let mut evidence = evidence(Some(0));
    let strange = decision(30.0, [0.0, -2.0, -1.0]);
    evidence.observe(Some(&strange));
    assert_eq!(evidence.observe(Some(&strange)), Some(Alarm { segment: 2, cause: Cause::Unknown }));
}

#[test]
fn nan_adds_nothing_and_is_forgotten() {
    let mut evidence = evidence(Some(0));
    let (nan, infinite) = (f32::NAN, f32::INFINITY);
    evidence.observe(None);
    evidence.observe(Some(&decision(nan, [0.0, 5.0, 5.0])));
    evidence.observe(Some(&decision(infinite, [0.0, 5.0, 5.0])));
    assert_eq!((evidence.segments(), evidence.score()), ((3, 3), 0.0));
    for odd in [[nan, 5.0, 5.0], [0.0, nan, nan], [-infinite, -infinite, -infinite]] {
        evidence.observe(Some(&decision(0.0, odd)));
        assert_eq!(evidence.score(), 0.0, "{odd:?}");
    }
    evidence.observe(Some(&decision(0.0, [-infinite, 0.0, -infinite])));
    assert_eq!(evidence.score(), CONSTANTS.cap);
    let alarm = evidence.observe(Some(&decision(0.0, [0.0, 5.0, 0.0])));
    assert_eq!(alarm.map(|alarm| alarm.cause), Some(Cause::Class(1)));
}

#[test]
fn a_run_adds_the_mean_of_its_segments() {
    let mut evidence = of_runs(3);
    // e of 4, 1, and 9 nats (capped): 0.2 e^3.2 = 4.906506, 0.2 e^0.8 = 0.445108, e⁵ = 148.413159; the mean is
    // 51.254924, ln 3.936812, + ln 3 (4) + 0.166382.
    for surprise in [4.0, 1.0] {
        evidence.observe(Some(&decision(surprise, [0.0, 1.0, -9.0])));
        evidence.observe(None);
        assert_eq!(evidence.score(), 0.0, "the run has not ended");
    }
    evidence.observe(Some(&decision(9.0, [0.0, -2.0, -9.0])));
    assert!((evidence.score() - 5.201_806).abs() < 1e-5, "{}", evidence.score());
    // The mean of e, e and e^−2 is 1.857299, ln 0.619124, + ln 3.
    assert!((evidence.defects[1].sum - 1.717_736).abs() < 1e-5, "{:?}", evidence.defects);
    // A run that ends early counts with its two segments: ln 2 is less than what there is.
    evidence.observe(Some(&decision(4.0, [0.0, -9.0, -9.0])));
    evidence.observe(Some(&decision(4.0, [0.0, -9.0, -9.0])));
    evidence.end_run();
    assert!((evidence.score() - 5.201_806 - 1.756_944).abs() < 1e-5, "{}", evidence.score());
    assert_eq!(evidence.segments(), (7, 2));
}

#[test]
fn the_end_of_a_run_without_segments_changes_nothing() {
    let mut evidence = of_runs(9);
    evidence.observe(Some(&decision(8.0, [0.0, 5.0, 2.0])));
    assert_eq!(evidence.end_run(), None);
    let before = evidence.clone();
    assert_eq!((evidence.end_run(), &evidence), (None, &before));
    evidence.observe(None);
    evidence.end_run();
    assert_eq!(evidence.score(), before.score());
    // A run that would raise the alarm does so at its end, and the alarm stays.
    evidence.observe(Some(&decision(30.0, [0.0, 5.0, 2.0])));
    assert_eq!(evidence.alarm(), None);
    let alarm = Some(Alarm { segment: 3, cause: Cause::Class(1) });
    assert_eq!((evidence.end_run(), evidence.end_run(), evidence.observe(None)), (alarm, alarm, alarm));
}

#[test]
fn one_disturbed_segment_of_many_adds_little() {
    let (mut one, mut all) = (of_runs(100), of_runs(100));
    for k in 0..100 {
        one.observe(Some(&decision(if k == 7 { 30.0 } else { 0.5 }, [0.0, -1.0, -1.0])));
        all.observe(Some(&decision(30.0, [0.0, -1.0, -1.0])));
    }
    // One capped e⁵ and 99 of 0.2 e^0.4: the sum 177.9513 is not twice that of 100 of the mean 1.
    assert!((one.score() - 5.347_892).abs() < 1e-4, "{}", one.score());
    assert!((all.score() - (100.0_f32.ln() + 5.166_382)).abs() < 1e-4, "{}", all.score());
}

#[test]
fn runs_of_impossible_defects_leave_no_trace() {
    let mut evidence = of_runs(2);
    let low = f32::MIN;
    for _ in 0..4 {
        evidence.observe(Some(&decision(0.0, [0.0, low, f32::NEG_INFINITY])));
    }
    assert_eq!((evidence.score(), evidence.defects[1].sum, evidence.defects[2].sum), (0.0, 0.0, 0.0));
    evidence.observe(Some(&decision(0.0, [0.0, 4.0, f32::NAN])));
    evidence.observe(Some(&decision(0.0, [0.0, 4.0, 0.0])));
    assert!((evidence.defects[1].sum - (4.0 + 2.0_f32.ln())).abs() < 1e-5, "{:?}", evidence.defects);
    assert!((evidence.defects[2].sum - 2.0_f32.ln()).abs() < 1e-6, "{:?}", evidence.defects);
}

#[test]
fn without_a_healthy_class_there_is_no_alarm() {
    let mut evidence = evidence(None);
    for _ in 0..9 {
        assert_eq!(evidence.observe(Some(&decision(30.0, [0.0, 30.0, 0.0]))), None);
    }
}

#[test]
fn one_disturbed_segment_does_not_name_another_defect() {
    let mut evidence = evidence(Some(0));
    for _ in 0..3 {
        evidence.observe(Some(&decision(0.0, [0.0, 3.0, 1.0])));
    }
    // Ahead by six nats, and then behind by 29, of which 5 count. The scores are 10 and 8.
    let alarm = evidence.observe(Some(&decision(0.0, [0.0, 1.0, 30.0])));
    assert_eq!(alarm, Some(Alarm { segment: 4, cause: Cause::Class(1) }));
}

#[test]
fn what_resembled_a_defect_while_nothing_was_suspected_does_not_name_it() {
    let mut evidence = evidence(Some(0));
    for _ in 0..9 {
        evidence.observe(Some(&decision(0.0, [0.0, -9.0, -4.0])));
    }
    assert_eq!(evidence.score(), 0.0);
    for _ in 0..2 {
        evidence.observe(Some(&decision(0.0, [0.0, 5.0, 4.9])));
    }
    assert_eq!(evidence.alarm(), Some(Alarm { segment: 11, cause: Cause::Class(1) }));
}

#[test]
fn a_segment_beyond_the_gate_of_a_defect_does_not_speak_for_it() {
    let beyond = |far: [bool; 3], log_likelihoods| {
        let mut decision = decision(30.0, log_likelihoods);
        decision.set_beyond(&far);
        decision
    };
    // Of a wide class, which is likelier than the healthy one: far from both.
    let mut evidence = evidence(Some(0));
    let alarm = |evidence: &mut Evidence<RunTime>, far, log_likelihoods| {
        let one = beyond(far, log_likelihoods);
        (0..2).fold(None, |_, _| evidence.observe(Some(&one)))
    };
    assert_eq!(
        alarm(&mut evidence, [false, true, true], [-900.0, -100.0, -80.0]),
        Some(Alarm { segment: 2, cause: Cause::Unknown })
    );
    // Near one of two defects, of which the farther one is likelier.
    evidence.reset();
    assert_eq!(
        alarm(&mut evidence, [false, false, true], [-900.0, -100.0, -80.0]),
        Some(Alarm { segment: 2, cause: Cause::Class(1) })
    );
    // Less likely than healthy it still speaks against the defect.
    evidence.reset();
    evidence.observe(Some(&beyond([false; 3], [0.0, 4.0, 0.0])));
    evidence.observe(Some(&beyond([false, true, true], [0.0, -3.0, 0.0])));
    assert_eq!(evidence.defects[1].sum, 1.0);
}

#[test]
fn only_segments_in_a_row_without_a_verdict_are_a_silence() {
    let mut evidence = evidence(Some(0));
    evidence.limit_silence(SilenceLimits { segments: 3, hours: 0.0 });
    for _ in 0..3 {
        (0..2).for_each(|_| _ = evidence.observe(None));
        assert_eq!(evidence.silence(), None);
        evidence.observe(Some(&decision(0.0, [0.0, -9.0, -9.0])));
    }
    (0..3).for_each(|_| _ = evidence.observe(None));
    assert_eq!(evidence.silence().map(|silence| silence.segments), Some(3));
}

#[test]
fn without_other_limits_a_silence_is_a_day_or_ten_thousand_segments() {
    let first = |segment_s: f32| {
        let mut evidence = evidence(Some(0)).of_model(1, segment_s);
        (1..20_000).find(|_| {
            evidence.observe(None);
            evidence.silence().is_some()
        })
    };
    assert_eq!([0.0, 1.0, 60.0, 3600.0].map(first), [Some(10_000), Some(10_000), Some(1440), Some(24)]);
}

#[test]
fn a_reset_ends_a_silence_and_keeps_its_limits() {
    let mut evidence = evidence(Some(0));
    evidence.limit_silence(SilenceLimits { segments: 2, hours: 0.0 });
    for _ in 0..2 {
        assert_eq!(evidence.silence(), None);
        (0..2).for_each(|_| _ = evidence.observe(None));
        assert_eq!(evidence.silence().map(|silence| silence.segments), Some(2));
        evidence.reset();
    }
}

/// The evidence of these words, all of one state; `None` if they are none that segments can leave.
fn restored(words: &[u32]) -> Option<Evidence<RunTime>> {
    let (mut other, mut words) = (evidence(Some(0)), words.iter().copied());
    other.restore_words(&mut || words.next())?;
    words.next().is_none().then_some(other)
}

#[test]
fn words_that_no_segments_leave_are_refused() {
    let mut observed = evidence(Some(0));
    for likelihoods in [[0.0, 3.0, 2.0], [0.0, 4.0, 1.0]] {
        observed.observe(Some(&decision(1.0, likelihoods)));
    }
    observed.observe(None);
    let mut words = std::vec::Vec::new();
    observed.save_words(&mut |word| words.push(word));
    assert_eq!(restored(&words).as_ref(), Some(&observed));
    assert_eq!(restored(&words[..words.len() - 1]), None);
    let changed = |index: usize, word: u32| {
        let mut words = words.clone();
        words[index] = word;
        restored(&words).is_some()
    };
    let [one, two, minus, nan] = [1.0, 2.0, -1.0, f32::NAN].map(f32::to_bits);
    // Segments, undetermined ones, the open run, cause and segment of the alarm.
    assert!(changed(0, 4) && !changed(0, 2), "fewer segments than are counted");
    assert!(!changed(1, 4) && !changed(2, 3), "more than there are");
    assert!(!changed(3, 2) && !changed(3, 5), "the healthy class, and none");
    assert!(!changed(3, 3), "an alarm of no segment");
    // The scores of novelty, the healthy class, and the defects, each with its open run, and then the support.
    let score = |class: usize| 7 + 2 * class;
    assert!(changed(score(1), two) && !changed(score(1), minus) && !changed(score(1), nan), "7 nats of two segments");
    assert!(!changed(score(1), 14.0_f32.to_bits()), "more than the caps, beyond the limit");
    assert!(!changed(score(0), one), "the healthy class has no score");
    assert!(
        changed(15, minus) && !changed(15, one) && !changed(13, minus),
        "at most as likely as the likeliest defect"
    );
}
