//! Starts that are refused, a start behind a stop, withdrawals, and what other programs see of the samples.

use super::*;
use crate::tests::{REFINED, Refined, SAMPLES};

/// The model with other costs, which make it another one.
fn other_model() -> &'static Model<Drive> {
    let mut constants = MODEL.constants().clone();
    constants.classifier.discriminant.log_prior = [-0.7, -0.69];
    Box::leak(Box::new(Model::new(Drive, constants).unwrap()))
}

/// The reports of a watch that runs.
fn reports(watch: &'static Watch<Drive>, stream: impl Iterator<Item = Sample>) -> Vec<Report<Drive>> {
    let mut reports = Vec::new();
    for sample in stream {
        watch.sample(sample);
        watch.collect();
        reports.extend(concluded(watch));
    }
    reports
}

#[test]
fn a_refused_start_leaves_nothing_running_and_a_right_one_may_follow() {
    let watch: &'static Watch<Drive, FrontEnd<1, 10>> = Box::leak(Box::default());
    let wrong = FrontEndConstants { control_rate_hz: f32::NAN, ..CONSTANTS };
    assert!(matches!(watch.start(&MODEL, &wrong), Err(StartError::FrontEnd(_))));
    let slow = FrontEndConstants { control_rate_hz: 0.5 * CONSTANTS.control_rate_hz, ..CONSTANTS };
    assert!(matches!(watch.start(&MODEL, &slow), Err(StartError::Model(_))));
    assert!(!watch.sample(raw(0)) && !watch.collect() && watch.monitor(|_| ()).is_none());
    assert_eq!(watch.start(&MODEL, &CONSTANTS), Ok(()));
    assert!(watch.sample(raw(0)), "it runs");
    // And one that finds it running changes nothing.
    assert_eq!(watch.start(&MODEL, &CONSTANTS), Err(StartError::Started));
    assert!(watch.monitor(|_| ()).is_some());
}

/// Wherever the places are when it stops: open, closed on their way, being solved, or on their way back.
#[test]
fn behind_a_stop_another_model_has_the_reports_of_a_fresh_one() {
    let model = other_model();
    let (mut detector, mut monitor, mut expected) = (Detector::new(model), Monitor::new(model), Vec::new());
    for sample in samples(1.0).take(ROWS) {
        expected.extend(monitor.step(&mut detector, &sample).map(|now| now.report.clone()));
    }
    for stopped in [0, 1, SAMPLES as usize, SAMPLES as usize + 1, 2 * SAMPLES as usize, ROWS] {
        for steps in [0, 1, 2] {
            let watch = started();
            for sample in samples(0.7).take(stopped) {
                watch.sample(sample);
                watch.collect();
            }
            (0..steps).for_each(|_| _ = watch.advance(|_| ()));
            assert!(watch.stop() && watch.stop(), "also of one that has stopped");
            assert!(!watch.sample(samples(1.0).next().unwrap()) && watch.advance(|_| ()).is_none());
            watch.start(model).unwrap();
            assert_eq!((watch.status().rows, watch.status().lost_segments), (0, 0));
            let reports = reports(watch, samples(1.0).take(ROWS));
            assert!(reports == expected, "{stopped} {steps}");
            assert_eq!(watch.start(model), Err(StartError::Started));
        }
    }
}

#[test]
fn a_stop_during_another_call_changes_nothing() {
    let watch = started();
    let during =
        [watch.inputs.with(|_| watch.stop()), watch.collector.with(|_| watch.stop()), watch.monitor(|_| watch.stop())];
    assert_eq!(during, [Some(false); 3]);
    assert!(reports(watch, samples(1.0).take(ROWS)) == alone(samples(1.0).take(ROWS)));
}

#[test]
fn a_reset_drops_a_segment_that_waits_and_goes_on_afresh() {
    let (watch, expected) = (started(), alone(samples(1.0).take(ROWS)));
    for steps in [0, 1, 5] {
        for sample in samples(0.7).take(SAMPLES as usize + 9) {
            watch.sample(sample);
            watch.collect();
        }
        (0..steps).for_each(|_| _ = watch.advance(|_| ()));
        assert!(watch.reset());
        assert_eq!(watch.monitor(|own| (own.report().is_none(), own.evidence().segments())), Some((true, (0, 0))));
        assert!(reports(watch, samples(1.0).take(ROWS)) == expected, "{steps}");
    }
    assert_eq!(watch.status().lost_segments, 0);
    assert_eq!(watch.monitor(|_| watch.reset()), Some(false));
    // A segment that closed while the main loop held the lock of the hand-over.
    assert!(watch.reset());
    let held = watch.link.closed.try_lock();
    for sample in samples(0.7).take(SAMPLES as usize + 9) {
        watch.sample(sample);
        assert!(!watch.collect());
    }
    drop(held);
    assert!(watch.reset() && !watch.collect());
    assert!(reports(watch, samples(1.0).take(ROWS)) == expected);
}

#[test]
fn a_withdrawal_is_told_once_with_the_report_and_the_alarm_without_it() {
    for late in [false, true] {
        let watch = started();
        let (mut told, mut segments) = (Vec::new(), Vec::new());
        for (k, sample) in samples(1.0).take(3 * SAMPLES as usize).enumerate() {
            // In the first half of the second and of the third segment.
            let found_late = [SAMPLES as usize + 30, 2 * SAMPLES as usize + 30].contains(&k);
            watch.inputs.with(|inputs| inputs.put(&watch.link, Some((sample, found_late))));
            watch.collect();
            // A main loop that is late solves the second segment after the third has put it in doubt.
            if !late || !(SAMPLES as usize + 2..2 * SAMPLES as usize + 40).contains(&k) {
                for _ in 0..30 {
                    told.extend(watch.advance(|now| (k, now.withdrawn, now.report.verdict)));
                }
            }
            segments.push(watch.monitor(|own| own.evidence().segments()).unwrap());
        }
        let withdrawn: Vec<_> = told.iter().filter(|(_, withdrawn, _)| *withdrawn).collect();
        let lost = Verdict::Undetermined(Reason::FoundLate);
        assert!(withdrawn.iter().all(|(_, _, verdict)| *verdict == lost), "{told:?}");
        let verdicts: Vec<_> = told.iter().map(|(_, withdrawn, _)| *withdrawn).collect();
        assert_eq!(verdicts, [false, true, false, true, false], "{late} {told:?}");
        assert_eq!(segments.last(), Some(&(3, 2)));
        assert!(watch.advance(|_| ()).is_none());
    }
}

#[test]
fn counts_of_refusals_begin_anew_with_the_next_reading() {
    let watch: &'static Watch<Drive, FrontEnd<1, 10>> = Box::leak(Box::default());
    watch.start(&MODEL, &CONSTANTS).unwrap();
    let saturated = || watch.status().faults.unwrap().currents[0].saturated;
    let push = |number: u32, counts: Option<[u16; 3]>| {
        let mut raw = raw(number);
        if let Some(counts) = counts {
            raw.currents = PhaseCounts::Three(counts);
        }
        if watch.sample(raw) {
            watch.collect();
        }
    };
    let per_segment = 10 * MODEL.constants().sampling.segment_samples;
    for number in 0..per_segment + 500 {
        push(number, (number == 1000).then_some([4095, 2048, 2048]));
    }
    assert_eq!(saturated(), 1);
    watch.clear_faults();
    assert_eq!(saturated(), 1);
    push(per_segment + 500, None);
    assert_eq!(saturated(), 0);
}

#[test]
fn samples_are_shown_with_the_gaps_before_them() {
    let (watch, mut shown) = (started(), Vec::new());
    let stream: Vec<Sample> = samples(1.0).take(20).collect();
    for (k, sample) in stream.iter().enumerate() {
        watch.sample(*sample);
        // Four wait in the queue, and one before it, whose place the next one takes.
        if !(3..10).contains(&k) {
            watch.collect_with(|sample, missed| shown.push((*sample, missed)));
        }
    }
    let gap = |k: usize| u16::from(k == 10) * 3;
    let expected: Vec<_> = (0..20).filter(|k| !(7..10).contains(k)).map(|k| (stream[k], gap(k))).collect();
    assert_eq!(shown, expected);
}

/// One chip, two motors, and two models whose plans differ.
#[test]
fn two_motors_have_the_reports_of_each_alone() {
    let second: &'static Watch<Refined> = Box::leak(Box::default());
    second.start(&REFINED).unwrap();
    let (mut detector, mut monitor) = (Detector::new(&REFINED), Monitor::new(&REFINED));
    let (first, expected, mut reports) = (started(), alone(samples(1.0).take(ROWS)), Vec::new());
    let (mut refined, mut refined_alone) = (Vec::new(), Vec::new());
    for (sample, other) in samples(1.0).zip(samples(0.7)).take(ROWS) {
        first.sample(sample);
        second.sample(other.into());
        first.collect();
        second.collect();
        reports.extend(concluded(first));
        refined.extend((0..30).find_map(|_| second.advance(|now| now.report.clone())));
        refined_alone.extend(monitor.step(&mut detector, &other.into()).map(|now| now.report.clone()));
    }
    assert!(
        reports == expected && refined == refined_alone && refined.len() > 2,
        "{} {}",
        reports.len(),
        refined.len()
    );
}
