//! The axis on the actuator against closed forms.

use core::f64::consts::{PI, TAU};

use super::*;
use crate::axis::parts::AxisOptions;
use crate::axis::{AxisPart, Gravity};
use crate::ema::{EmaLoad, EmaScenario, SensorErrors, simulate};
use crate::field::Mechanics;
use crate::{Stream, Waveform};

const STEP_S: f64 = 1.0 / 24_000.0;

/// An actuator without friction, with a magnet so weak that the currents have no effect.
const FREE: Actuator =
    Actuator { viscous_nm_s_per_rad: 0.0, coulomb_nm: 0.0, flux_wb: 1e-12, efficiency: 1.0, ..Actuator::MAXFORCE };

/// No friction, exact sensors, no load.
const QUIET: EmaScenario = EmaScenario {
    actuator: Actuator { viscous_nm_s_per_rad: 0.0, coulomb_nm: 0.0, efficiency: 1.0, ..Actuator::MAXFORCE },
    sensors: SensorErrors { resolver_bits: 30, ..SensorErrors::QUIET },
    load: EmaLoad::Constant { force_n: 0.0 },
    load_fluctuation_n: 0.0,
    rows: 2400,
    ..EmaScenario::STANDARD
};

fn source() -> NoiseSource {
    NoiseSource::new(1, Stream::Gear)
}

fn free() -> EmaPlant {
    EmaPlant::new(&FREE, &EmaDefect::HEALTHY, &BearingGeometry::THESIS, 0.0, STEP_S).expect("valid")
}

fn slide(payload: f64) -> Axis {
    Axis { gravity: Some(Gravity { payload, inertia_swing: 0.3, ..Gravity::LINEAR }), ..Axis::LEVEL }
}

#[test]
fn the_current_holds_and_moves_the_weight_of_the_stroke() {
    let kt = QUIET.actuator.kt_nm_per_a();
    let axis = Some(Axis { gravity: Some(Gravity { payload: 0.0, ..Gravity::LINEAR }), ..Axis::LEVEL });
    let still = EmaScenario { amplitude_m: 0.0, offset_m: 0.02, axis, ..QUIET };
    // A triangle of 13 rad/s: after its first tenth of a second its acceleration is over.
    let moved =
        EmaScenario { command: Waveform::Triangle, amplitude_m: 0.02, frequency_hz: 0.1, offset_m: 0.0, ..still };
    for (scenario, from) in [(still, 0), (moved, 600)] {
        let trace = simulate(&scenario, 3).expect("valid");
        for k in from..2400 {
            let weight = 2.0 * (1.0 - 0.3 * (1.0 + 0.2 * trace.position_m[k] / STROKE_M));
            // The record starts held, and the triangle has settled: e⁻¹² of the position loop after 0.5 s, of 1 N·m,
            // and the loops follow a weight that changes by 0.14 N·m in the whole stroke.
            assert!((kt * trace.current_a[k] - weight).abs() < 1e-3, "{k} {} {weight}", kt * trace.current_a[k]);
            assert!((trace.axis.weight_nm[k] - weight).abs() < 1e-9);
        }
        assert!(trace.recorded().iter().all(|(name, _)| !name.starts_with("load_") && *name != "axis_rad"));
    }
}

#[test]
fn two_inertias_swing_at_the_resonance_of_the_belt() {
    let belt = Mechanics { resonance_hz: [50.0; 2], damping_ratio: 0.0, ..Mechanics::GEAR };
    let mut plant = free();
    plant.hold(0.0, 0.0, 0.0);
    plant.drive_axis(&Axis::LEVEL, Some(&belt.draw(source(), source())), 1.0, source());
    plant.set_state(EmaState { velocity_rad_s: 1.0, ..plant.state() });
    for k in 1..=24_000 {
        plant.step(DqVoltage::default(), [0.0; 2]);
        let state = plant.state();
        let closed = (TAU * 50.0 * STEP_S * f64::from(k)).cos();
        // The phase error of a step is (2πfh)⁵/120 = 3e-12; rounding of 2e4 steps.
        assert!((state.velocity_rad_s - state.load_rad_s - closed).abs() < 1e-6, "{k}");
        assert!((0.6 * state.velocity_rad_s + 0.4 * state.load_rad_s - 0.6).abs() < 1e-9);
    }
    assert!((plant.state().position_m - plant.state().load_rad * 3.81e-3 / TAU).abs() < 1e-15);
}

#[test]
fn a_falling_slide_gains_what_its_weight_gives() {
    let axis = slide(0.3);
    let mut plant = free();
    plant.hold(2.0, 0.05, 0.0);
    plant.drive_axis(&axis, None, 1.3, source());
    // Let go.
    plant.set_state(EmaState { quadrature_a: 0.0, ..plant.state() });
    let gravity = axis.gravity.expect("on");
    let r = STROKE_M / (PI * FREE.metres_per_rad());
    let energy = |state: &EmaState| {
        let phi = PI * state.position_m / STROKE_M;
        let travel = Travel::linear(FREE.metres_per_rad(), STROKE_M);
        let inertia = FREE.inertia_kg_m2() * (1.0 + gravity.inertia(&travel, phi, 1.3)[0]);
        let height = 2.0 * ((1.3 - 0.3) * phi - 0.3 * 0.2 * phi * phi / (2.0 * PI)) * r;
        0.5 * inertia * state.velocity_rad_s.powi(2) + height
    };
    let start = energy(&plant.state());
    while plant.state().position_m > -0.05 {
        plant.step(DqVoltage::default(), [0.0; 2]);
        // 330 J at most are exchanged; a step of the fourth order errs by less than rounding, 1e-13 of it.
        assert!((energy(&plant.state()) - start).abs() < 1e-8, "{}", energy(&plant.state()) - start);
    }
    assert!(plant.state().velocity_rad_s < -400.0);
}

#[test]
fn every_part_and_any_of_them_together_can_be_simulated() {
    let all = AxisPart::ALL;
    for parts in all.iter().map(core::slice::from_ref).chain([&all[..6], &all[1..3], &all[..4]]) {
        for base in
            [EmaScenario { rows: 6000, ..EmaScenario::STANDARD }, EmaScenario { rows: 30_000, ..EmaScenario::RIT }]
        {
            let scenario = base.mixed(4).on_axis(parts, AxisOptions { ratio: Some(5.0), weight_nm: None });
            let trace = simulate(&scenario, 4).expect("valid");
            assert!(trace.recorded().iter().all(|(_, column)| column.iter().all(|x| x.is_finite())), "{parts:?}");
            let error = |k: usize| (trace.position_ref_m[k] - trace.position_m[k]).powi(2);
            let rms = ((0..trace.len()).map(error).sum::<f64>() / trace.len() as f64).sqrt();
            // The position loop lags by 1/25 s, 4 mm at 0.1 m/s.
            assert!(rms < 6e-3, "{parts:?} {rms}");
            let brake = trace.axis.brake_closed.iter().filter(|closed| **closed == 1.0).count();
            assert_eq!(brake > 0, parts.contains(&AxisPart::Brake), "{parts:?}");
        }
    }
}
