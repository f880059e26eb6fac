//! The axis on the DC-motor rig against closed forms.

use core::f64::consts::TAU;

use super::*;
use crate::field::{LoadFriction, MechanicsValues};
use crate::{Condition, Defect, DefectKind, Duty, Field, FieldValues, MotorParameters, RigTrace, Scenario, simulate};

/// A motor without friction, load and noise.
const QUIET: Scenario = Scenario {
    load_amplitude_nm: 0.0,
    load_fluctuation_nm: 0.0,
    current_noise_a: 0.0,
    velocity_noise_rad_s: 0.0,
    motor: MotorParameters { b_nm_s_per_rad: 0.0, ..Scenario::STANDARD.motor },
    ..Scenario::STANDARD
};

fn run(scenario: &Scenario, seed: u64) -> RigTrace {
    simulate(scenario, seed).expect("valid")
}

fn of_axis(axis: Axis) -> Scenario {
    QUIET.with_axis(axis)
}

#[test]
fn at_rest_the_current_holds_the_weight_of_the_angle() {
    let scenario = Scenario { reference_amplitude_rad_s: 0.0, samples: 200, ..of_axis(Axis::with_weight(0.4)) };
    for seed in 0..5 {
        let trace = run(&scenario, seed);
        let [phi, payload] = [trace.angle_rad[0] / 50.0, trace.axis.payload[0]];
        let weight = 0.4 * payload * phi.sin();
        // A record starts held: only rounding moves it.
        assert!((0.05 * trace.current_a[199] - weight).abs() < 1e-9, "{seed}");
        // Rounding of up to 1000 turns that the motor has made before.
        assert!((trace.axis.weight_nm[199] - weight).abs() < 1e-9 && (trace.axis.axis_rad[199] - phi).abs() < 1e-9);
        assert!(trace.no_load_sensor && (0.7..1.3).contains(&payload));
    }
}

#[test]
fn at_steady_speed_the_current_follows_the_weight() {
    let scenario = Scenario { duty: Duty::ConstantSpeed, ..of_axis(Axis::with_weight(0.15)) };
    let trace = run(&scenario, 3);
    let payload = trace.axis.payload[0];
    // The voltage R W/Kt = 1.5 V p swings at 0.8 rad/s, and the integrator follows with an error of its slope over Ki.
    let lag = 1.5 * payload * (40.0 / 50.0) / 0.5;
    // What is left of the balance Kt i = W sin φ + J ω̇ is the 1.6 ms of the filter, 1.6e-3 · 0.8 of the weight.
    for k in (1000..4990).step_by(97) {
        let weight = 0.15 * payload * (trace.angle_rad[k] / 50.0).sin();
        let slope = (trace.velocity_rad_s[k + 1] - trace.velocity_rad_s[k - 1]) / 0.004;
        let error = 0.05 * trace.current_a[k] - 2.5e-4 * slope - weight;
        assert!(error.abs() < 4e-4 && (trace.velocity_rad_s[k] - 40.0).abs() < 1.1 * lag, "{k} {error}");
    }
    let widest = (1000..4990).map(|k| (trace.velocity_rad_s[k] - 40.0).abs()).fold(0.0, f64::max);
    // 6.4 rad of the axis contain a turn, so that the steepest weight is among the samples.
    assert!(widest > 0.9 * lag, "{widest} {lag}");
}

#[test]
fn friction_in_proportion_to_the_load_includes_the_weight() {
    let field = Field { load_friction: Some(LoadFriction::FIELD), ..Field::NONE };
    let axis = Axis::with_weight(0.4);
    let scenario = Scenario { duty: Duty::ConstantSpeed, ..Scenario { field, ..QUIET }.with_axis(axis) };
    let mu = FieldValues::draw(&scenario, 4).load_friction.expect("on").coefficient;
    let trace = run(&scenario, 4);
    for k in (1000..4990).step_by(97) {
        let slope = (trace.velocity_rad_s[k + 1] - trace.velocity_rad_s[k - 1]) / 0.004;
        let friction = 0.05 * trace.current_a[k] - 2.5e-4 * slope - trace.axis.weight_nm[k];
        // The filter lags by 1.6e-3 · 0.8 of the weight and of its friction.
        assert!((friction - mu * trace.axis.weight_nm[k].abs()).abs() < 1e-3, "{k} {friction}");
    }
}

#[test]
fn without_friction_energy_goes_into_motion_height_and_nothing_else() {
    let gravity = Gravity { inertia_swing: 0.3, payload_inertia: 0.2, ..Gravity::ROTARY };
    let scenario = Scenario {
        duty: Duty::Cycle(Motion::Any),
        ..of_axis(Axis { gravity: Some(gravity), ratio: 5.0, ..Axis::LEVEL })
    };
    for seed in 0..3 {
        let trace = run(&scenario, seed);
        let (payload, travel) = (trace.axis.payload[0], Travel::rotary(5.0));
        let energy = |k: usize| {
            let [phi, omega] = [trace.axis.axis_rad[k], trace.velocity_rad_s[k]];
            let inertia = 2.5e-4 * (1.0 + gravity.inertia(&travel, phi, payload)[0]);
            // Potential energy of W (p − c) sin φ over θ = r φ.
            0.5 * inertia * omega * omega - 5.0 * 0.15 * (payload - 0.3) * phi.cos()
        };
        // Between samples the voltage is constant, i = (v − Ke ω)/R, and Kt = Ke: the work of the motor is that of
        // Kt i over the angle, ∫ ω dt by the angle itself and ∫ ω² dt by Simpson's rule with the middle from both ends.
        let (mut work, mut swing) = (0.0, 0.0_f64);
        for k in 0..4999 {
            let [a, b] = [trace.velocity_rad_s[k], trace.velocity_rad_s[k + 1]];
            let turned = trace.angle_rad[k + 1] - trace.angle_rad[k];
            let middle = 1.5 * turned / 0.002 - 0.25 * (a + b);
            let squares = 0.002 / 6.0 * (a * a + 4.0 * middle * middle + b * b);
            work += 0.05 * (trace.voltage_v[k] * turned - 0.05 * squares) / 0.5;
            swing = swing.max((energy(k + 1) - energy(0)).abs());
            // The midpoint rule errs by (h·100 1/s)² of what is exchanged, 1e-4, a few times over the record.
            assert!((energy(k + 1) - energy(0) - work).abs() < 2e-3, "{seed} {k} {}", energy(k + 1) - energy(0) - work);
        }
        assert!(swing > 0.2, "there is something to exchange: {swing}");
    }
}

#[test]
fn in_a_reversal_the_backlash_is_crossed_without_torque() {
    let gap = 1.0_f64.to_radians();
    let values =
        MechanicsValues { payload: 1.0, load_share: 0.4, resonance_hz: 60.0, damping_ratio: 0.05, backlash_rad: gap };
    let mechanics = Mechanics { payload: 0.0, resonance_hz: [60.0; 2], backlash_deg: [1.0; 2], ..Mechanics::GEAR };
    let scenario =
        Scenario { reference_frequency_hz: 0.5, ..of_axis(Axis { transmission: Some(mechanics), ..Axis::LEVEL }) };
    let trace = run(&scenario, 1);
    let load_rad = |k: usize| 50.0 * trace.axis.axis_rad[k];
    let play: Vec<f64> = (500..5000).map(|k| trace.angle_rad[k] - load_rad(k)).collect();
    let (low, high) = play.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
    // Beyond the gap the spring twists by J₂ ω̇/k = ω̇/((2πf)² 0.6) = 1.5e-3 rad for 126 rad/s² on each side, and by up
    // to three times as much in an impact.
    let twist = 40.0 * TAU * 0.5 / ((TAU * values.resonance_hz).powi(2) * (1.0 - values.load_share));
    assert!((gap..gap + 6.0 * twist).contains(&(high - low)), "{low} {high} {twist}");
    // The load leaves one side at the peak of the velocity and coasts; the motor crosses the gap in free motion.
    let inside = play.iter().filter(|x| x.abs() < 0.45 * gap).count();
    assert!(inside > 20 && inside < 2000, "{inside}");
}

#[test]
fn mesh_orders_of_a_gear_are_in_the_current() {
    let axis = |gear| Axis { ratio: 5.0, gear: Some(gear), ..Axis::LEVEL };
    let gear = Gear { friction_nm: 0.0, load_friction: 0.0, spread: 0.0, ..Gear::ROTARY };
    let scenario = Scenario { duty: Duty::ConstantSpeed, reference_amplitude_rad_s: 6.0, ..of_axis(axis(gear)) };
    let trace = run(&scenario, 2);
    // The torque Kt i − J ω̇ at an order; 17 at 6 rad/s are 16 Hz.
    let amplitude = |order: f64| {
        let (mut x, mut y, mut n) = (0.0, 0.0, 0.0);
        for k in 1000..4999 {
            let slope = (trace.velocity_rad_s[k + 1] - trace.velocity_rad_s[k - 1]) / 0.004;
            let torque = 0.05 * trace.current_a[k] - 2.5e-4 * slope;
            let (sin, cos) = (order * trace.angle_rad[k]).sin_cos();
            (x, y, n) = (x + torque * cos, y + torque * sin, n + 1.0);
        }
        2.0 * f64::hypot(x, y) / n
    };
    for order in [17.0, 83.0 / 5.0] {
        // The filter of the current and the difference of the velocity take a few percent at 16 Hz; the two orders and
        // the ends of the record leak by 1/(2π · 0.4 · 9 turns).
        assert!((amplitude(order) / 0.003 - 1.0).abs() < 0.12, "{order} {}", amplitude(order));
    }
    assert!(amplitude(14.3) < 4e-4 && amplitude(20.3) < 4e-4, "{} {}", amplitude(14.3), amplitude(20.3));
}

#[test]
fn a_closed_brake_holds_what_the_motor_lets_go() {
    let parts = [AxisPart::Gravity, AxisPart::Brake, AxisPart::Cycle, AxisPart::PayloadSteps];
    let scenario = QUIET.on_axis(&parts, parts::AxisOptions { weight_nm: Some(0.4), ratio: None });
    let trace = run(&scenario, 5);
    let closed: Vec<usize> = (0..5000).filter(|k| trace.axis.brake_closed[*k] == 1.0).collect();
    assert!((500..3500).contains(&closed.len()), "{}", closed.len());
    for &k in &closed {
        assert_eq!((trace.voltage_v[k], trace.velocity_ref_rad_s[k]), (0.0, 0.0));
    }
    // 0.15 s after it has closed, the motor has no current and the axis hangs in the lining: W/k = 0.4/35.5 rad.
    let settled = closed.iter().filter(|k| **k >= 75 && (0..75).all(|d| trace.axis.brake_closed[**k - d] == 1.0));
    let mut count = 0;
    for &k in settled {
        count += 1;
        assert!(trace.current_a[k].abs() < 0.05 && trace.velocity_rad_s[k].abs() < 0.5, "{k}");
    }
    assert!(count > 50, "{count}");
    let payloads: Vec<u64> = trace.axis.payload.iter().map(|p| p.to_bits()).collect();
    assert!(payloads.windows(2).filter(|pair| pair[0] != pair[1]).count() >= 2);
}

#[test]
fn every_part_and_any_of_them_together_can_be_simulated() {
    let all = AxisPart::ALL;
    let sets = all.iter().map(std::slice::from_ref).chain([&all[..6], &all[1..2], &all[..3]]);
    for parts in sets {
        for (field, ratio) in [(Field::NONE, 1.0), (Field::ALL, 160.0)] {
            let options = parts::AxisOptions { ratio: Some(ratio), weight_nm: None };
            let base = Scenario { field, ..Scenario::STANDARD }.mixed(3);
            let scenario = base.on_axis(parts, options).with_defect(Defect::full(DefectKind::Spall));
            let trace = run(&scenario, 3);
            assert!(trace.recorded().iter().all(|(_, column)| column.iter().all(|x| x.is_finite())), "{parts:?}");
            assert_eq!(trace.no_load_sensor, field == Field::NONE, "a sensor with errors stays");
            assert!(trace.axis.ratio.iter().all(|own| *own == ratio) && trace.axis.ratio.len() == 5000);
            // The loop follows: 0.25 V·s/rad against 0.4 N·m and less.
            let error = |k: usize| (trace.velocity_ref_rad_s[k] - trace.velocity_rad_s[k]).powi(2);
            let rms = ((0..5000).map(error).sum::<f64>() / 5000.0).sqrt();
            assert!(rms < 12.0, "{parts:?} {ratio} {rms}");
            assert_eq!(trace, run(&scenario, 3));
        }
    }
    let wild = Axis { ratio: 161.0, ..Axis::LEVEL };
    let message = of_axis(wild).validate().expect_err("too high").to_string();
    assert_eq!(message, "axis.ratio must lie between 1 and 160, got 161");
}

#[test]
fn the_conditions_of_axes_differ_by_axis_and_duty_only() {
    for (k, condition) in (0..).zip(Condition::AXES) {
        assert_eq!(condition.number, 44 + k);
        let scenario = condition.apply(Scenario::STANDARD, 7);
        let plain = Scenario::STANDARD.with_axis(Axis::LEVEL).mixed(7);
        let changed = Scenario { axis: plain.axis, duty: Duty::Waveform, ..scenario };
        assert_eq!(changed, plain, "{}", condition.name);
        // 0.15/30 N·m, times 0.6–1.4.
        assert!((0.003..0.007).contains(&scenario.load_amplitude_nm));
    }
}
