use super::super::tests::{collect, conclude, gated, segment, solved};
use super::{Conclusion, Monitor};
use crate::alarm::SilenceLimits;
use crate::alarm::evidence::{Cause, Evidence};
use crate::detector::{Detector, Segment};
use crate::model::Model;
use crate::reason::{Implausible, Reason};
use crate::report::{Report, Verdict};
use crate::tests::{Drive, SAMPLES, Sample, samples};
use std::vec::Vec;

/// The samples of one segment after the other, of these gains.
fn stream<'a>(gains: &'a [f32]) -> impl Iterator<Item = Sample> + 'a {
    gains.iter().flat_map(|gain| samples(*gain).take(SAMPLES as usize))
}

fn segments(model: &Model<Drive>, gains: &[f32]) -> Vec<Segment<Drive>> {
    let (mut detector, mut all) = (Detector::new(model), stream(gains));
    gains.iter().map(|_| segment(&mut detector, &mut all)).collect()
}

/// The evidence of reports that are taken at once.
fn at_once(model: &Model<Drive>, reports: &[Report<Drive>]) -> Evidence<Drive> {
    let mut evidence = Evidence::new(model);
    for report in reports {
        evidence.observe_outcome(report.outcome());
    }
    evidence
}

const GAINS: [f32; 5] = [0.5, 0.9, 1.0, 1.5, 0.5];

#[test]
fn reports_are_those_of_the_solve_and_the_evidence_takes_each_once() {
    let model = gated();
    let mut monitor = Monitor::new(&model);
    let mut taken: Vec<Report<Drive>> = Vec::new();
    for segment in segments(&model, &GAINS) {
        let expected = solved(&model, segment.clone());
        let now = conclude(&mut monitor, segment);
        assert_eq!(now.report, &expected);
        taken.push(expected.clone());
        assert_eq!(now.alarm, at_once(&model, &taken).alarm());
        assert_eq!(*monitor.evidence(), at_once(&model, &taken));
        assert_eq!(monitor.report(), Some(&expected));
    }
    let mut evidence = at_once(&model, &taken);
    assert_eq!(monitor.end_run(), evidence.end_run());
    assert_eq!((monitor.evidence(), monitor.evidence().alarm()), (&evidence, evidence.alarm()));
    assert_eq!(monitor.end_run(), evidence.alarm(), "no report is taken twice");
    assert_eq!(monitor.evidence().segments(), (5, 0));
}

#[test]
fn steps_give_the_bits_of_the_whole_and_a_hasty_interrupt_loses_nothing() {
    let model = gated();
    let (mut whole, mut steps, mut hasty) = (Monitor::new(&model), Monitor::new(&model), Monitor::new(&model));
    for segment in segments(&model, &GAINS) {
        let expected = conclude(&mut whole, segment.clone()).report.clone();
        assert!(steps.advance().is_none(), "nothing to solve");
        steps.take(segment.clone());
        assert_eq!(steps.report(), None, "not yet");
        let mut count = 1;
        let report = loop {
            if let Some(Conclusion { report, .. }) = steps.advance() {
                break report.clone();
            }
            count += 1;
        };
        assert!(count > 5 && report == expected, "{count}");
        // The next segment comes before the solve has ended.
        hasty.take(segment);
        assert!(hasty.advance().is_none());
    }
    let expected = (whole.end_run(), whole.evidence().clone());
    for monitor in [&mut steps, &mut hasty] {
        assert_eq!((monitor.end_run(), monitor.evidence().clone()), expected);
    }
}

/// A fault that was found late withdraws the report before if it may have begun there, and no other.
#[test]
fn a_report_in_doubt_is_taken_out_of_the_evidence() {
    let model = gated();
    for (index, doubts) in [(0, true), (SAMPLES / 2 - 1, true), (SAMPLES / 2, false), (SAMPLES - 1, false)] {
        let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
        let mut all = stream(&[40.0; 4]);
        let first = segment(&mut detector, &mut all);
        assert_eq!(conclude(&mut monitor, first).report.verdict, Verdict::Novel);
        all.by_ref().take(index as usize).for_each(|sample| assert!(collect(&mut detector, &sample).is_none()));
        detector.discard();
        let second = segment(&mut detector, &mut all);
        conclude(&mut monitor, second);
        let undetermined = u32::from(doubts) + u32::from(index >= SAMPLES / 2);
        assert_eq!(monitor.evidence().segments(), (2, undetermined), "{index}");
        let third = segment(&mut detector, &mut all);
        conclude(&mut monitor, third);
        assert_eq!(monitor.evidence().segments(), (3, undetermined), "{index}");
    }
}

#[test]
fn the_doubt_of_a_segment_that_was_lost_is_not_that_of_another() {
    let model = gated();
    let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
    let mut all = stream(&[40.0; 4]);
    conclude(&mut monitor, segment(&mut detector, &mut all));
    // Not taken by the main loop.
    let _lost = segment(&mut detector, &mut all);
    detector.discard();
    conclude(&mut monitor, segment(&mut detector, &mut all));
    assert_eq!(monitor.evidence().segments(), (2, 0));
    // Nor does a restart leave a doubt.
    detector.discard();
    detector.restart();
    conclude(&mut monitor, segment(&mut detector, &mut stream(&[40.0])));
    assert_eq!(monitor.evidence().segments(), (3, 0));
}

#[test]
fn an_alarm_names_the_segment_and_survives_power_off() {
    let model = gated();
    let mut monitor = Monitor::new(&model);
    let all = segments(&model, &[0.52, 0.52, 1.0, 1.0, 1.0]);
    for segment in &all[..3] {
        conclude(&mut monitor, segment.clone());
    }
    let mut bytes = [0; 400];
    let length = monitor.save(&mut bytes).expect("room");
    assert_eq!(length, Evidence::saved_len(&model));
    let mut later = Monitor::new(&model);
    conclude(&mut later, all[0].clone());
    later.restore(&bytes[..length]).expect("its own state");
    assert_eq!(later.evidence(), monitor.evidence());
    assert_eq!(later.report(), None, "what was held is not in the state");
    for (monitor, segment) in [&mut monitor, &mut later].into_iter().flat_map(|monitor| [(monitor, 3)]) {
        conclude(monitor, all[segment].clone());
        conclude(monitor, all[segment + 1].clone());
        assert_eq!(monitor.end_run().map(|alarm| alarm.cause), Some(Cause::Class(1)));
    }
    let damaged = [&bytes[..length - 1], &[!bytes[length - 1]]].concat();
    let before = later.clone();
    assert!(later.restore(&damaged).is_err() && later == before);
    later.reset();
    assert_eq!((later.evidence().alarm(), later.evidence().segments()), (None, (0, 0)));
}

/// The interrupt passes the number on, so that no alarm stands that the next segment would take away.
#[test]
fn a_report_is_withdrawn_before_the_next_segment_by_its_number() {
    let model = gated();
    let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
    let mut all = stream(&[40.0; 3]);
    let first = segment(&mut detector, &mut all);
    let doubt = detector.discard().expect("no sample of the second segment yet");
    assert!(!monitor.withdraw(doubt), "no report");
    monitor.take(first);
    assert!(!monitor.withdraw(doubt), "not solved yet");
    while monitor.advance().is_none() {}
    assert!(!monitor.withdraw(doubt + 1) && monitor.evidence().segments() == (1, 0));
    assert!(monitor.withdraw(doubt) && monitor.evidence().segments() == (1, 1));
    let verdict = monitor.report().map(|report| report.verdict);
    assert_eq!(verdict, Some(Verdict::Undetermined(Reason::FoundLate)));
    assert!(!monitor.withdraw(doubt), "once only");
    conclude(&mut monitor, segment(&mut detector, &mut all));
    assert_eq!(monitor.evidence().segments(), (2, 1));
    all.by_ref().take(SAMPLES as usize / 2).for_each(|sample| assert!(collect(&mut detector, &sample).is_none()));
    assert_eq!(detector.discard(), None, "half has passed");
}

#[test]
fn a_step_is_both_halves_at_once() {
    let model = gated();
    let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
    let (mut alone, mut evidence) = (Detector::new(&model), Evidence::new(&model));
    for sample in stream(&GAINS) {
        let expected = alone.step(&sample);
        let now = monitor.step(&mut detector, &sample);
        assert_eq!(now.map(|now| now.report), expected.as_ref());
        if let Some(report) = expected {
            evidence.observe_outcome(report.outcome());
            assert_eq!(monitor.evidence(), &evidence);
        }
    }
    assert_eq!((detector, monitor.evidence().segments()), (alone, (5, 0)));
}

#[test]
fn the_end_of_a_recording_has_a_verdict_from_half_a_segment_on() {
    let model = gated();
    for (count, verdict) in [
        (SAMPLES / 2 + 3, Verdict::Class(0)),
        (SAMPLES / 2 - 1, Verdict::Undetermined(Reason::ShortSegment { rows: SAMPLES / 2 - 2 })),
    ] {
        let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
        let mut all = stream(&[0.5]).take(count as usize);
        assert!(all.all(|sample| monitor.step(&mut detector, &sample).is_none()));
        assert_eq!(monitor.finish(&mut detector).report.verdict, verdict);
        assert_eq!((detector.pending(), monitor.evidence().segments().0), (0, 1));
    }
}

#[test]
fn a_refused_monitor_gives_no_verdict_and_takes_no_evidence_until_it_is_allowed_again() {
    let model = gated();
    let mut monitor = Monitor::new(&model);
    let [first, second, third, fourth, _] = segments(&model, &GAINS).try_into().expect("five");
    assert!(!matches!(conclude(&mut monitor, first).report.verdict, Verdict::Undetermined(_)));
    let score = monitor.evidence().score();
    monitor.refuse(Some(Implausible::Rate));
    for segment in [second, third] {
        let report = conclude(&mut monitor, segment).report;
        assert_eq!(report.verdict, Verdict::Undetermined(Reason::Implausible(Implausible::Rate)));
        assert!(report.decision.is_none());
    }
    assert_eq!((monitor.evidence().segments(), monitor.evidence().score()), ((3, 2), score));
    monitor.refuse(None);
    assert!(!matches!(conclude(&mut monitor, fourth).report.verdict, Verdict::Undetermined(_)));
}

/// A monitor that has concluded segments of a drive far from every class, and the number of the last one, which is now
/// in doubt.
fn doubted(model: &Model<Drive>, count: usize) -> (Monitor<'_, Drive>, u32) {
    let (mut detector, mut monitor) = (Detector::new(model), Monitor::new(model));
    let mut all = stream(&[40.0; 9]);
    (0..count).for_each(|_| _ = conclude(&mut monitor, segment(&mut detector, &mut all)));
    (monitor, detector.discard().expect("no sample of the next segment yet"))
}

#[test]
fn a_withdrawn_report_leaves_the_limits_of_a_silence() {
    let model = gated();
    let (mut monitor, number) = doubted(&model, 1);
    monitor.limit_silence(SilenceLimits { segments: 1, hours: 0.0 });
    assert!(monitor.withdraw(number));
    assert_eq!(monitor.evidence().silence().map(|silence| silence.segments), Some(1));
}

#[test]
fn nothing_of_before_comes_back_after_a_reset_or_a_restored_state() {
    let model = gated();
    let ways: [fn(&mut Monitor<'_, Drive>); 2] = [
        |monitor| monitor.reset(),
        |monitor| {
            let (mut bytes, fresh) = ([0; 400], Monitor::new(monitor.model));
            let length = fresh.evidence().save(monitor.model, &mut bytes).expect("room");
            monitor.restore(&bytes[..length]).expect("its own state");
        },
    ];
    for afresh in ways {
        let (mut monitor, number) = doubted(&model, 2);
        assert!(monitor.evidence().alarm().is_some());
        afresh(&mut monitor);
        assert_eq!((monitor.report(), monitor.evidence().alarm()), (None, None));
        assert!(!monitor.withdraw(number), "there is no report");
        assert_eq!(monitor.evidence(), &Evidence::new(&model));
        // Nor the report of a segment that was being solved.
        monitor.take(segments(&model, &[40.0]).remove(0));
        afresh(&mut monitor);
        assert!(!monitor.is_solving() && monitor.complete().is_none());
        monitor.end_run();
        assert_eq!(monitor.evidence(), &Evidence::new(&model));
    }
}

#[test]
fn a_doubt_does_not_bring_a_denied_alarm_back() {
    let model = gated();
    let (mut monitor, number) = doubted(&model, 2);
    assert!(monitor.deny());
    assert!(!monitor.withdraw(number));
    assert_eq!(
        (monitor.evidence().alarm(), monitor.evidence().score(), monitor.evidence().segments()),
        (None, 0.0, (2, 0))
    );
}

#[test]
fn what_a_trial_takes_out_does_not_bring_a_denied_alarm_back() {
    let model = gated();
    let ways: [fn(&mut Monitor<'_, Drive>, u32); 2] =
        [|monitor, _| monitor.refuse(Some(Implausible::Rate)), |monitor, number| assert!(monitor.withdraw(number))];
    for take_out in ways {
        let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
        let mut all = stream(&[40.0; 9]);
        (0..2).for_each(|_| _ = conclude(&mut monitor, segment(&mut detector, &mut all)));
        monitor.begin_trial();
        assert!(monitor.deny());
        conclude(&mut monitor, segment(&mut detector, &mut all));
        take_out(&mut monitor, detector.discard().expect("no sample of the next segment yet"));
        assert_eq!((monitor.evidence().alarm(), monitor.evidence().score()), (None, 0.0));
    }
}

#[test]
fn the_last_report_of_a_run_that_has_ended_stands() {
    let model = gated();
    let (mut monitor, number) = doubted(&model, 1);
    monitor.end_run();
    assert!(!monitor.withdraw(number) && monitor.evidence().segments() == (1, 0));
}

#[test]
fn a_trial_ends_with_its_first_answer() {
    let model = gated();
    let mut monitor = Monitor::new(&model);
    monitor.begin_trial();
    segments(&model, &GAINS).into_iter().for_each(|segment| _ = conclude(&mut monitor, segment));
    let taken = monitor.evidence().clone();
    monitor.refuse(None);
    assert_eq!(monitor.evidence(), &taken);
    monitor.refuse(Some(Implausible::Rate));
    assert_eq!(monitor.evidence(), &taken, "a later reason takes nothing out");
    monitor.begin_trial();
    segments(&model, &GAINS).into_iter().for_each(|segment| _ = conclude(&mut monitor, segment));
    monitor.refuse(Some(Implausible::Rate));
    assert_eq!(monitor.evidence(), &taken, "those of the second trial");
}

#[test]
fn a_withdrawn_report_of_a_trial_takes_those_of_the_trial_before_it_along() {
    let model = gated();
    let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
    let mut all = stream(&[40.0; 9]);
    conclude(&mut monitor, segment(&mut detector, &mut all));
    let score = monitor.evidence().score();
    monitor.begin_trial();
    (0..2).for_each(|_| _ = conclude(&mut monitor, segment(&mut detector, &mut all)));
    assert!(monitor.withdraw(detector.discard().expect("no sample yet")));
    assert_eq!((monitor.evidence().score(), monitor.evidence().segments()), (score, (2, 1)));
}

#[test]
fn what_a_trial_takes_out_does_not_bring_back_what_was_before_a_reset() {
    let model = gated();
    let (mut monitor, _) = doubted(&model, 2);
    monitor.begin_trial();
    assert!(monitor.evidence().alarm().is_some());
    monitor.reset();
    monitor.refuse(Some(Implausible::Rate));
    assert_eq!(monitor.evidence(), &Evidence::new(&model));
}
