//! The shaft's side against oracles in f64.

use bearing_watch::model::{Lags, ShaftConstants};
use bearing_watch::plan::{Layout, Load, Plan as _, RunTime, ShaftLayout};
use bearing_watch::shaft::{Bearing, ShaftEstimate};
use bearing_watch::{FrictionTerm, Model};
use rig::field::{Field, FieldValues, Slip};
use rig::{BearingGeometry, Defect, DefectKind, NoiseSource, Scenario, Stream, simulate};

pub mod dc_motor;
mod oracle;
mod orders;
pub mod streams;

use crate::shaft::dc_motor::{Motion, halved, lag, model, model_of_angle, motions, parameters, run, trace};

/// More samples than any of the streams has.
pub const OPEN: u32 = 100_000;

/// Friction: f32 sums of a thousand rows keep 0.02 of a deviation. Orders: sines are exact to 2e-5 and parameters of
/// the residual to 0.02 deviations, which is a thousandth of the noise's phasors.
fn compare(model: &Model<RunTime>, motions: &[Motion], what: &str) {
    compare_own(model, motions, what);
    compare_own(&halved(model), motions, &format!("{what}, each second sample"));
}

fn compare_own(model: &Model<RunTime>, motions: &[Motion], what: &str) {
    let layout = model.plan().layout().shaft.expect("watched");
    let load = layout.load.measured().is_some();
    let weighs = matches!(layout.load, Load::Weight { .. });
    let constants = &model.constants().shaft[0];
    let expected = oracle::expected(constants, (layout.load, layout.decimation.into()), motions);
    let report = run(model, motions);
    let found = report.shaft().expect("watched");
    assert_eq!((found.friction_reason, found.friction.rows as usize), (None, expected.rows), "{what}");
    // Two parameters of a weight have its amplitude alone.
    let [of_parameters, of_rows] =
        if weighs { expected.without_phase() } else { [expected.parameters.clone(), expected.of_rows.clone()] };
    let own = parameters(&found.friction);
    assert_eq!(own.len(), of_parameters.len(), "{what}");
    for (k, (own, (p, sd))) in own.iter().zip(&of_parameters).enumerate() {
        let (value, deviation) = (f64::from(own.value), f64::from(own.deviation));
        assert!((value - p).abs() < 0.02 * sd, "{what}: parameter {k} is {value}, not {p} ± {sd}");
        assert!((deviation / sd - 1.0).abs() < 0.02, "{what}: deviation {k} is {deviation}, not {sd}");
    }
    let terms = FrictionTerm::ALL.into_iter().filter(|term| load || !term.needs_load()).collect::<Vec<_>>();
    for (k, (own, (p, sd))) in terms.iter().zip(&of_rows).enumerate() {
        let (value, variance) = constants.balance.without_prior(&found.friction, *own);
        let (value, deviation) = (f64::from(value), f64::from(variance).sqrt());
        // Where the rows tell less, the error of p counts more.
        let usual = f64::from(found.friction.parameter(*own).expect("estimated").deviation);
        assert!((value - p).abs() < 0.02 * sd * (sd / usual), "{what}: {k}: rows alone say {value}, not {p} ± {sd}");
        assert!((deviation / sd - 1.0).abs() < 0.02, "{what}: {k}: deviation by rows {deviation}, not {sd}");
    }
    let balance = &constants.balance;
    let weights = oracle::drag_weights(balance);
    let drag = weights.iter().zip(balance.nominal).map(|(weight, p)| weight * f64::from(p)).sum::<f64>() as f32;
    let nominal = [&balance.nominal[..], &[drag]].concat();
    let places = (0..8).filter(|place| load || ![3, 5].contains(place)).map(Some).chain([None]);
    for (own, place) in own.iter().zip(places) {
        // The nominal amplitude of a weight is 0.
        let nominal = place.map_or(0.0, |place: usize| f64::from(nominal[place]));
        let (value, deviation) = (f64::from(own.value), f64::from(own.deviation));
        let score = (value - nominal) / deviation;
        // One subtraction and one division.
        let near = (f64::from(own.score) - score).abs() <= 1e-5 * (score.abs() + value.abs() / deviation);
        assert!(near, "{what}: score {place:?} is {}, not {score}", own.score);
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
            let late = Lags { current: delay, velocity: 0.4, load: 5.0 };
            compare(&model(late, true, OPEN), &offset, &format!("{kind:?}, delay {delay}, load late"));
            offset.iter_mut().for_each(|motion| motion.load_nm = 0.0);
            compare(&model(lag(delay), false, OPEN), &offset, &format!("{kind:?}, delay {delay}, load not measured"));
        }
    }
}

/// The same model with a weight on an axis, by so many turns of the motor for one of the axis.
fn weighing(model: &Model<RunTime>, turns: f64, changes: bool) -> Model<RunTime> {
    let layout = model.plan().layout();
    let load = Load::Weight { axis_q32: (4_294_967_296.0 / turns) as u32, changes };
    let plan = RunTime::of(Layout { shaft: layout.shaft.map(|shaft| ShaftLayout { load, ..shaft }), ..layout });
    let mut constants = model.constants().clone();
    for ShaftConstants { balance, .. } in &mut constants.shaft {
        (balance.adapt_after_rows, balance.usual_load_nm) = (8, 0.0);
        (balance.nominal[3], balance.prior[3], balance.prior[5]) = (0.0, 9.0, 9.0);
        (balance.scale[3], balance.scale[5]) = (1.0, 1.0);
    }
    Model::new(plan.expect("a plan"), constants).expect("a good model")
}

/// A weight of 3 A whose axis starts anywhere, beside the load that is not measured.
#[test]
fn a_weight_on_an_axis_is_that_of_the_oracle() {
    for (seed, turns) in [(941, 50.0), (942, 5.0), (943, 160.0)] {
        let (mut own, mut travelled) = (motions(&trace(DefectKind::Spall, seed), 16), 0.0);
        let mut last = own[0].angle;
        for motion in &mut own {
            travelled += f64::from(motion.angle.since(last)) / 4_294_967_296.0 / turns;
            last = motion.angle;
            let torque = 3.0 * (std::f64::consts::TAU * (travelled + 0.3)).cos();
            motion.current_a += (torque - 20.0 * f64::from(motion.load_nm)) as f32;
            motion.load_nm = 0.0;
        }
        let steady = model(lag(0.7), false, OPEN);
        let changing = weighing(&steady, turns, true);
        compare(&changing, &own, &format!("one turn in {turns}, may change"));
        let model = weighing(&steady, turns, false);
        compare(&model, &own, &format!("one turn in {turns}"));
        let (weight, deviation) = run(&model, &own).shaft().expect("watched").friction.weight_a().expect("a weight");
        // Over a part of a turn the weight is hardly told from the offset.
        assert!((weight - 3.0).abs() < 5.0 * deviation + 0.02, "{turns}: {weight} ± {deviation}");
        if turns < 10.0 {
            assert!((weight - 3.0).abs() < 0.05, "{turns}: {weight} ± {deviation}");
        }
    }
}

/// The residual with the nominal parameters throughout, without and with a faster high-pass.
#[test]
fn nominal_parameters_and_the_high_pass_are_those_of_the_oracle() {
    let good = model(lag(0.7), true, OPEN);
    for high_pass in [0.0, 0.1] {
        let mut constants = good.constants().clone();
        for shaft in &mut constants.shaft {
            (shaft.balance.adapt_after_rows, shaft.tracking.blocks.high_pass) = (u16::MAX, high_pass);
        }
        let nominal = Model::new(good.plan(), constants).expect("valid");
        compare(&nominal, &motions(&trace(DefectKind::Spall, 931), 16), &format!("nominal, high-pass {high_pass}"));
    }
}

/// The motions with the mean velocity since the last sample that is not lost.
pub fn differenced(mut motions: Vec<Motion>) -> Vec<Motion> {
    let (mut last, mut held): (Option<(usize, bearing_watch::Angle)>, f64) = (None, 0.0);
    for (k, motion) in motions.iter_mut().enumerate().filter(|(_, motion)| motion.current_a.is_finite()) {
        if let Some((from, angle)) = last.replace((k, motion.angle)) {
            let turns = f64::from(motion.angle.since(angle)) / 4_294_967_296.0;
            let passed_s = 0.002 * (k - from) as f64;
            // Over lost samples the shaft turns as often as at the velocity before.
            let whole = if k - from > 1 { (held * passed_s / std::f64::consts::TAU - turns).round() } else { 0.0 };
            held = std::f64::consts::TAU * (turns + whole) / passed_s;
            motion.velocity_rad_s = held as f32;
        }
    }
    motions
}

#[test]
fn a_velocity_of_the_angle_is_that_of_its_differences() {
    let lags = Lags { velocity: 0.5, ..lag(1.2) };
    for (kind, bits) in [(DefectKind::Healthy, 14), (DefectKind::Spall, 20)] {
        let motions = differenced(motions(&trace(kind, 31), bits));
        compare(&model_of_angle(lags, OPEN), &motions, "the angle's velocity");
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
    // About 12 at most; three times that of a healthy bearing.
    assert!(outer.score > 9.0, "the phase was lost at rest: {outer:?}");
}

/// The standard rig scores like white noise at this pole, within half a standard deviation: its own noise is filtered
/// by the current's low-pass, which the residual's filter of one pole does not undo.
#[test]
fn the_spall_stands_out_at_its_order_only_and_the_roughness_in_its_parameter() {
    let model = model(lag(0.7), true, OPEN);
    let of = |kind| run(&model, &motions(&trace(kind, 921), 14)).shaft().expect("watched").clone();
    let [healthy, spall, rough] = [DefectKind::Healthy, DefectKind::Spall, DefectKind::Roughness].map(of);
    let score = |estimate: &ShaftEstimate<RunTime>, k: usize| estimate.orders()[k].score;
    println!("scores: spall {}, healthy {}, rough {}", score(&spall, 0), score(&healthy, 0), score(&rough, 0));
    // A score is at most 1/√b: the noise of so few turns is known to a few per cent, and not all of the spall's power
    // is at its order.
    assert!(score(&spall, 0) > 9.0 && score(&healthy, 0) < 3.5 && score(&rough, 0) < 3.5);
    // Blocks of one turn pass 5 % of the power of a line 1.6 orders away.
    assert!(spall.orders()[1].prominence < 0.4 * spall.orders()[0].prominence, "{:?}", spall.orders());
    assert!(score(&spall, 2) < 3.5 && spall.orders()[0].slip.abs() < 3.0 * spall.orders()[0].slip_deviation);
    // ΔB/Kt = 0.04 A s/rad.
    let [of_healthy, of_rough] = [&healthy, &rough].map(|estimate| estimate.friction.viscous.value);
    assert!((of_rough - of_healthy - 0.04).abs() < 3e-3, "{of_rough} {of_healthy}");
    let close = |found: Option<f32>, truth: f32| found.is_some_and(|found| (found / truth - 1.0).abs() < 0.1);
    let friction = rough.friction;
    assert!(close(friction.torque_constant_nm_a().map(|(kt, _)| kt), 0.05) && close(friction.inertia_kg_m2(), 2.5e-4));
    assert!(close(friction.viscous_nm_s_rad(), 2.1e-3), "{friction:?}");
    assert!(friction.coulomb_nm().is_some_and(|torque| torque.abs() < 3e-3), "{friction:?}");
}

#[test]
fn healthy_traces_score_like_noise() {
    let model = model(lag(0.7), true, OPEN);
    let mut scores: Vec<f64> = vec![];
    for seed in 0..40 {
        let report = run(&model, &motions(&trace(DefectKind::Healthy, 1000 + seed), 14));
        let orders = report.shaft().expect("watched").orders();
        scores.extend(orders[..2].iter().map(|order| f64::from(order.score)));
    }
    let n = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / n;
    let deviation = (scores.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let most = scores.iter().copied().fold(f64::MIN, f64::max);
    println!("healthy scores {mean} ± {deviation}, most {most}");
    // Standard errors of 80 scores are 0.11 and 0.08; the noise is not quite white.
    assert!(mean.abs() < 0.8 && (0.5..1.3).contains(&deviation) && most < 3.5, "{mean} ± {deviation}, most {most}");
}

/// A trace whose current contains pulses of a defect at the outer or inner ring, which slips with the cage.
fn slipping(order: f64, slip: f64, ratio: f64, seed: u64) -> Vec<Motion> {
    let mut motions = motions(&trace(DefectKind::Healthy, seed), 32);
    let mut turns = 0.0;
    let mut last = motions[0].angle;
    for motion in &mut motions {
        turns += f64::from(motion.angle.since(last)) / 4_294_967_296.0;
        last = motion.angle;
        let phase = std::f64::consts::TAU * order * (1.0 + ratio * slip) * turns;
        motion.current_a += (0.2 * f64::from(motion.velocity_rad_s.signum()) * phase.cos()) as f32;
    }
    motions
}

#[test]
fn slip_is_found_with_both_signs_and_at_both_rings() {
    let model = model(Lags::default(), true, OPEN);
    let orders = BearingGeometry::THESIS.orders();
    let inner = -orders.outer / orders.inner;
    for (line, order, ratio) in [(0, orders.outer, 1.0), (1, orders.inner, inner)] {
        for slip in [-0.015, -0.006, 0.0, 0.006, 0.015] {
            let report = run(&model, &slipping(order, slip, ratio, 971));
            let found = report.shaft().expect("watched").orders()[line];
            let error = f64::from(found.slip) - slip;
            // The sixth of the slip that reversals may cost, and three deviations.
            assert!(error.abs() < 0.17 * slip.abs() + 3.0 * f64::from(found.slip_deviation), "{slip}: {found:?}");
            assert!(found.score > 8.0 && found.slip_deviation < 0.003, "{slip}: {found:?}");
            assert!((found.amplitude / 0.2 - 1.0).abs() < 0.25, "{slip}: {found:?}");
        }
    }
    // Without a search the phases of a turn's block and of the sixth after it differ by a third of a turn.
    let mut constants = model.constants().clone();
    constants.shaft[0].tracking.blocks.slip = 0.0;
    let blind = Model::new(model.plan(), constants).expect("good");
    let motions = slipping(orders.outer, 0.015, 1.0, 971);
    let [blind, seeing] =
        [&blind, &model].map(|model| run(model, &motions).shaft().expect("watched").orders()[0].prominence);
    assert!(blind < 0.9 * seeing, "{blind} {seeing}");
}

#[test]
fn the_slip_of_the_field_rig_is_found() {
    let model = model(lag(0.7), true, OPEN);
    let mut signs = [0; 2];
    for seed in 981..993 {
        let slip = Slip { slip: [0.008, 0.018], jitter: 0.0, width: [0.15; 2], ..Slip::FIELD };
        let field = Field { slip: Some(slip), ..Field::NONE };
        let scenario = Scenario { field, ..Scenario::STANDARD }.with_defect(Defect::full(DefectKind::Spall));
        let truth = FieldValues::draw(&scenario, seed).slip.expect("drawn").slip;
        signs[usize::from(truth > 0.0)] += 1;
        let report = run(&model, &motions(&simulate(&scenario, seed).expect("simulates"), 14));
        let found = report.shaft().expect("watched").orders()[0];
        let error = f64::from(found.slip) - truth;
        assert!(found.score > 10.0, "{truth}: {found:?}");
        assert!(error.abs() < 0.17 * truth.abs() + 3.0 * f64::from(found.slip_deviation), "{truth}: {found:?}");
    }
    assert!(signs.iter().all(|many| *many > 1), "{signs:?}");
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
