use super::*;
use crate::BearingGeometry;
use crate::ema::{EmaDefect, EmaPlant, EmaState};

const SETTINGS: DriveSettings = DriveSettings::MAXFORCE;

/// No friction of shaft and screw.
const SMOOTH: Actuator = Actuator { viscous_nm_s_per_rad: 0.0, coulomb_nm: 0.0, efficiency: 1.0, ..Actuator::MAXFORCE };

fn plant(actuator: &Actuator) -> EmaPlant {
    EmaPlant::new(actuator, &EmaDefect::HEALTHY, &BearingGeometry::THESIS, 0.0, 1.0 / 24_000.0).expect("valid")
}

/// Exact feedback.
fn feedback(state: &EmaState) -> Feedback {
    Feedback {
        position_m: state.position_m,
        velocity_rad_s: state.velocity_rad_s,
        direct_a: state.direct_a,
        quadrature_a: state.quadrature_a,
    }
}

fn advance(plant: &mut EmaPlant, voltage: DqVoltage, load_n: f64) {
    (0..2).for_each(|_| plant.step(voltage, [load_n; 2]));
}

#[test]
fn a_step_of_the_current_has_the_time_constant_of_the_bandwidth() {
    // A huge inertia keeps the shaft at its speed.
    let locked = Actuator { rotor_kg_m2: 1e9, ..SMOOTH };
    for (velocity_rad_s, tolerance_a) in [(0.0, 1e-6), (200.0, 0.1)] {
        let mut motor = plant(&locked);
        motor.set_state(EmaState { velocity_rad_s, ..EmaState::default() });
        let mut control = Controller::new(&SETTINGS, &locked);
        for k in 0..120_i32 {
            let expected = 5.0 * (1.0 - (-2000.0 / 12_000.0 * f64::from(k)).exp());
            let now = motor.state();
            // At standstill (3) is exact but for the integration, (h R/L)⁵/5!. At 200 rad/s, the coupling changes
            // within an interval, by pωT = 0.1 of a change of the current of at most 0.8 A an interval.
            assert!((now.quadrature_a - expected).abs() < tolerance_a, "{k} {now:?}");
            assert!(now.direct_a.abs() < 2.0 * tolerance_a, "{k} {now:?}");
            let voltage = control.current_loop(5.0, &feedback(&now));
            advance(&mut motor, voltage, 0.0);
        }
    }
}

#[test]
fn a_direct_current_decays_without_moving_the_quadrature_current() {
    let locked = Actuator { rotor_kg_m2: 1e9, ..SMOOTH };
    let mut motor = plant(&locked);
    motor.set_state(EmaState { velocity_rad_s: 200.0, direct_a: 4.0, ..EmaState::default() });
    let mut control = Controller::new(&SETTINGS, &locked);
    for k in 0..60_i32 {
        let now = motor.state();
        let expected = 4.0 * (-2000.0 / 12_000.0 * f64::from(k)).exp();
        // An integrator that starts at zero leaves a tail at the pole a, of (1 − a)/(a − exp(−wT)) = 12 % of the
        // current. The coupling changes within an interval, by pωT = 0.1 of a change of at most 0.7 A. Decoupling of
        // the wrong sign would leave 2 pω i_d, more than 1 A, in the q axis.
        assert!((now.direct_a - expected).abs() < 0.4 && now.quadrature_a.abs() < 0.2, "{k} {now:?}");
        let voltage = control.current_loop(0.0, &feedback(&now));
        advance(&mut motor, voltage, 0.0);
    }
}

/// Velocity after a step of the command of a linear model, at the control instants: continuous PI, a current loop of
/// first order, an inertia; explicit Euler with a fine step.
fn linear_step(step_rad_s: f64, samples: usize) -> Vec<f64> {
    let (kt, n) = (1.5 * 6.0 * 0.0559, 3.81e-3 / core::f64::consts::TAU);
    let j = 1.5e-3 + 40.0 * n * n;
    let h = 1.0 / 12_000.0 / 200.0;
    let [mut integral, mut current, mut omega] = [0.0; 3];
    let mut at_samples = Vec::new();
    for k in 0..samples * 200 {
        if k.is_multiple_of(200) {
            at_samples.push(omega);
        }
        let error = step_rad_s - omega;
        integral += h * 9.0 * error;
        current += h * 2000.0 * (0.45 * error + integral - current);
        omega += h * kt * current / j;
    }
    at_samples
}

#[test]
fn a_step_of_the_velocity_follows_the_linear_model() {
    let mut motor = plant(&SMOOTH);
    let mut control = Controller::new(&SETTINGS, &SMOOTH);
    let step = 20.0;
    let linear = linear_step(step, 1200);
    let mut peak: f64 = 0.0;
    for (k, expected) in linear.iter().enumerate() {
        let now = motor.state();
        // An interval of delay, 1/12 000 s, of a rise of at most Kp Kt/J = 149 1/s: 1.3 % of the step.
        assert!((now.velocity_rad_s - expected).abs() < 0.013 * step, "{k}: {} {expected}", now.velocity_rad_s);
        peak = peak.max(now.velocity_rad_s);
        let current_ref = control.velocity_loop(step, now.velocity_rad_s);
        let voltage = control.current_loop(current_ref, &feedback(&now));
        advance(&mut motor, voltage, 0.0);
    }
    // The PI makes an overshoot; a loop without integrator would have none.
    assert!(peak > 1.05 * step, "{peak}");
}

#[test]
fn a_step_beyond_all_limits_stays_within_them_and_settles() {
    let mut motor = plant(&Actuator::MAXFORCE);
    let mut control = Controller::new(&SETTINGS, &Actuator::MAXFORCE);
    let [mut largest_v, mut largest_a, mut overshoot_m]: [f64; 3] = [0.0; 3];
    for _ in 0..24_000 {
        let now = motor.state();
        let commands = control.update(0.1, &feedback(&now));
        largest_v = largest_v.max(commands.voltage.d_v.hypot(commands.voltage.q_v));
        largest_a = largest_a.max(commands.current_ref_a.abs());
        overshoot_m = overshoot_m.max(now.position_m - 0.1);
        assert!(commands.velocity_ref_rad_s.abs() <= SETTINGS.velocity_limit_rad_s);
        advance(&mut motor, commands.voltage, 8e3);
    }
    // Rounding of the scale.
    assert!((largest_v / (311.0 / 3.0_f64.sqrt()) - 1.0).abs() < 1e-12, "{largest_v}");
    assert_eq!(largest_a, 40.0);
    // At 4572 rpm, 8 kN need more voltage than there is: the motor is slower, and arrives nevertheless.
    assert!((motor.state().position_m - 0.1).abs() < 1e-4, "{:?}", motor.state());
    assert!(overshoot_m < 1e-3, "{overshoot_m}");
}

#[test]
fn a_saturated_velocity_loop_does_not_wind_up() {
    let mut control = Controller::new(&SETTINGS, &Actuator::MAXFORCE);
    for _ in 0..12_000 {
        assert_eq!(control.velocity_loop(400.0, 0.0), 40.0);
    }
    // Once the error is negative the command leaves its limit in a few integral time constants, 1/20 s, at most.
    let command = control.velocity_loop(400.0, 410.0);
    assert!(command < 40.0, "{command}");
}

#[test]
fn a_held_current_needs_no_step() {
    let mut control = Controller::new(&SETTINGS, &Actuator::MAXFORCE);
    control.hold(12.0, 0.84);
    let rest = Feedback { position_m: 0.01, velocity_rad_s: 0.0, direct_a: 0.0, quadrature_a: 12.0 };
    for _ in 0..100 {
        let commands = control.update(0.01, &rest);
        assert_eq!(commands.current_ref_a, 12.0);
        // Rounding only.
        assert!((commands.voltage.q_v - 0.84 * 12.0).abs() < 1e-12 && commands.voltage.d_v == 0.0);
    }
}
