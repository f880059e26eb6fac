use core::f64::consts::TAU;

use super::*;
use crate::DefectKind;
use crate::ema::Race;

const STEP_S: f64 = 1.0 / 24_000.0;
const SMOOTH: Actuator = Actuator { viscous_nm_s_per_rad: 0.0, coulomb_nm: 0.0, ..Actuator::MAXFORCE };

fn plant(actuator: &Actuator, springs_n_per_m: f64) -> EmaPlant {
    let bearing = BearingGeometry::THESIS;
    EmaPlant::new(actuator, &EmaDefect::HEALTHY, &bearing, springs_n_per_m, STEP_S).expect("valid")
}

/// The plant in this state with the mass at its place.
fn set(plant: &mut EmaPlant, velocity_rad_s: f64, quadrature_a: f64) {
    plant.set_state(EmaState { velocity_rad_s, quadrature_a, ..plant.state() });
}

#[test]
fn without_current_the_voltage_is_flux_times_electrical_speed() {
    let mut free = plant(&SMOOTH, 0.0);
    set(&mut free, 300.0, 0.0);
    for _ in 0..24_000 {
        // 0.0559 Wb, 6 pole pairs, 300 rad/s.
        free.step(DqVoltage { d_v: 0.0, q_v: 0.0559 * 6.0 * 300.0 }, [0.0; 2]);
    }
    let end = free.state();
    // An equilibrium: rounding only.
    assert!(end.quadrature_a.abs() < 1e-9 && end.direct_a.abs() < 1e-9 && (end.velocity_rad_s - 300.0).abs() < 1e-9);
    assert!((end.angle_rad - 300.0).abs() < 1e-8 && (end.position_m - 300.0 * 3.81e-3 / TAU).abs() < 1e-10);
}

#[test]
fn a_short_circuited_spinning_motor_has_the_currents_of_the_phasor_diagram() {
    // A huge inertia keeps the speed; then v = 0 gives (R + jX)(i_d + j i_q) = −j p ω λ, X = pωL.
    let mut shorted = plant(&Actuator { rotor_kg_m2: 1e9, ..SMOOTH }, 0.0);
    set(&mut shorted, 120.0, 0.0);
    for _ in 0..4800 {
        shorted.step(DqVoltage::default(), [0.0; 2]);
    }
    let (r, x, emf) = (0.6, 720.0 * 3e-3, 720.0 * 0.0559);
    let magnitude = r * r + x * x;
    let end = shorted.state();
    // 40 electrical time constants: exp(−40) of the transient.
    assert!((end.direct_a + emf * x / magnitude).abs() < 1e-9, "{end:?}");
    assert!((end.quadrature_a + emf * r / magnitude).abs() < 1e-9, "{end:?}");
}

#[test]
fn efficiency_acts_in_the_direction_of_the_power() {
    let torque_nm = 1000.0 * 3.81e-3 / TAU;
    let kt = 1.5 * 6.0 * 0.0559;
    for (velocity, factor) in [(50.0, 1.0 / 0.9), (-50.0, 2.0 - 1.0 / 0.9), (0.0, 1.0)] {
        for force in [1000.0, -1000.0] {
            let mut screw = plant(&SMOOTH, 0.0);
            // With a negative force, the motor drives at negative speed.
            let current = factor * torque_nm / kt * force / 1000.0;
            set(&mut screw, velocity * force / 1000.0, current);
            let slope = screw.slope(&screw.state(), DqVoltage::default(), force);
            // tanh(50) = 1; rounding of terms of 0.67 N·m over an inertia of 1.5e-3 kg·m².
            assert!(slope.velocity_rad_s.abs() < 1e-11, "{velocity} {force} {}", slope.velocity_rad_s);
        }
    }
}

#[test]
fn held_actuators_stay_where_they_are() {
    for springs in [0.0, 2.4e5] {
        let mut held = plant(&Actuator::MAXFORCE, springs);
        held.hold(7.0, 0.02, 3e3);
        let start = held.state();
        let force = held.load_n(3e3);
        // 3 kN, and 20 mm of the springs.
        assert!((force - 3e3 - springs * 0.02).abs() <= springs * 1e-4 && start.angle_rad == 7.0);
        let voltage = DqVoltage { d_v: 0.0, q_v: 0.6 * start.quadrature_a };
        (0..2400).for_each(|_| held.step(voltage, [3e3; 2]));
        // Rounding only.
        assert!((held.state().position_m - start.position_m).abs() < 1e-12);
        assert!(held.state().velocity_rad_s.abs() < 1e-8);
    }
}

#[test]
fn springs_and_inertia_swing_at_their_frequency() {
    // ω² = k_e N²/J with J = 1.5e-3 + 40 N².
    let frictionless = Actuator { efficiency: 1.0, flux_wb: 1e-12, ..SMOOTH };
    let mut swing = plant(&frictionless, 2.4e5);
    swing.hold(0.0, 0.01, 0.0);
    set(&mut swing, 0.0, 0.0);
    let n = 3.81e-3 / TAU;
    let omega = (2.4e5_f64 * n * n / (1.5e-3 + 40.0 * n * n)).sqrt();
    for k in 1..=24_000_i32 {
        swing.step(DqVoltage::default(), [0.0; 2]);
        let expected = 0.01 * (omega * STEP_S * f64::from(k)).cos();
        // ωh = 3e-4: an error of (ωh)⁵/5! a step; rounding prevails.
        assert!((swing.state().position_m - expected).abs() < 1e-12, "{k}");
    }
}

#[test]
fn a_finer_step_hardly_changes_the_motion() {
    let defect = EmaDefect::of(DefectKind::SpallAndRoughness, 1.0, Race::Inner);
    let end = |steps: u32| {
        let step_s = 0.1 / f64::from(steps);
        let mut plant =
            EmaPlant::new(&Actuator::MAXFORCE, &defect, &BearingGeometry::THESIS, 2.4e5, step_s).expect("valid");
        plant.hold(1.0, -0.01, 0.0);
        (0..steps).for_each(|_| plant.step(DqVoltage { d_v: -10.0, q_v: 30.0 }, [0.0; 2]));
        plant.state()
    };
    let (coarse, fine) = (end(2400), end(76_800));
    let errors = [
        coarse.angle_rad - fine.angle_rad,
        coarse.velocity_rad_s - fine.velocity_rad_s,
        coarse.quadrature_a - fine.quadrature_a,
    ];
    println!("errors of 0.1 s at 1/24 000 s: {errors:?} rad, rad/s, A");
    // The curvature of the pulses jumps at their ends: about h³ · 0.12 N·m/J of the velocity an end. Far below all
    // noise.
    assert!(errors.iter().all(|error| error.abs() < 1e-5), "{errors:?}");
}

#[test]
fn refuses_impossible_plants_by_name() {
    let bearing = BearingGeometry::THESIS;
    let none = EmaDefect::HEALTHY;
    let error = EmaPlant::new(&Actuator { r_ohm: 0.0, ..SMOOTH }, &none, &bearing, 0.0, STEP_S).expect_err("invalid");
    assert_eq!(error.to_string(), "actuator.r_ohm must be positive, got 0");
    assert!(EmaPlant::new(&SMOOTH, &none, &bearing, 0.0, 0.0).is_err());
}
