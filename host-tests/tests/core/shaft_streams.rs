//! The shaft on streams that no laboratory would record, and across segments.

use bearing_watch::model::{
    Channel, Constants, Feature, Field, KNOTS, Lags, Novelty, Rise, ShaftConstants, TrackedOrder,
};
use bearing_watch::plan::{Layout, LayoutError, Plan, RunTime, ShaftLayout};
use bearing_watch::shaft::{Friction, OrderStrength, ShaftEstimate};
use bearing_watch::{Angle, Detector, Model, ModelError, Part, Reason, Report};
use proptest::prelude::*;
use rig::{Defect, DefectKind, NoiseSource, Scenario, Stream, simulate};

use crate::rig::{Motion, lag, model, motions, parameters, run, trace};

const SEGMENT: u32 = 5000;

/// The report of a whole segment.
fn segment(detector: &mut Detector<'_, RunTime>, motions: &[Motion]) -> Report<RunTime> {
    let mut reports = motions.iter().filter_map(|motion| detector.step(&motion.sample(4)));
    let report = reports.next().expect("a whole segment");
    assert!(reports.next().is_none());
    report
}

fn watched(report: &Report<RunTime>) -> &ShaftEstimate<RunTime> {
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

#[test]
fn samples_lost_at_the_start_leave_no_jump_in_the_residual() {
    let plain = model(Lags { load: 5.0, ..Lags::default() }, true, 2 * SEGMENT);
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
fn stuck_sensors_and_a_shaft_at_rest_are_reasons() {
    let plain = model(lag(0.7), true, 2 * SEGMENT);
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
fn binary_model_keeps_the_shaft_and_refuses_nonsense() {
    let good = model(lag(0.7), true, SEGMENT);
    let mut buffer = vec![0; 4096];
    let length = good.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Model::<RunTime>::from_bytes(&buffer[..length]).as_ref(), Ok(&good));

    let refused = |field: Field, change: fn(&mut ShaftConstants<RunTime>, &mut [Channel])| {
        let mut bad = good.constants().clone();
        let Constants { shaft, channels, .. } = &mut bad;
        change(&mut shaft[0], channels);
        let error = Err(ModelError::OutOfRange(field));
        assert_eq!(Model::new(good.plan(), bad.clone()).map(|_| ()), error, "{field:?} is accepted");
        let mut buffer = vec![0; 4096];
        let length = Model::identified(good.plan(), bad, good.id()).to_bytes("", &mut buffer).expect("fits");
        assert_eq!(Model::<RunTime>::from_bytes(&buffer[..length]).map(|_| ()), error, "{field:?} is read");
    };
    refused(Field::SignalLag, |m, _| m.lags.current = 5.1);
    refused(Field::SignalLag, |m, _| m.lags.velocity = -0.1);
    refused(Field::SignalLag, |m, _| m.lags.load = f32::NAN);
    refused(Field::BalanceInterval, |m, _| m.balance.interval_s = 0.0);
    refused(Field::BalanceFilter, |m, _| m.balance.filter.gain = 0.0);
    // The damping of another cut-off.
    refused(Field::BalanceFilter, |m, _| m.balance.filter.damping *= 1.1);
    refused(Field::RowInterval, |m, _| m.balance.row_interval = 0);
    refused(Field::RowInterval, |m, _| m.balance.row_spread = 0.9);
    refused(Field::BalanceVelocity, |m, _| m.balance.sign_velocity_rad_s = 0.0);
    refused(Field::BalanceVelocity, |m, _| m.balance.stribeck_velocity_rad_s = f32::INFINITY);
    refused(Field::BalanceScale, |m, _| m.balance.scale[0] = 0.3);
    refused(Field::LimitTimesScale, |m, _| m.balance.scale[3] = 2.0_f32.powi(50));
    refused(Field::LimitTimesScale, |m, _| m.balance.scale[7] = 2.0_f32.powi(50));
    refused(Field::BalanceNominal, |m, _| m.balance.nominal[4] = f32::INFINITY);
    refused(Field::BalancePrior, |m, _| m.balance.prior[6] = 0.0);
    refused(Field::BalancePrior, |m, _| m.balance.deviation = f32::NAN);
    refused(Field::LargestChange, |m, _| m.balance.largest_change_rad = 0.0);
    refused(Field::LargestChange, |m, _| m.balance.largest_change_rad = f32::NAN);
    refused(Field::ChannelLimit, |_, channels| channels[0].limit = f32::INFINITY);
    refused(Field::StuckSamples, |_, channels| channels[1].stuck_samples = 1);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[1].order_q16 = 0);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[1].order_q16 = -70_000);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[0].weights = [0.0; 3]);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[0].weights[1] = -0.1);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[1].slip_ratio = 11.0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[0] = 0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[1] = 0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[2] = 0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[3] = 0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[0] = i32::MAX);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[1] = i32::MAX);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[2] = i32::MAX);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[3] = i32::MAX);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.cell_turns_log2 = -7);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.cell_turns_log2 = 11);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.slip = 0.2);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.slowest_rad_s = 0.0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.pole = 1.0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.high_pass = 1.0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.high_pass = -0.01);

    let with = |change: fn(&mut Constants<RunTime>)| {
        let mut constants = good.constants().clone();
        change(&mut constants);
        Model::new(good.plan(), constants).map(|_| ())
    };
    // A gate whose only coordinate rises.
    let gated = |rising: u8, change: fn(&mut Novelty<RunTime>)| {
        let mut constants = good.constants().clone();
        let line = std::array::from_fn(|k| [k as f32; 2]);
        let novelty = &mut constants.classifier.novelty;
        (novelty.class, novelty.limit, novelty.knots) = (Some(0), 4.6, line);
        novelty.factor.fill(1.0);
        (novelty.freedom, novelty.laws) = (20.0, vec![[[0.0; 2]; KNOTS], line]);
        (novelty.acceptable, novelty.rises) = (2.0, vec![Rise { fall: 1.0, reach: 4.0 }; 2]);
        change(novelty);
        Model::new(RunTime::of(Layout { rising, ..good.plan().layout() }).expect("a plan"), constants)
    };
    let rising = gated(1, |_| ()).expect("good");
    let length = rising.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Model::<RunTime>::from_bytes(&buffer[..length]).as_ref(), Ok(&rising));
    let error = |change: fn(&mut Novelty<RunTime>)| gated(1, change).map(|_| ());
    let place = Err(ModelError::OutOfRange(Field::RisingCoordinates));
    let absent = Err(ModelError::Length(Field::RisingCoordinates));
    assert_eq!(error(|novelty| novelty.laws.clear()), absent);
    assert_eq!(gated(0, |_| ()).map(|_| ()), absent);
    assert_eq!(error(|novelty| novelty.rises.clear()), absent);
    assert_eq!(error(|novelty| novelty.freedom = f32::NAN), place);
    assert_eq!(error(|novelty| novelty.acceptable = 1.0), place);
    assert_eq!(error(|novelty| novelty.rises[1].fall = -1.0), place);
    assert_eq!(error(|novelty| novelty.rises[1].reach = f32::NAN), place);
    assert_eq!(error(|novelty| novelty.laws[1][4] = [3.0; 2]), Err(ModelError::OutOfRange(Field::SurpriseCurve)));

    let count = with(|c| c.shaft[0].tracking.orders.push(TrackedOrder::new(2.0, [1.0, 0.0, 0.0])));
    assert_eq!(count, Err(ModelError::Length(Field::BearingOrder)));
    let unwatched = with(|c| c.shaft.clear());
    assert!(matches!(unwatched, Err(ModelError::Length(_))), "{unwatched:?}");
    let untracked = with(|c| c.classifier.features[0] = Feature::OrderScore(3));
    assert_eq!(untracked, Err(ModelError::OutOfRange(Field::Feature)), "an order that is not tracked");
    let absent = with(|c| c.classifier.features[0] = Feature::LogVariance);
    assert_eq!(absent, Err(ModelError::OutOfRange(Field::Feature)), "a regression that there is not");
    let layout = good.plan().layout();
    for (orders, harmonics) in [(3, 4), (3, 0), (33, 3)] {
        let shaft = layout.shaft.map(|shaft| ShaftLayout { orders, harmonics, ..shaft });
        assert_eq!(Layout { shaft, ..layout }.check(), Err(LayoutError::Orders));
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
