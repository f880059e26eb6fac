//! The shaft's side against oracles in f64.

use bearing_watch::plan::{Plan, RunTime};
use bearing_watch::{Bearing, Model};
use workbench::rig::{BearingGeometry, DefectKind, NoiseSource, Stream};

mod oracle;
mod orders;

use crate::rig::{Motion, lag, model, motions, parameters, run, trace};

/// More samples than any of the streams has.
const OPEN: u32 = 100_000;

/// Friction: f32 sums of a thousand rows keep 0.02 of a deviation. Orders: sines are exact to 2e-5 and parameters of the
/// residual to 0.02 deviations, which is a thousandth of the noise's phasors.
fn compare(model: &Model<RunTime>, motions: &[Motion], what: &str) {
    let load = model.plan().layout().shaft.is_some_and(|shaft| shaft.load.is_some());
    let constants = &model.constants().shaft[0];
    let expected = oracle::expected(constants, load, motions);
    let report = run(model, motions);
    let found = report.shaft().expect("watched");
    assert_eq!((found.friction_reason, found.friction.rows as usize), (None, expected.rows), "{what}");
    let own = parameters(&found.friction);
    assert_eq!(own.len(), expected.parameters.len(), "{what}");
    for (k, (own, (p, sd))) in own.iter().zip(&expected.parameters).enumerate() {
        let (value, deviation) = (f64::from(own.value), f64::from(own.deviation));
        assert!((value - p).abs() < 0.02 * sd, "{what}: parameter {k} is {value}, not {p} ± {sd}");
        assert!((deviation / sd - 1.0).abs() < 0.02, "{what}: deviation {k} is {deviation}, not {sd}");
    }
    let balance = &constants.balance;
    let drag = balance.nominal[2] + balance.nominal[1] * balance.usual_velocity_rad_s;
    let nominal = [&balance.nominal[..], &[drag]].concat();
    let places = (0..8).filter(|place| load || ![3, 5].contains(place));
    for (own, place) in own.iter().zip(places) {
        let (value, deviation, nominal) = (f64::from(own.value), f64::from(own.deviation), f64::from(nominal[place]));
        let score = (value - nominal) / deviation;
        // One subtraction and one division.
        let near = (f64::from(own.score) - score).abs() < 1e-5 * (score.abs() + value.abs() / deviation);
        assert!(near, "{what}: score {place} is {}, not {score}", own.score);
    }
    assert!((f64::from(found.friction.variance) / expected.variance - 1.0).abs() < 0.01, "{what}: variance");
    assert_eq!((found.orders_reason, found.orders().len()), (None, expected.orders.len()), "{what}");
    for (k, (own, order)) in found.orders().iter().zip(&expected.orders).enumerate() {
        let near = |name: &str, own: f32, expected: f64, within: f64| {
            assert!((f64::from(own) - expected).abs() < within, "{what}: order {k}: {name} {own}, not {expected}");
        };
        near("prominence", own.prominence, order.prominence, 2e-3 * order.prominence.max(0.5));
        // The score is a cube root over a deviation of 0.1 to 0.2.
        near("score", own.score, order.score, 0.01 + 1e-3 * order.score.abs());
        near("amplitude", own.amplitude, order.amplitude, 2e-3 * order.amplitude + 0.02 * order.deviation);
        near("deviation", own.deviation, order.deviation, 1e-3 * order.deviation);
        // The vertex of a flat peak moves further.
        near("slip", own.slip, order.slip, 0.01 * order.slip_deviation);
        near("slip deviation", own.slip_deviation, order.slip_deviation, 0.01 * order.slip_deviation);
    }
}

#[test]
fn estimates_are_those_of_the_oracle() {
    let kinds = [DefectKind::Healthy, DefectKind::Spall, DefectKind::Roughness];
    for (seed, kind) in (901..).zip(kinds) {
        let trace = trace(kind, seed);
        for delay in [0.0, 0.7, 1.3, 2.5] {
            for bits in [32, 12] {
                compare(
                    &model(lag(delay), true, OPEN),
                    &motions(&trace, bits),
                    &format!("{kind:?}, delay {delay}, {bits} bits"),
                );
            }
            let mut offset = motions(&trace, 16);
            offset.iter_mut().for_each(|motion| motion.current_a += 0.4);
            compare(&model(lag(delay), true, OPEN), &offset, &format!("{kind:?}, delay {delay}, offset"));
            offset.iter_mut().for_each(|motion| motion.load_nm = 0.0);
            compare(&model(lag(delay), false, OPEN), &offset, &format!("{kind:?}, delay {delay}, load not measured"));
        }
    }
}

/// A shaft that stops for good while, and comes back the other way: the sine reverses by itself.
#[test]
fn standstill_turns_no_phase_and_counts_for_nothing() {
    let mut stopped = motions(&trace(DefectKind::Spall, 911), 16);
    // The reference passes zero at 2500 samples.
    let (rest, mut noise) = (stopped[2500].angle, NoiseSource::new(1, Stream::Conditions));
    let hold = |_| Motion {
        current_a: 0.1 * noise.gaussian() as f32,
        velocity_rad_s: 0.5 * noise.gaussian() as f32,
        angle: rest,
        ..Motion::default()
    };
    let still: Vec<Motion> = (0..1200).map(hold).collect();
    stopped.splice(2500..2500, still);
    let model = model(lag(0.7), true, OPEN);
    compare(&model, &stopped, "standstill");
    let report = run(&model, &stopped);
    let outer = report.shaft().expect("watched").orders()[0];
    assert!(outer.prominence > 5.0, "the phase was lost at rest: {outer:?}");
}

#[test]
fn the_spall_stands_out_at_its_order_only_and_the_roughness_in_its_parameter() {
    let model = model(lag(0.7), true, OPEN);
    let of = |kind| run(&model, &motions(&trace(kind, 921), 14)).shaft().expect("watched").clone();
    let [healthy, spall, rough] = [DefectKind::Healthy, DefectKind::Spall, DefectKind::Roughness].map(of);
    // 49 blocks at most; mean one and 1 % above 4.5 where there is nothing.
    assert!(
        spall.orders()[0].prominence > 10.0
            && healthy.orders()[0].prominence < 5.0
            && rough.orders()[0].prominence < 5.0
    );
    assert!(spall.orders()[1].prominence < 5.0);
    // ΔB/Kt = 0.04 A s/rad.
    let [of_healthy, of_rough] = [&healthy, &rough].map(|estimate| estimate.friction.viscous.value);
    assert!((of_rough - of_healthy - 0.04).abs() < 2e-3, "{of_rough} {of_healthy}");
    let close = |found: Option<f32>, truth: f32| found.is_some_and(|found| (found / truth - 1.0).abs() < 0.1);
    let friction = rough.friction;
    assert!(close(friction.torque_constant_nm_a().map(|(kt, _)| kt), 0.05) && close(friction.inertia_kg_m2(), 2.5e-4));
    assert!(close(friction.viscous_nm_s_rad(), 2.1e-3), "{friction:?}");
    assert!(friction.coulomb_nm().is_some_and(|torque| torque.abs() < 2e-3), "{friction:?}");
}

#[test]
fn orders_are_those_of_the_rig() {
    let rig = BearingGeometry::THESIS;
    let own = Bearing {
        balls: rig.balls as u8,
        ball_diameter: rig.ball_diameter_mm as f32,
        pitch_diameter: rig.pitch_diameter_mm as f32,
        contact_angle_rad: rig.contact_angle_rad as f32,
    };
    let orders = rig.orders();
    let pairs = [
        (own.outer(), orders.outer),
        (own.inner(), orders.inner),
        (own.ball(), orders.ball),
        (own.cage(), orders.cage),
    ];
    // Three f32 roundings of numbers below ten.
    assert!(pairs.iter().all(|(own, rig)| (f64::from(*own) - rig).abs() < 2e-6), "{pairs:?}");
}
