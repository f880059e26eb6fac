//! Samples that are missing, refused, lost without a number, or that come twice.

use bearing_watch::model::Lags;
use bearing_watch::plan::RunTimeSample;
use bearing_watch::shaft::OrderStrength;
use bearing_watch::{Detector, Implausible, Monitor, RateCheck, Reason, Verdict};
use rig::DefectKind;

use super::electronics::scattered;
use super::implausible::{both_models, refusal};
use super::rigs::{self, KINDS, drives};
use crate::detector::parts::{recording, report, signals};
use crate::exported::MODEL;
use crate::shaft::dc_motor::{Motion, lag, model, model_of_angle, motions, parameters, run, trace};
use crate::shaft::streams::watched;
use crate::shaft::{OPEN, differenced};

#[test]
fn rows_that_are_lost_without_numbers_are_named_or_counted() {
    for kind in [DefectKind::Healthy, DefectKind::Spall] {
        let motions = motions(&trace(kind, 77), 14);
        for (name, model) in both_models() {
            let lossy = |a_thousand: u32| {
                let kept = |(k, _): &(usize, &Motion)| scattered(*k as u32) % 1000 >= a_thousand;
                run(&model, &motions.iter().enumerate().filter(kept).map(|(_, motion)| *motion).collect::<Vec<_>>())
            };
            let reports = [0, 1, 10, 100].map(lossy);
            let refusals: Vec<_> = reports.iter().map(|own| (refusal(own), own.counts.rejected)).collect();
            println!("{name}, {kind:?}: {refusals:?}");
            assert_eq!(refusals[0], (None, 0), "{name}, {kind:?}");
            assert!(refusals[1].1 > 0, "{name}, {kind:?}: {refusals:?}");
            assert_eq!([refusals[2].0, refusals[3].0], [Some(Implausible::AngleSteps); 2], "{name}, {kind:?}");
        }
    }
}

#[test]
fn lost_samples_cost_the_velocity_of_the_angle_one_sample_more() {
    let lags = Lags { velocity: 0.5, ..lag(1.2) };
    let mut lossy = motions(&trace(DefectKind::Spall, 32), 14);
    for lost in [1000, 1001, 2000, 3500] {
        lossy[lost].current_a = f32::NAN;
    }
    let lossy = differenced(lossy);
    let [of_angle, of_channel] = [model_of_angle(lags, OPEN), model(lags, true, OPEN)].map(|model| run(&model, &lossy));
    let (angle, channel) = (of_angle.shaft().expect("watched"), of_channel.shaft().expect("watched"));
    // Three gaps.
    let samples = (channel.usable - angle.usable) * lossy.len() as f32;
    assert!((samples - 3.0).abs() < 0.01, "{samples}");
    for (own, other) in parameters(&angle.friction).iter().zip(parameters(&channel.friction)) {
        // A row more or less a gap.
        assert!((own.value - other.value).abs() < 0.1 * other.deviation, "{own:?} {other:?}");
    }
    let [own, other] = [angle, channel].map(|shaft| shaft.orders()[0]);
    // A score is at most 1/√b, with a spall that reaches the control orders about 12.
    assert!(own.score > 9.0 && (own.score / other.score - 1.0).abs() < 0.02, "{own:?} {other:?}");
}

#[test]
fn samples_lost_at_the_start_leave_no_jump_in_the_residual() {
    let plain = model(Lags { load: 5.0, ..Lags::default() }, true, 10_000);
    let changes = (955..963).flat_map(|seed| {
        let clean = motions(&trace(DefectKind::Healthy, seed), 14).split_off(1000);
        let mut hurt = clean.clone();
        hurt[..8].iter_mut().for_each(|motion| motion.velocity_rad_s = f32::NAN);
        let [clean, hurt] = [&clean, &hurt].map(|stream| watched(&run(&plain, stream)).orders().to_vec());
        // Cells begin elsewhere.
        let change = |(own, other): (OrderStrength, OrderStrength)| {
            [(own.deviation / other.deviation).ln(), own.score - other.score].map(f64::from)
        };
        hurt.into_iter().zip(clean).map(change).collect::<Vec<_>>()
    });
    let changes: Vec<[f64; 2]> = changes.collect();
    let of = |which: usize| {
        let values = changes.iter().map(|change| change[which]);
        (values.clone().sum::<f64>() / changes.len() as f64, values.fold(0.0, |worst: f64, x| worst.max(x.abs())))
    };
    let ((deviation, worst), (score, furthest)) = (of(0), of(1));
    println!("{deviation} {worst} {score} {furthest}");
    // The shaft's own inertia would answer a jump of the velocity from zero with 80 A. The noise of 60 blocks cut at
    // other angles differs by 7 %: three standard errors of eight records, and three deviations of one of 24 orders.
    assert!(deviation.abs() < 0.075 && worst < 0.22, "{deviation} {worst}");
    assert!(score.abs() < 0.3 && furthest < 1.2, "{score} {furthest}");
}

#[test]
fn without_a_regression_half_of_the_samples_must_be_usable() {
    let model = model(lag(0.7), true, 5000);
    let rows = |lost: usize| {
        let mut stream = recording();
        stream.iter_mut().take(lost).for_each(|motion| motion.velocity_rad_s = f32::NAN);
        let report = report(&model, stream.iter().map(|motion| motion.sample(3)));
        (report.verdict, report.rows)
    };
    // The filters start with the eighth good sample; what was lost is in the delays for four more.
    assert_eq!(rows(2488), (Verdict::Class(0), 2512));
    assert_eq!(rows(2489), (Verdict::Undetermined(Reason::ShortSegment { rows: 2499 }), 2511));
    assert_eq!(rows(2501), (Verdict::Undetermined(Reason::ShortSegment { rows: 2487 }), 2499));
}

#[test]
fn a_segment_that_was_mostly_rejected_has_no_verdict() {
    let mut stream = recording();
    stream.iter_mut().take(2600).for_each(|motion| motion.current_a = f32::NAN);
    let report = report(&MODEL, stream.iter().map(signals));
    let short = Reason::ShortSegment { rows: 2398 };
    assert_eq!((report.verdict, report.counts.rejected), (Verdict::Undetermined(short), 2600));
    assert_eq!(report.decision, None);
}

/// Every row twice: the velocity, which is of the same rows, agrees with the angle. A clock does not.
#[test]
fn rows_that_come_twice_are_found_by_a_clock() {
    for drive in drives() {
        for load in [true, false] {
            let balance = drive.trained(load).constants().shaft[0].balance;
            for kind in KINDS {
                let (samples, _) = drive.clean(kind, 7, &|_, _, _| ());
                let model = rigs::model(balance, drive.lags, load, samples.len() as u32);
                let channels = model.constants().channels.len();
                let rows_hz = 1.0 / drive.base.interval_s;
                let verdict_of = |times: usize| {
                    let mut rate = RateCheck::new(rows_hz, 1000.0, 0.02, 2000);
                    let (mut detector, mut monitor) = (Detector::new(&model), Monitor::new(&model));
                    let (mut rows, mut last) = (0_u32, None);
                    for (k, sample) in samples.iter().enumerate() {
                        let now = (k as f32 * 1000.0 / rows_hz) as u32;
                        if let Some(right) = rate.push(rows, now) {
                            monitor.refuse((!right).then_some(Implausible::Rate));
                        }
                        for _ in 0..times {
                            let values = sample.values[..channels].to_vec();
                            let sample = RunTimeSample { values, angle: sample.angle };
                            last = monitor.step(&mut detector, &sample).map(|now| now.report.verdict).or(last);
                            rows += 1;
                        }
                    }
                    last
                };
                assert_eq!(verdict_of(1), Some(Verdict::Class(0)), "{}, load {load}, {kind:?}", drive.name);
                let refused = Verdict::Undetermined(Reason::Implausible(Implausible::Rate));
                assert_eq!(verdict_of(2), Some(refused), "{}, load {load}, {kind:?}", drive.name);
            }
        }
    }
}
