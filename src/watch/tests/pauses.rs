//! Pauses, faults that are found late, and what the clock tells again.

use super::*;
use crate::tests::SAMPLES;

/// Gives the watch a sample, with which a fault was found late or was not.
fn put(watch: &'static Watch<Drive>, sample: Sample, found_late: bool) {
    watch.inputs.with(|inputs| inputs.put(&watch.link, Some((sample, found_late))));
}

#[test]
fn a_fault_that_was_found_with_a_lost_sample_goes_with_the_next_one() {
    let (watch, missing) = (started(), Sample::of(&[f32::NAN; MAX_CHANNELS], Angle::ZERO));
    let (mut detector, mut monitor) = (Detector::new(&MODEL), Monitor::new(&MODEL));
    for (k, sample) in samples(1.0).take(3 * SAMPLES as usize).enumerate() {
        put(watch, sample, k == 226);
        // Four wait, and the next ones are lost.
        if !(220..230).contains(&k) {
            watch.collect();
        }
        concluded(watch);
        if k == 224 {
            monitor.withdraw(detector.discard().expect("the first half of the second segment"));
        }
        monitor.step(&mut detector, if (224..230).contains(&k) { &missing } else { &sample });
    }
    assert_eq!((monitor.evidence().segments(), watch.status().lost_samples), ((3, 1), 6));
    let same = watch.monitor(|own| own.evidence() == monitor.evidence() && own.report() == monitor.report());
    assert_eq!(same, Some(true));
}

#[test]
fn a_restart_drops_what_waits_and_what_was_lost() {
    let (watch, expected) = (started(), alone(samples(1.0).take(ROWS)));
    for (k, sample) in samples(2.0).take(9).enumerate() {
        put(watch, sample, true);
        if k < 2 {
            watch.collect();
        }
    }
    assert!(watch.restart());
    let mut reports = Vec::new();
    for sample in samples(1.0).take(ROWS) {
        watch.sample(sample);
        watch.collect();
        reports.extend(concluded(watch));
    }
    assert_eq!((watch.status().lost_samples, watch.monitor(|own| own.evidence().segments().1)), (2, Some(0)));
    assert!(reports == expected);
}

/// Reads the clock while samples come at one rate after the other, in rates of the model, each for its seconds. With
/// `pause`, a pause of five seconds and a restart stand between two rates.
fn told(rates: &[(f64, f64)], pause: bool) -> (Vec<Lapse>, Vec<u32>) {
    let (watch, interval_ms) = (started(), 1e3 * f64::from(MODEL.constants().sampling.interval_s));
    let (mut stream, mut at_ms) = (samples(1.0), 0.0_f64);
    let (mut told, mut segments) = (Vec::new(), Vec::new());
    for (place, (rate, seconds)) in rates.iter().enumerate() {
        if pause && place > 0 {
            at_ms += 5_000.0;
            assert!(watch.restart());
        }
        let end_ms = at_ms + 1e3 * seconds;
        while at_ms < end_ms {
            watch.sample(stream.next().unwrap());
            watch.collect();
            at_ms += interval_ms / rate;
            told.extend(watch.clock(at_ms as u32));
            concluded(watch);
            segments.push(watch.monitor(|own| own.evidence().segments().0).unwrap());
        }
    }
    (told, segments)
}

#[test]
fn a_pause_behind_which_it_starts_afresh_is_neither_a_wrong_rate_nor_a_lapse() {
    assert_eq!(told(&[(1.0, 14.0), (1.0, 12.0)], true).0, []);
}

#[test]
fn a_wrong_rate_is_told_again_once_it_was_right() {
    assert_eq!(told(&[(2.0, 31.0), (1.0, 31.0), (2.0, 31.0)], false).0, [Lapse::Rate; 2]);
}

#[test]
fn only_a_wrong_rate_of_the_first_window_takes_segments_out() {
    let grows = |segments: &[u32]| segments.is_sorted();
    let (rates, segments) = told(&[(1.0, 11.0), (2.0, 25.0)], false);
    assert!(rates == [Lapse::Rate] && grows(&segments));
    let (rates, segments) = told(&[(2.0, 11.0)], false);
    assert!(rates == [Lapse::Rate] && !grows(&segments));
}

#[test]
fn with_other_limits_the_times_count_anew() {
    let watch = started();
    let limits = LivenessLimits { sample_s: 1.0, segment_s: 15.0, verdict_s: 40.0 };
    assert_eq!([0, 900].map(|now| watch.clock(now)), [None; 2]);
    watch.limit_liveness(limits);
    assert_eq!([1_100, 2_099, 2_100].map(|now| watch.clock(now)), [None, None, Some(Lapse::NoSample)]);
}

#[test]
fn a_single_lost_sample_is_a_missing_one_for_the_detector() {
    let (watch, missing) = (started(), Sample::of(&[f32::NAN; MAX_CHANNELS], Angle::ZERO));
    let (mut shown, mut reports) = (Vec::new(), Vec::new());
    for (k, sample) in samples(1.0).take(ROWS).enumerate() {
        watch.sample(sample);
        // Four wait in the queue and one before it, which the next one replaces.
        if !(1000..1005).contains(&k) {
            watch.collect();
        }
        shown.push(if k == 1004 { missing } else { sample });
        reports.extend(concluded(watch));
    }
    assert_eq!((watch.status().lost_samples, watch.status().rows as usize), (1, ROWS));
    let expected = alone(shown.into_iter());
    assert!(reports.len() > 5 && reports[..] == expected[..reports.len()]);
}
