#![expect(clippy::cast_sign_loss, reason = "times, and counts of a converter")]

use std::boxed::Box;
use std::vec::Vec;

use super::{Lapse, QUEUE, StartError, Watch};
use crate::alarm::StateError;
use crate::detector::{Detector, Monitor};
use crate::drive::{
    Alignment, BalanceLimits, By, Factor, FrontEnd, FrontEndConstants, PhaseCounts, PhaseSensor, Position, RawSample,
    ResolverLimits, RotorFrame, TrackingConstants, WiringCheck, WiringLimits,
};
use crate::model::Model;
use crate::plan::{MAX_CHANNELS, Signals as _};
use crate::reason::{Implausible, Reason};
use crate::report::{Report, Verdict};
use crate::signal::{Angle, LivenessLimits, Park};
use crate::tests::{Drive, MODEL, Sample, samples};

mod pauses;
mod restarts;

fn started() -> &'static Watch<Drive> {
    let watch: &'static Watch<Drive> = Box::leak(Box::default());
    watch.start(&MODEL).unwrap();
    watch
}

/// The report of a segment, by a main loop that does all its steps between two samples.
fn concluded(watch: &'static Watch<Drive>) -> Option<Report<Drive>> {
    (0..30).find_map(|_| watch.advance(|now| now.report.clone()))
}

/// The reports of detector and monitor alone.
fn alone(stream: impl Iterator<Item = Sample>) -> Vec<Report<Drive>> {
    let (mut detector, mut monitor, mut reports) = (Detector::new(&MODEL), Monitor::new(&MODEL), Vec::new());
    for sample in stream {
        if let Some(now) = monitor.step(&mut detector, &sample) {
            reports.push(now.report.clone());
        }
    }
    reports
}

const ROWS: usize = 4000;

#[test]
fn reports_are_those_of_detector_and_monitor_alone_however_late_the_lower_interrupt_comes() {
    let expected = alone(samples(1.0).take(ROWS));
    assert!(expected.len() > 2);
    for late in 1..=QUEUE {
        let (watch, mut reports) = (started(), Vec::new());
        for (k, sample) in samples(1.0).take(ROWS).enumerate() {
            assert!(watch.sample(sample), "it waits");
            if k % late == 0 {
                watch.collect();
            }
            reports.extend(concluded(watch));
        }
        watch.collect();
        while reports.len() < expected.len() {
            reports.extend(concluded(watch));
        }
        assert!(reports == expected, "{late}");
        let status = watch.status();
        assert_eq!((status.rows as usize, status.lost_samples, status.lost_segments), (ROWS, 0, 0));
        assert_eq!((status.failed, status.faults), (None, None));
    }
}

#[test]
fn samples_that_find_the_queue_full_are_counted_and_are_missing_ones_for_the_detector() {
    let watch = started();
    let mut shown = Vec::new();
    let missing = Sample::of(&[f32::NAN; MAX_CHANNELS], Angle::ZERO);
    let mut reports = Vec::new();
    for (k, sample) in samples(1.0).take(ROWS).enumerate() {
        watch.sample(sample);
        // The interrupt does not come for ten samples: four wait in the queue, and the next one before it.
        let held = (1000..1010).contains(&k);
        let lost = (1004..1010).contains(&k);
        shown.push(if lost { missing } else { sample });
        if !held {
            watch.collect();
        }
        reports.extend(concluded(watch));
    }
    assert_eq!(watch.status().lost_samples, 6);
    assert_eq!(watch.status().rows as usize, ROWS);
    let expected = alone(shown.into_iter());
    assert!(!reports.is_empty() && reports[..] == expected[..reports.len()]);
}

#[test]
fn a_segment_that_the_main_loop_does_not_take_is_lost_and_counted() {
    let watch = started();
    let mut closed = 0;
    for sample in samples(1.0).take(ROWS) {
        watch.sample(sample);
        closed += u32::from(watch.collect());
    }
    let lost = watch.status().lost_segments;
    assert_eq!((closed, lost as usize), (1, alone(samples(1.0).take(ROWS)).len() - 1));
    assert_eq!(concluded(watch).unwrap().verdict, Verdict::Class(1));
    assert!(concluded(watch).is_none());
}

#[test]
fn a_context_that_interrupts_another_leaves_its_work_to_the_next_call() {
    let (watch, expected) = (started(), alone(samples(1.0).take(ROWS)));
    let mut reports = Vec::new();
    let mut stream = samples(1.0).take(ROWS);
    while let Some(sample) = stream.next() {
        // The current loop comes while the lower interrupt takes from the queue.
        let taking = watch.link.queue.try_lock();
        assert!(!watch.sample(sample), "the next call offers it");
        drop(taking);
        if let Some(next) = stream.next() {
            assert!(watch.sample(next));
        }
        // The lower interrupt comes while the main loop hands a report back, or takes a place.
        watch.collector.with(|_| assert!(!watch.collect()));
        let taking = watch.link.closed.try_lock();
        watch.collect();
        drop(taking);
        watch.collect();
        // And while the main loop is in its own call.
        watch.main.with(|_| assert!(concluded(watch).is_none() && watch.monitor(|_| ()).is_none()));
        let giving = watch.link.spare.try_lock();
        reports.extend(concluded(watch));
        drop(giving);
        reports.extend(concluded(watch));
    }
    reports.extend(concluded(watch));
    assert!(watch.status().lost_samples == 0 && reports == expected, "{:?}", watch.status());
}

#[test]
fn it_starts_once_and_before_the_start_every_call_does_nothing() {
    let watch: &'static Watch<Drive> = Box::leak(Box::default());
    assert!(!watch.sample(samples(1.0).next().unwrap()) && !watch.collect() && concluded(watch).is_none());
    assert!(watch.clock(0).is_none() && !watch.restart() && watch.status().rows == 0);
    assert_eq!([watch.end_run(&mut [0; 999]), watch.restore(&[]).map(|()| 0)], [Err(StateError::Unavailable); 2]);
    assert_eq!([watch.start(&MODEL), watch.start(&MODEL)], [Ok(()), Err(StartError::Started)]);
    assert!(std::format!("{watch:?}").contains("rows: 0") && !StartError::Started.message().is_empty());
}

#[test]
fn a_wrong_rate_leaves_no_verdict_until_it_is_right() {
    let (watch, interval_ms) = (started(), 1e3 * f64::from(MODEL.constants().sampling.interval_s));
    let (mut at_ms, mut rates, mut verdicts) = (0.0_f64, Vec::new(), Vec::new());
    let windows = (80_000.0 / interval_ms) as usize;
    for (k, sample) in samples(1.0).take(windows).enumerate() {
        watch.sample(sample);
        watch.collect();
        // Each sample comes twice in the first half.
        at_ms += if k < windows / 2 { 0.5 * interval_ms } else { interval_ms };
        rates.extend(watch.clock(at_ms as u32));
        verdicts.extend(concluded(watch).map(|report| report.verdict));
    }
    assert_eq!(rates, [Lapse::Rate], "told once");
    let wrong = Verdict::Undetermined(Reason::Implausible(Implausible::Rate));
    assert!(verdicts.contains(&wrong) && verdicts.last() == Some(&Verdict::Class(1)), "{verdicts:?}");
}

#[test]
fn a_run_goes_on_from_the_state_of_the_one_before() {
    let run = |state: &mut [u8], length: usize| {
        let watch = started();
        if length > 0 {
            watch.restore(&state[..length]).unwrap();
        }
        for sample in samples(1.0).take(ROWS / 2) {
            watch.sample(sample);
            watch.collect();
            concluded(watch);
        }
        let score = watch.monitor(|monitor| monitor.evidence().segments().0).unwrap();
        (watch.end_run(state).unwrap(), score)
    };
    let mut state = [0; 4096];
    let (length, first) = run(&mut state, 0);
    let (_, second) = run(&mut state, length);
    assert_eq!([first, second], [10, 20], "segments of both runs");
    state[length / 2] ^= 1;
    assert!(started().restore(&state[..length]).is_err());
}

const CONSTANTS: FrontEndConstants = FrontEndConstants {
    control_rate_hz: 10.0 / MODEL.constants().sampling.interval_s,
    sensors: [PhaseSensor { offset_counts: 2048.0, gain_a: 0.01, usable: [16, 4079] }; 3],
    stuck_samples: 0,
    balance: BalanceLimits { noise_a: 0.05, offset_a: 0.1, gain_tolerance: 0.02, window: 320 },
    tracking: TrackingConstants {
        bandwidth_hz: 100.0,
        damping: 0.7,
        error_limit_rad: 0.1,
        lost_samples: 20,
        settle_samples: 20,
        resolver: ResolverLimits { low: 0.8, high: 1.2, mismatch: 0.05 },
    },
    frame: RotorFrame { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard },
};

fn raw(number: u32) -> RawSample<1> {
    let turn = Angle::from_bits(number.wrapping_mul(300_000));
    let electrical = turn.times(6).sin_cos();
    let counts = [
        (-electrical.sin),
        0.5 * electrical.sin + 0.866 * electrical.cos,
        0.5 * electrical.sin - 0.866 * electrical.cos,
    ];
    let counts = counts.map(|unit| (2048.0 + 500.0 * unit) as u16);
    RawSample { number, currents: PhaseCounts::Three(counts), position: Position::Absolute(turn), further: [0.3] }
}

impl From<crate::drive::CleanSample<1>> for Sample {
    fn from(clean: crate::drive::CleanSample<1>) -> Self {
        Self::of(&[clean.current_a, clean.velocity_rad_s, clean.further[0]], clean.angle)
    }
}

#[test]
fn readings_pass_the_front_end_and_its_faults_are_told_with_each_segment() {
    let watch: &'static Watch<Drive, FrontEnd<1, 10>> = Box::leak(Box::default());
    watch.start(&MODEL, &CONSTANTS).unwrap();
    let (mut front_end, mut detector) = (FrontEnd::<1, 10>::new(&CONSTANTS).unwrap(), Detector::new(&MODEL));
    let (mut monitor, mut expected, mut reports) = (Monitor::new(&MODEL), Vec::new(), Vec::new());
    let per_segment = 10 * MODEL.constants().sampling.segment_samples;
    for number in 0..3 * per_segment + 500 {
        let mut raw = raw(number);
        // A saturated phase in the second segment, for one sample; a wrong gain from there on is found late.
        if number == per_segment + 1000 {
            raw.currents = PhaseCounts::Three([4095, 2048, 2048]);
        }
        if watch.sample(raw) {
            watch.collect();
        }
        if let Some(clean) = front_end.push(&raw) {
            monitor.tell_alignment(front_end.faults().alignment);
            if let Some(now) = monitor.step(&mut detector, &clean.into()) {
                expected.push(now.report.clone());
            }
        }
        reports.extend(watch.advance(|now| now.report.clone()));
    }
    assert!(reports.len() == 3 && reports == expected, "{} {}", reports.len(), expected.len());
    assert_eq!(watch.status().faults.unwrap().currents[0].saturated, 1);
}

/// What the clock tells at which millisecond, of a drive of which each context runs from and to some milliseconds.
fn lapses(sampled: [u32; 2], collected: [u32; 2], advanced: [u32; 2], end_ms: u32) -> Vec<(u32, Lapse)> {
    let (watch, interval_ms) = (started(), (1e3 * MODEL.constants().sampling.interval_s) as u32);
    watch.limit_liveness(LivenessLimits { sample_s: 1.0, segment_s: 15.0, verdict_s: 40.0 });
    let within = |[from, to]: [u32; 2], now: u32| (from..to).contains(&now);
    let mut stream = samples(1.0);
    let mut told = Vec::new();
    for now in (0..end_ms).step_by(interval_ms as usize) {
        if within(sampled, now) {
            watch.sample(stream.next().unwrap());
        }
        if within(collected, now) {
            watch.collect();
        }
        if within(advanced, now) {
            concluded(watch);
        }
        told.extend(watch.clock(now).map(|lapse| (now, lapse)));
    }
    told
}

#[test]
fn what_does_not_come_any_more_is_told_once_with_the_reason() {
    let always = [0, u32::MAX];
    assert_eq!(lapses(always, always, always, 60_000), []);
    // A second behind the last of each; the pause of the samples is also a wrong rate in its window.
    let told = lapses([0, 12_000], always, always, 30_000);
    assert!(told.len() == 2 && told[0].1 == Lapse::NoSample && (12_900..13_100).contains(&told[0].0), "{told:?}");
    let told = lapses(always, [0, 12_000], always, 19_000);
    assert!(told.len() == 1 && told[0].1 == Lapse::NotCollected && (12_900..13_100).contains(&told[0].0), "{told:?}");
    // Without the main loop a segment waits, and the next ones are lost.
    let told = lapses(always, always, [0, 0], 30_000);
    assert!(told.len() == 1 && told[0].1 == Lapse::NoSegment, "{told:?}");
}

#[test]
fn a_segment_of_block_means_has_its_whole_time_to_close() {
    let mut constants = MODEL.constants().clone();
    let sampling = &mut constants.sampling;
    (sampling.interval_s, sampling.block_mean) = (0.1, 8);
    let segment_ms = (1e3 * sampling.segment_s()) as u32;
    let model = Box::leak(Box::new(Model::new(Drive, constants).unwrap()));
    // Of samples without their means, three segments and three seconds would end within the first.
    assert!(3 * segment_ms / 8 + 3_000 < segment_ms / 2);
    let watch: &'static Watch<Drive> = Box::leak(Box::default());
    watch.start(model).unwrap();
    let (mut told, mut reports) = (Vec::new(), 0);
    for (now, sample) in (0..2 * segment_ms + 1_000).step_by(100).zip(samples(1.0)) {
        watch.sample(sample);
        watch.collect();
        reports += usize::from(concluded(watch).is_some());
        told.extend(watch.clock(now));
    }
    assert!(reports == 2 && told.is_empty(), "{reports} {told:?}");
}

#[test]
fn times_count_from_the_end_of_the_commissioning() {
    let watch: &'static Watch<Drive, FrontEnd<1, 10>> = Box::leak(Box::default());
    watch.start(&MODEL, &CONSTANTS).unwrap();
    let limits = WiringLimits {
        least_current_a: 0.05,
        offset_rad: 0.1,
        delay_s: 2e-4,
        velocity_tolerance: 0.1,
        slowest_rad_s: 5.0,
    };
    let mut check = WiringCheck::new(CONSTANTS.frame, CONSTANTS.control_rate_hz, limits);
    // Nine seconds of commissioning, then silence.
    let told: Vec<(u32, Lapse)> = (0..20_000)
        .filter_map(|now| {
            if now < 9_000 {
                watch.check_wiring(raw(now), f32::NAN, &mut check);
            }
            watch.clock(now).map(|lapse| (now, lapse))
        })
        .collect();
    assert_eq!(told, [(11_999, Lapse::NoSample)]);
}

#[test]
fn an_alarm_of_the_first_window_goes_with_a_wrong_rate() {
    let of_rate = |factor: f64| {
        let (watch, interval_ms) = (started(), 1e3 * f64::from(MODEL.constants().sampling.interval_s));
        let (mut at_ms, mut early, mut told) = (0.0_f64, 0, Vec::new());
        for sample in samples(1.0) {
            watch.sample(sample);
            watch.collect();
            at_ms += factor * interval_ms;
            told.extend(watch.clock(at_ms as u32));
            concluded(watch);
            let segments = watch.monitor(|monitor| monitor.evidence().segments().0).unwrap();
            if at_ms < 9_000.0 {
                early = segments;
            }
            if at_ms > 11_000.0 {
                return (early, segments, told);
            }
        }
        unreachable!("samples without end")
    };
    let (early, segments, told) = of_rate(1.0);
    assert!(early > 1 && segments > early && told.is_empty(), "{early} {segments} {told:?}");
    let (early, segments, told) = of_rate(0.5);
    assert!(early > 1 && segments < early && told == [Lapse::Rate], "{early} {segments} {told:?}");
}

/// Verdicts of a drive that rests for a segment, then turns fast, and what the status says of its wiring at the end.
fn verdicts_of_wiring(change: impl Fn(&mut RawSample<1>)) -> (Vec<Verdict>, Alignment) {
    let watch: &'static Watch<Drive, FrontEnd<1, 10>> = Box::leak(Box::default());
    watch
        .start(&MODEL, &FrontEndConstants { balance: BalanceLimits { window: 64, ..CONSTANTS.balance }, ..CONSTANTS })
        .unwrap();
    let per_segment = 10 * MODEL.constants().sampling.segment_samples;
    assert_eq!(watch.status().alignment, Alignment::Undecided);
    let mut verdicts = Vec::new();
    for number in 0..12 * per_segment {
        let mut raw = raw(30 * number.saturating_sub(per_segment));
        raw.number = number;
        change(&mut raw);
        if watch.sample(raw) {
            watch.collect();
        }
        verdicts.extend(watch.advance(|now| now.report.verdict));
    }
    (verdicts, watch.status().alignment)
}

#[test]
fn no_verdict_comes_before_the_wiring_is_known_and_none_of_a_wrong_one() {
    let refused = |error| Verdict::Undetermined(Reason::Implausible(error));
    let is_refused = |verdict: &Verdict| matches!(verdict, Verdict::Undetermined(Reason::Implausible(_)));
    let (right, alignment) = verdicts_of_wiring(|_| ());
    assert_eq!((right[0], alignment), (refused(Implausible::WiringUndecided), Alignment::Aligned));
    assert!(right.last().is_some_and(|last| !is_refused(last)), "{right:?}");
    let (exchanged, alignment) = verdicts_of_wiring(|raw| {
        if let PhaseCounts::Three([_, b, c]) = &mut raw.currents {
            core::mem::swap(b, c);
        }
    });
    assert_eq!((exchanged.last(), alignment), (Some(&refused(Implausible::Wiring)), Alignment::Misaligned));
    // Nothing can be checked: no verdict is refused, and the status says so.
    let (own, alignment) = verdicts_of_wiring(|raw| raw.currents = PhaseCounts::Quadrature(5.0));
    assert!(!own.iter().any(is_refused), "{own:?}");
    assert_eq!(alignment, Alignment::Unknown);
    // A motor that coasts: the check says after eight windows that it cannot tell.
    let (coasting, alignment) = verdicts_of_wiring(|raw| raw.currents = PhaseCounts::Three([2048; 3]));
    assert_eq!((coasting[0], alignment), (refused(Implausible::WiringUndecided), Alignment::Unknown));
    assert!(coasting.last().is_some_and(|last| !is_refused(last)), "{coasting:?}");
}

/// The interrupt is requested by what `sample` returns alone.
#[test]
fn a_queue_that_was_full_is_collected_again() {
    let watch: &'static Watch<Drive, FrontEnd<1, 10>> = Box::leak(Box::default());
    watch.start(&MODEL, &CONSTANTS).unwrap();
    let (mut pending, mut reports) = (false, 0);
    let readings = 10 * MODEL.constants().sampling.segment_samples;
    for number in 0..3 * readings + 500 {
        pending |= watch.sample(raw(number));
        // 12 ms of a drive of 10 kHz.
        if pending {
            pending = false;
            if !(1001..1121).contains(&number) {
                watch.collect();
            }
        }
        reports += u32::from(watch.advance(|_| ()).is_some());
    }
    // Four in the queue and one before it.
    let status = watch.status();
    assert_eq!((reports, status.lost_samples, status.lost_segments), (3, 7, 0));
}

#[test]
fn a_front_end_that_does_not_fit_is_refused() {
    fn refused<const FACTOR: usize>(constants: &FrontEndConstants) -> StartError
    where
        By<FACTOR>: Factor,
    {
        let watch: &'static Watch<Drive, FrontEnd<1, FACTOR>> = Box::leak(Box::default());
        let error = watch.start(&MODEL, constants).unwrap_err();
        assert!(!watch.sample(raw(0)) && !std::format!("{error}").is_empty());
        error
    }
    assert!(matches!(refused::<8>(&CONSTANTS), StartError::Model(_)), "another rate");
    let without = FrontEndConstants { control_rate_hz: f32::NAN, ..CONSTANTS };
    assert!(matches!(refused::<10>(&without), StartError::FrontEnd(_)));
}
