//! Values that stay the same: of the angle, of sensors and of a thermometer; a shaft at rest is not a stuck one.

use bearing_watch::model::Feature;
use bearing_watch::shaft::{Friction, ShaftEstimate};
use bearing_watch::{Detector, Implausible, Model, Part, Reason, Verdict};
use rig::{DefectKind, NoiseSource, Stream};

use super::implausible::{both_models, refusal};
use super::rigs::{COUNTS, drives, judge};
use crate::detector::covariates::{self, MAP, TEMPERATURE, Warm, record};
use crate::detector::parts::{ESTIMATED, MIXED, WATCHED, all, both, recording};
use crate::shaft::dc_motor::{Motion, lag, model, motions, run, trace};
use crate::shaft::streams::watched;

#[test]
fn a_stuck_angle_is_named_and_a_shaft_at_rest_is_not() {
    for kind in [DefectKind::Healthy, DefectKind::Spall] {
        let motions = motions(&trace(kind, 77), 14);
        for (name, model) in both_models() {
            let stuck_from = |row: usize| {
                let angle = motions[row].angle;
                let stuck = |(k, motion): (usize, &Motion)| Motion {
                    angle: if k < row { motion.angle } else { angle },
                    ..*motion
                };
                refusal(&run(&model, &motions.iter().enumerate().map(stuck).collect::<Vec<_>>()))
            };
            assert_eq!(stuck_from(0), Some(Implausible::StuckAngle), "{name}, {kind:?}");
            if name == "own velocity" {
                assert_eq!(stuck_from(2500), Some(Implausible::StuckAngle), "{name}, {kind:?}");
            }
            // A drive that rests: noise of the sensors, whatever it holds.
            for (k, hold_a) in [0.0, 3.0].into_iter().enumerate() {
                let noise = |k: usize| (k as f32 * 1.7).sin();
                let rest = |k: usize| Motion {
                    current_a: hold_a + 0.02 * noise(k),
                    velocity_rad_s: 0.3 * noise(k + 5),
                    load_nm: hold_a / 20.0,
                    ..Motion::default()
                };
                let report = run(&model, &(0..5000).map(rest).collect::<Vec<_>>());
                assert_ne!(refusal(&report), Some(Implausible::StuckAngle), "{name}, {k}");
            }
        }
    }
}

#[test]
fn stuck_sensors_and_a_shaft_at_rest_are_reasons() {
    let plain = model(lag(0.7), true, 10_000);
    let mut constants = plain.constants().clone();
    for channel in [0, 1, 2] {
        constants.channels[channel].stuck_samples = 50;
    }
    let watchful = Model::new(plain.plan(), constants).expect("good");
    let clean = motions(&trace(DefectKind::Healthy, 951), 14);
    assert_eq!(watched(&run(&watchful, &clean)).friction_reason, None);
    for channel in [0_u8, 1, 2] {
        let mut hurt = clean.clone();
        for Motion { current_a, velocity_rad_s, load_nm, .. } in &mut hurt[1000..1100] {
            *[current_a, velocity_rad_s, load_nm][usize::from(channel)] = 0.25;
        }
        let report = run(&watchful, &hurt);
        let reasons = (watched(&report).friction_reason, watched(&report).orders_reason);
        assert_eq!(reasons, (Some(Reason::Stuck { channel }), Some(Reason::Stuck { channel })));
        assert!((0..3).all(|place| report.counts.stuck.contains(place) == (place == usize::from(channel))));
    }
    let mut noise = NoiseSource::new(3, Stream::Conditions);
    let at_rest: Vec<Motion> = (0..5000)
        .map(|_| Motion {
            current_a: noise.gaussian() as f32,
            velocity_rad_s: noise.gaussian() as f32,
            ..Motion::default()
        })
        .collect();
    let report = run(&plain, &at_rest);
    // What is not excited has no result, and nothing turns for an order.
    let ShaftEstimate { friction, friction_reason, orders_reason, .. } = watched(&report);
    assert_eq!((*friction_reason, *orders_reason), (Some(Reason::AtRest), Some(Reason::AtRest)));
    assert_eq!(*friction, Friction::default());
    let few = Some(Reason::TooFewRows { part: Part::TorqueBalance, rows: 0 });
    assert_eq!(watched(&run(&plain, &clean[..50])).friction_reason, few);
}

#[test]
fn a_stuck_channel_costs_only_the_features_of_parts_that_use_it() {
    let mut stream = recording();
    let run = |features: [Feature; 3], stream: &[Motion]| {
        let model = both(features, |channels| [0, 1, 3].iter().for_each(|k| channels[*k].stuck_samples = 50));
        let mut detector = Detector::new(&model);
        let first = stream.iter().find_map(|motion| detector.step(&all(motion))).expect("a segment");
        let second = recording().iter().find_map(|motion| detector.step(&all(motion))).expect("a segment");
        assert!(matches!(second.verdict, Verdict::Class(_)) && second.counts.stuck.is_empty(), "{:?}", second.verdict);
        let shaft = first.shaft().expect("watched");
        assert_eq!(shaft.friction_reason, shaft.orders_reason);
        let stuck = [0, 1, 2, 3].map(|place| first.counts.stuck.contains(place));
        let missing = first.decision.as_ref().map(|decision| (decision.missing().to_vec(), decision.missing_count()));
        let lacks = |of: [bool; 3], count: usize| missing == Some((of.to_vec(), count));
        let verdict = match (first.verdict, features) {
            (Verdict::Class(_), MIXED) => lacks([false, true, true], 2) || lacks([true, false, false], 1),
            (Verdict::Class(_), _) => lacks([false; 3], 0),
            _ => missing.is_none(),
        };
        assert!(verdict, "{:?} {missing:?}", first.verdict);
        (first.verdict, first.estimate().expect("estimated").reason, shaft.friction_reason, stuck)
    };
    let judged = |verdict: Verdict| matches!(verdict, Verdict::Class(_));
    let clean = stream.clone();
    stream[1000..1100].iter_mut().for_each(|motion| motion.velocity_rad_s = 0.25);
    let reason = Reason::Stuck { channel: 1 };
    let outcome = run(MIXED, &stream);
    assert!(judged(outcome.0), "the feature of the regression is there");
    assert_eq!((outcome.1, outcome.2, outcome.3), (None, Some(reason), [false, true, false, false]));
    assert_eq!(run(WATCHED, &stream).0, Verdict::Undetermined(reason), "all features are missing");
    assert!(judged(run(ESTIMATED, &stream).0), "no feature uses the shaft");
    stream.clone_from(&clean);
    stream[1000..1100].iter_mut().for_each(|motion| motion.load_nm = 0.25);
    let reason = Reason::Stuck { channel: 3 };
    let outcome = run(MIXED, &stream);
    assert!(judged(outcome.0), "the features of the shaft are there");
    assert_eq!((outcome.1, outcome.2, outcome.3), (Some(reason), None, [false, false, false, true]));
    assert!(judged(run(WATCHED, &stream).0), "no feature uses the regression");
    stream.clone_from(&clean);
    stream[1000..1100].iter_mut().for_each(|motion| motion.current_a = 0.25);
    let reason = Reason::Stuck { channel: 0 };
    let outcome = run(WATCHED, &stream);
    assert_eq!(outcome, (Verdict::Undetermined(reason), Some(reason), Some(reason), [true, false, false, false]));
}

#[test]
fn a_stuck_thermometer_is_missing() {
    let plain = covariates::model([TEMPERATURE], MAP).expect("good");
    let mut constants = plain.constants().clone();
    constants.channels[2].stuck_samples = 20;
    let watchful = Model::new(Warm, constants).expect("good");
    let mut samples = record(40.0, 0.0);
    samples[2950..].iter_mut().for_each(|own| own.temperature_c = 40.0);
    let report = covariates::run(&watchful, &samples);
    assert_eq!(report.decision.as_ref().map(|own| own.outside().to_vec()), Some(vec![true]));
    assert_eq!(report.averages()[1].mean(), Err(Reason::Stuck { channel: 2 }));
    assert!(report.averages()[0].mean().is_ok());
}

#[test]
fn stale_angles_are_missing_and_counted() {
    for drive in drives() {
        for length in [1, 3, 10] {
            let rows = (drive.record)(DefectKind::Healthy, 7);
            let inject = |k: usize, _: &mut [f64; 3], counts: &mut u32| {
                if k > 100 && k % 100 < length {
                    *counts = (rows[k - k % 100 - 1].turns.rem_euclid(1.0) * COUNTS) as u32;
                }
            };
            let (samples, faults) = drive.clean(DefectKind::Healthy, 7, &inject);
            println!("{}, {length}: {:?}", drive.name, faults.position);
            assert!(faults.position.stale > 10 && !faults.is_clear(), "{}, {length}", drive.name);
            for load in [true, false] {
                let (verdict, ..) = judge(&drive.trained(load), &samples);
                assert!(!matches!(verdict, Verdict::Novel | Verdict::Ambiguous), "{}: {verdict:?}", drive.name);
            }
        }
    }
}
