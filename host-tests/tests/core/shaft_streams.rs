//! The shaft's side on streams that no laboratory would record, across segments, and across its two ways of concluding.

use bearing_watch::decide::{Classifier, Features};
use bearing_watch::estimate::{OrderTracking, TrackedOrder, Tracking, Triangle, Watch};
use bearing_watch::{
    Angle, Detector, Guard, Model, ModelError, Motion, Reason, Regression, Regressor, Sample, Shaft, ShaftEstimate,
    ShaftModel, Verdict,
};
use proptest::prelude::*;
use workbench::rig::{Defect, DefectKind, NoiseSource, Scenario, Stream, simulate};

#[path = "shaft/common.rs"]
mod common;
#[allow(dead_code, reason = "its detector is spelt out here")]
#[path = "../../../examples/support/standard_rig/model.rs"]
mod exported;

use common::{model, motions, run, trace};

fn segment<const K: usize>(shaft: &mut Shaft<K>, model: &ShaftModel<K>, motions: &[Motion]) -> ShaftEstimate<K> {
    motions.iter().for_each(|motion| shaft.step(Some(model), motion));
    let estimate = model.conclude(&shaft.sums().expect("watching"));
    shaft.next_segment();
    estimate
}

fn finite<const K: usize>(estimate: &ShaftEstimate<K>) -> bool {
    let friction = &estimate.friction;
    let numbers = friction.parameters.iter().chain(&friction.deviations).chain(&friction.scores);
    let orders = estimate.orders.iter().flat_map(|order| [&order.prominence, &order.amplitude]);
    numbers.chain(orders).all(|x| x.is_finite()) && friction.variance.is_finite()
}

/// Furthest parameter from another estimate's, in that one's deviations.
fn furthest<const K: usize>(one: &ShaftEstimate<K>, other: &ShaftEstimate<K>) -> f32 {
    let pairs = one.friction.parameters.iter().zip(&other.friction.parameters).zip(&other.friction.deviations);
    pairs.map(|((p, q), sd)| ((p - q) / sd).abs()).fold(0.0, f32::max)
}

#[test]
fn bursts_of_nonsense_are_counted_and_bounded_and_gone_with_the_segment() {
    let model = model(0.7);
    let clean = motions(&trace(DefectKind::Spall, 931), 14);
    let mut hurt = clean.clone();
    let nonsense = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30];
    let mut bad = 0;
    for (burst, start) in (300..4900).step_by(460).enumerate() {
        for k in start..start + 1 + burst {
            let value = nonsense[k % nonsense.len()];
            let cell = match burst % 4 {
                0 => &mut hurt[k].current_a,
                1 => &mut hurt[k].velocity_rad_s,
                2 => &mut hurt[k].reference_rad_s,
                _ => &mut hurt[k].load_nm,
            };
            *cell = value;
            bad += 1;
        }
    }
    let mut shaft = Shaft::new(Some(&model));
    let (spoiled, after) = (segment(&mut shaft, &model, &hurt), segment(&mut shaft, &model, &clean));
    assert_eq!((spoiled.reason, spoiled.counts.rejected), (None, bad));
    assert!(finite(&spoiled) && finite(&after));
    let mut untouched = Shaft::new(Some(&model));
    let (before, expected) = (segment(&mut untouched, &model, &clean), segment(&mut untouched, &model, &clean));
    // A fifth of the rows is withheld while filters settle: half a deviation at most, were the rows independent, which those
    // of a filter that is sampled oftener than its bandwidth asks for are not.
    let error = furthest(&spoiled, &before);
    assert!(error < 2.0, "{error}");
    let (was, is) = (before.orders[0].prominence, spoiled.orders[0].prominence);
    assert!((is / was - 1.0).abs() < 0.1, "{is} {was}");
    // What the filters still know of the last burst, 130 samples before, is withheld; rows fall on other samples.
    assert!(furthest(&after, &expected) < 0.2, "{}", furthest(&after, &expected));
    assert_eq!(after.counts.rejected, 0);
}

#[test]
fn a_second_segment_is_that_of_a_fresh_start_but_for_what_fills_the_filters() {
    let model = model(1.3);
    // Roughness: what the shaft drags at a reversal then follows the balance, so that all rows say the same.
    let rough = Scenario { samples: 10_000, ..Scenario::STANDARD }.with_defect(Defect::full(DefectKind::Roughness));
    let stream = motions(&simulate(&rough, 941).expect("simulates"), 14);
    let mut shaft = Shaft::new(Some(&model));
    let _first = segment(&mut shaft, &model, &stream[..5000]);
    let second = segment(&mut shaft, &model, &stream[5000..]);
    let alone = run(&model, &stream[5000..]);
    // 13 rows of settling more, of 612: √(13/612) = 0.15 deviations, twice that with rows that are not independent.
    assert!(furthest(&second, &alone) < 0.5, "{}", furthest(&second, &alone));
    // Five samples more, and all blocks cut five samples earlier: what is left of a strong order, and less than that of noise.
    for (own, other) in second.orders.iter().zip(&alone.orders) {
        assert!((own.prominence - other.prominence).abs() < 0.3, "{second:?} {alone:?}");
    }
    assert!(second.friction.rows > alone.friction.rows && second.friction.rows <= 625);
}

#[test]
fn stuck_sensors_and_a_shaft_at_rest_are_reasons() {
    let mut watchful = model(0.7);
    watchful.guard.stuck_samples = [50; 3];
    let clean = motions(&trace(DefectKind::Healthy, 951), 14);
    assert_eq!(run(&watchful, &clean).reason, None);
    for signal in 0..3_u8 {
        let mut hurt = clean.clone();
        for motion in &mut hurt[1000..1100] {
            *[&mut motion.current_a, &mut motion.velocity_rad_s, &mut motion.load_nm][usize::from(signal)] = 0.25;
        }
        let estimate = run(&watchful, &hurt);
        assert_eq!((estimate.reason, estimate.counts.stuck[usize::from(signal)]), (Some(Reason::Stuck(signal)), true));
    }
    let mut noise = NoiseSource::new(3, Stream::Conditions);
    let at_rest: Vec<Motion> = (0..5000)
        .map(|_| Motion {
            current_a: noise.gaussian() as f32,
            velocity_rad_s: noise.gaussian() as f32,
            ..Motion::default()
        })
        .collect();
    let rest = run(&model(0.7), &at_rest);
    // Nothing turns, so there is no order either.
    assert_eq!(rest.orders_reason, Some(Reason::TooFewRows));
    let reason = rest.reason;
    assert!(matches!(reason, Some(Reason::NotExcited(_))), "{reason:?}");
    assert_eq!(run(&model(0.7), &clean[..50]).reason, Some(Reason::TooFewRows));
    assert!(Shaft::<3>::new(None).sums().is_none());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bits_give_finite_numbers_or_a_reason(seed: u64, wide: bool, delay in 0.0_f32..=2.5) {
        let mut model = model(delay);
        if wide {
            // Nearly all floats are let in.
            model.guard = Guard::within([1e12; 3]);
            model.balance.scale = [1.0 / 1024.0; 4];
        }
        let mut shaft = Shaft::new(Some(&model));
        let mut state = seed;
        let mut bits = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 32) as u32
        };
        for _ in 0..25 {
            for _ in 0..5000 {
                let [current_a, velocity_rad_s, reference_rad_s, load_nm] = std::array::from_fn(|_| f32::from_bits(bits()));
                let angle = Angle::from_bits(bits());
                shaft.step(Some(&model), &Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle });
            }
            let estimate = model.conclude(&shaft.sums().expect("watching"));
            prop_assert!(finite(&estimate), "{estimate:?}");
            shaft.next_segment();
        }
        // And it recovers: a jump from the last believable nonsense is in the first segment, and nothing in the second.
        let clean = motions(&trace(DefectKind::Healthy, 961), 14);
        let mut untouched = Shaft::new(Some(&model));
        let [joint, after] = [(); 2].map(|()| segment(&mut shaft, &model, &clean));
        let [_, expected] = [(); 2].map(|()| segment(&mut untouched, &model, &clean));
        prop_assert!(finite(&joint));
        prop_assert_eq!(after.reason, expected.reason);
        // Rows fall on other samples, whose noise is partly another: nonsense that stayed would be thousands of deviations.
        prop_assert!(furthest(&after, &expected) < 2.0, "{}", furthest(&after, &expected));
    }
}

/// The exported model with a shaft to watch, and features of both.
fn watching() -> Model<6, 5, 5, 3, 4> {
    let plain = exported::MODEL;
    let ShaftModel { guard, current_delay, balance, tracking } = model(0.7);
    let mut orders = [TrackedOrder::NONE; 4];
    orders[..3].copy_from_slice(&tracking.orders);
    let Tracking { count, harmonics, still, block_samples, .. } = tracking;
    let tracking = Tracking { orders, count, harmonics, still, block_samples };
    Model {
        sampling: plain.sampling,
        // A deferred solve needs time to take over.
        regression: Regression { handover: 4, ..plain.regression },
        shaft: Some(ShaftModel { guard, current_delay, balance, tracking }),
        classifier: Classifier { features: Features { index: [0, 1, 129, 160, 192], count: 5 }, ..plain.classifier },
        evidence: plain.evidence,
        labels: plain.labels,
    }
}

type Watching<'m> = Detector<'m, 6, 15, 1, 5, 5, 3, Regressor<6, 1>, Triangle<6, 15>, Shaft<4>, 4>;

#[test]
fn collected_and_concluded_is_stepped() {
    let model = watching();
    let (mut stepping, mut collecting) = (Watching::new(&model).expect("good"), Watching::new(&model).expect("good"));
    let mut reports = 0;
    let stream = motions(&trace(DefectKind::Spall, 971), 14);
    for motion in stream.iter().cycle().take(10_000) {
        let sample = Sample { y: motion.current_a, u1: motion.reference_rad_s, u2: motion.load_nm };
        let stepped = stepping.step_with_motion(sample, motion);
        let collected = collecting.collect_with_motion(sample, motion);
        let concluded = collected.map(|(segment, sums)| model.conclude_with_shaft(segment, sums));
        concluded.iter().for_each(|report| assert!(collecting.adopt(report)));
        assert_eq!(stepped, concluded);
        if let Some(report) = stepped {
            let shaft = report.shaft.expect("watched");
            assert!(
                shaft.reason.is_none() && matches!(report.verdict, Verdict::Class(_) | Verdict::Novel),
                "{report:?}"
            );
            reports += 1;
        }
    }
    assert_eq!(reports, 2);
    // Who forgets the motion gets no verdict, rather than one from zeros.
    let forgetful =
        stream.iter().find_map(|m| stepping.step(Sample { y: m.current_a, u1: m.reference_rad_s, u2: m.load_nm }));
    assert_eq!(forgetful.expect("a segment").verdict, Verdict::Undetermined(Reason::TooFewRows));
}

/// Noise of any colour has prominence R of n blocks with P(R > x) = (1 − x/n)ⁿ⁻¹, at a speed that varies and reverses.
#[test]
fn healthy_prominence_has_its_law() {
    let tracking = Tracking {
        orders: [TrackedOrder::new(3.717_94, [1.0, 0.0, 0.0]), TrackedOrder::new(5.282_06, [1.0, 0.0, 0.0])],
        count: 2,
        harmonics: 1,
        still: 1_000_000,
        block_samples: 100,
    };
    let mut noise = NoiseSource::new(5, Stream::Conditions);
    // ± 1 %: 3000 segments of two orders; white, red, and blue noise.
    for pole in [0.0, 0.7, -0.7] {
        let (trials, n) = (1500_u32, 50.0_f64);
        let (mut sum, mut beyond, mut count) = (0.0, [0_u32; 2], 0);
        let tails = [0.1, 0.01].map(|p: f64| n * (1.0 - p.powf(1.0 / (n - 1.0))));
        let (mut residual, mut time) = (0.0, 0.0_f64);
        let mut track = OrderTracking::<2>::new();
        for _ in 0..trials {
            track.next_segment();
            while track.samples() < 5000 {
                // 10 turns/s at most, 500 samples/s.
                let turned = (0.02 * time.sin() * 4_294_967_296.0) as i32;
                time += 0.003;
                residual = pole * residual + noise.gaussian();
                track.step(&tracking, turned, Some(residual as f32));
            }
            for strength in track.strengths(&tracking).expect("long enough") {
                let prominence = f64::from(strength.prominence);
                sum += prominence;
                count += 1;
                beyond.iter_mut().zip(tails).for_each(|(many, tail)| *many += u32::from(prominence > tail));
            }
        }
        let mean = sum / f64::from(count);
        // Four standard errors of 3000 draws: 0.073 of the mean, 0.022 and 0.0073 of the tails.
        assert!((mean - 1.0).abs() < 0.073, "pole {pole}: mean {mean}");
        let [tenth, hundredth] = beyond.map(|many| f64::from(many) / f64::from(count));
        assert!((tenth - 0.1).abs() < 0.022 && (hundredth - 0.01).abs() < 0.0073, "pole {pole}: {tenth} {hundredth}");
    }
}

#[test]
fn binary_model_keeps_the_shaft_and_refuses_nonsense() {
    let good = watching();
    let mut buffer = [0; 4096];
    let length = good.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Model::<6, 5, 5, 3, 4>::from_bytes(&buffer[..length]).expect("reads"), good);
    // Any sufficient capacity, and no other.
    let wide = Model::<6, 5, 5, 3, 9>::from_bytes(&buffer[..length]).expect("reads");
    assert_eq!(wide.shaft.expect("watched").tracking.orders[..4], good.shaft.expect("watched").tracking.orders);
    assert!(Model::<6, 5, 5, 3, 2>::from_bytes(&buffer[..length]).is_err());
    assert!(Model::<6, 5, 5, 3>::from_bytes(&buffer[..length]).is_err());

    let refused = |what: &str, change: fn(&mut ShaftModel<4>)| {
        let mut bad = good;
        change(bad.shaft.as_mut().expect("watched"));
        let error: Result<(), ModelError> = bad.validate();
        assert!(error.is_err(), "{what} is accepted");
        let mut buffer = [0; 4096];
        if let Ok(length) = bad.to_bytes("", &mut buffer) {
            assert!(Model::<6, 5, 5, 3, 4>::from_bytes(&buffer[..length]).is_err(), "{what} is read");
        }
    };
    refused("delay", |m| m.current_delay = 2.6);
    refused("negative delay", |m| m.current_delay = -0.1);
    refused("delay that is no number", |m| m.current_delay = f32::NAN);
    refused("interval", |m| m.balance.interval_s = 0.0);
    refused("cut-off", |m| m.balance.filter.gain = 0.0);
    refused("damping of another cut-off", |m| m.balance.filter.damping *= 1.1);
    refused("rows", |m| m.balance.row_interval = 0);
    refused("sign", |m| m.balance.sign_velocity_rad_s = 0.0);
    refused("scale", |m| m.balance.scale[0] = 0.3);
    refused("large scale", |m| m.balance.scale[3] = 1e15);
    refused("nominal", |m| m.balance.nominal[4] = f32::INFINITY);
    refused("limit", |m| m.guard.limit[0] = f32::INFINITY);
    refused("stuck", |m| m.guard.stuck_samples[1] = 1);
    refused("count", |m| m.tracking.count = 5);
    refused("harmonics", |m| m.tracking.harmonics = 4);
    refused("no harmonics", |m| m.tracking.harmonics = 0);
    refused("order", |m| m.tracking.orders[1].order_q16 = 0);
    refused("negative order", |m| m.tracking.orders[1].order_q16 = -70_000);
    refused("weights", |m| m.tracking.orders[0].weights = [0.0; 3]);
    refused("negative weight", |m| m.tracking.orders[0].weights[1] = -0.1);
    refused("block", |m| m.tracking.block_samples = 1);

    let silent = Model { shaft: None, ..good };
    assert!(silent.validate().is_err(), "features of a shaft that is not watched");
    let mut other = good;
    other.classifier.features.index[4] = 163;
    assert!(other.validate().is_err(), "an order that is not tracked");
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
    let estimate = run(&model(0.7), &steady);
    assert!(estimate.reason.is_some() && estimate.orders_reason.is_none(), "{estimate:?}");
    // Every block alike, so R(1) is nearly their number, 48; it weighs 1 of 1.6.
    assert!(estimate.orders[0].prominence > 25.0, "{estimate:?}");
}
