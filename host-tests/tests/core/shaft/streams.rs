//! The shaft on streams that no laboratory would record, and across segments.

use bearing_watch::plan::RunTime;
use bearing_watch::shaft::{Friction, ShaftEstimate};
use bearing_watch::{Angle, Detector, Model, Report};
use proptest::prelude::*;
use rig::{Defect, DefectKind, Scenario, simulate};

use crate::shaft::dc_motor::{Motion, lag, model, motions, parameters, run, trace};

const SEGMENT: u32 = 5000;

/// The report of a whole segment.
fn segment(detector: &mut Detector<'_, RunTime>, motions: &[Motion]) -> Report<RunTime> {
    let mut reports = motions.iter().filter_map(|motion| detector.step(&motion.sample(4)));
    let report = reports.next().expect("a whole segment");
    assert!(reports.next().is_none());
    report
}

pub fn watched(report: &Report<RunTime>) -> &ShaftEstimate<RunTime> {
    report.shaft().expect("watched")
}

fn finite(report: &Report<RunTime>) -> bool {
    let ShaftEstimate { friction, .. } = watched(report);
    let numbers = parameters(friction).into_iter().flat_map(|p| [p.value, p.deviation, p.score]);
    let orders =
        watched(report).orders().iter().flat_map(|order| [order.prominence, order.score, order.amplitude, order.slip]);
    numbers.chain(orders).all(f32::is_finite) && friction.variance.is_finite()
}

/// Furthest parameter from another estimate's, in that one's deviations.
fn furthest(one: &Report<RunTime>, other: &Report<RunTime>) -> f32 {
    let [one, other] = [one, other].map(|report| parameters(&watched(report).friction));
    one.iter().zip(&other).map(|(p, q)| ((p.value - q.value) / q.deviation).abs()).fold(0.0, f32::max)
}

#[test]
fn bursts_of_nonsense_are_counted_and_bounded_and_gone_with_the_segment() {
    let model = model(lag(0.7), true, SEGMENT);
    let clean = motions(&trace(DefectKind::Spall, 931), 14);
    let mut hurt = clean.clone();
    let nonsense = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30];
    let mut bad = 0;
    for (burst, start) in (300..4900).step_by(460).enumerate() {
        for k in start..start + 1 + burst {
            let value = nonsense[k % nonsense.len()];
            let cell = match burst % 3 {
                0 => &mut hurt[k].current_a,
                1 => &mut hurt[k].velocity_rad_s,
                _ => &mut hurt[k].load_nm,
            };
            *cell = value;
            bad += 1;
        }
    }
    let mut detector = Detector::new(&model);
    let (spoiled, after) = (segment(&mut detector, &hurt), segment(&mut detector, &clean));
    assert_eq!((watched(&spoiled).friction_reason, spoiled.counts.rejected), (None, bad));
    assert!(finite(&spoiled) && finite(&after));
    let mut untouched = Detector::new(&model);
    let (before, expected) = (segment(&mut untouched, &clean), segment(&mut untouched, &clean));
    // A fifth of the rows is withheld while filters settle: half a deviation at most, were the rows independent, which
    // those of a filter that is sampled oftener than its bandwidth asks for are not.
    let error = furthest(&spoiled, &before);
    assert!(error < 2.0, "{error}");
    let (was, is) = (watched(&before).orders()[0].prominence, watched(&spoiled).orders()[0].prominence);
    // 2 % of the samples are lost; blocks before and after a burst keep their phases.
    assert!((is / was - 1.0).abs() < 0.05, "{is} {was}");
    // What the filters still know of the last burst, 130 samples before, is withheld; rows fall on other samples.
    assert!(furthest(&after, &expected) < 0.2, "{}", furthest(&after, &expected));
    // The record starts again: a step of the angle.
    assert_eq!(after.counts.rejected, 1);
}

#[test]
fn a_second_segment_is_that_of_a_fresh_start_but_for_what_fills_the_filters() {
    let model = model(lag(1.3), true, SEGMENT);
    let spall = Scenario { samples: 10_000, ..Scenario::STANDARD }.with_defect(Defect::full(DefectKind::Spall));
    let stream = motions(&simulate(&spall, 941).expect("simulates"), 14);
    let mut detector = Detector::new(&model);
    let _first = segment(&mut detector, &stream[..5000]);
    let second = segment(&mut detector, &stream[5000..]);
    let alone = segment(&mut Detector::new(&model), &stream[5000..]);
    // 12 rows of settling more, and other refreshments leave out other 38 of 586 rows: √(88/586) = 0.4 deviations.
    assert!(furthest(&second, &alone) < 0.9, "{}", furthest(&second, &alone));
    // Cells begin elsewhere, so other blocks contain the reversals; slips differ by their systematic error besides. The
    // score of a healthy bearing is within about 3.
    let [own, other] = [&second, &alone].map(|report| watched(report).orders()[0]);
    assert!(own.score > 9.0 && other.score > 9.0, "{own:?} {other:?}");
    assert!((own.amplitude - other.amplitude).abs() < 3.0 * other.deviation, "{own:?} {other:?}");
    assert!((own.slip - other.slip).abs() < 0.002 + 3.0 * other.slip_deviation, "{own:?} {other:?}");
    let [second, alone] = [&second, &alone].map(|report| watched(report).friction.rows);
    assert!(second > alone && second <= 625);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bits_give_finite_numbers_or_a_reason(seed: u64, wide: bool, delay in 0.0_f32..=2.5) {
        let plain = model(lag(delay), true, SEGMENT);
        let mut constants = plain.constants().clone();
        if wide {
            // Nearly all floats are let in.
            for channel in &mut constants.channels {
                (channel.limit, channel.saturation) = (1e12, 1e12);
            }
            constants.shaft[0].balance.scale = [1.0 / 1024.0; 8];
        }
        let model = Model::new(plain.plan(), constants).expect("good");
        let mut detector = Detector::new(&model);
        let mut state = seed;
        let mut bits = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 32) as u32
        };
        for _ in 0..25 {
            let nonsense: Vec<_> = (0..SEGMENT).map(|_| {
                let [current_a, velocity_rad_s, reference_rad_s, load_nm] = std::array::from_fn(|_| f32::from_bits(bits()));
                let angle = Angle::from_bits(bits());
                Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle }
            }).collect();
            let report = segment(&mut detector, &nonsense);
            prop_assert!(finite(&report), "{report:?}");
        }
        // And it recovers: a jump from the last believable nonsense is in the first segment, and nothing in the second.
        let clean = motions(&trace(DefectKind::Healthy, 961), 14);
        let mut untouched = Detector::new(&model);
        let [joint, after] = [(); 2].map(|()| segment(&mut detector, &clean));
        let [_, expected] = [(); 2].map(|()| segment(&mut untouched, &clean));
        prop_assert!(finite(&joint));
        prop_assert_eq!(watched(&after).friction_reason, watched(&expected).friction_reason);
        // Rows fall on other samples, whose noise is partly another: nonsense that stayed would be thousands of
        // deviations.
        prop_assert!(furthest(&after, &expected) < 2.0, "{}", furthest(&after, &expected));
    }
}

#[test]
fn at_constant_speed_orders_stand_without_friction() {
    let mut steady = motions(&trace(DefectKind::Spall, 931), 32);
    let step = Angle::from_radians(0.06);
    let (mut angle, mut way) = (Angle::ZERO, 0.0_f64);
    for motion in &mut steady {
        angle = angle.plus(step);
        way += 0.06 / std::f64::consts::TAU;
        let drag = 0.2 * (std::f64::consts::TAU * 3.717_94 * way).cos();
        *motion = Motion { current_a: drag as f32, velocity_rad_s: 30.0, reference_rad_s: 30.0, load_nm: 0.0, angle };
    }
    let report = run(&model(lag(0.7), true, 2 * SEGMENT), &steady);
    let estimate = watched(&report);
    assert_eq!((estimate.friction_reason, estimate.orders_reason), (None, None));
    // At constant speed the prior holds what cannot be separated; friction and offset together are determined.
    let Friction { drag, offset, viscous, .. } = estimate.friction;
    assert!(viscous.score.abs() < 1.0 && drag.deviation > 0.05, "{estimate:?}");
    assert!((drag.value + offset.value).abs() < 0.01, "{estimate:?}");
    // Every block alike, so P is nearly 1 + 7 |A|² W/σ²; the amplitude that passes the delays' interpolation is 0.2 A.
    let outer = estimate.orders()[0];
    // The score is near its largest value, 1/√b, at control orders whose scatter counts at most.
    assert!((12.0..14.0).contains(&outer.score) && (outer.amplitude / 0.2 - 1.0).abs() < 0.02, "{outer:?}");
    assert!(outer.slip.abs() < outer.slip_deviation, "{outer:?}");
    let inner = estimate.orders()[1];
    assert!(inner.score < 4.0, "{inner:?}");
}
