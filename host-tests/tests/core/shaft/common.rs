//! The standard rig's shaft: constants, traces, a run of a whole segment.

use bearing_watch::estimate::{Balance, StateVariable, TrackedOrder, Tracking, Watch};
use bearing_watch::{Angle, Guard, Motion, Shaft, ShaftEstimate, ShaftModel};
use workbench::rig::{BearingGeometry, Defect, DefectKind, RigTrace, Scenario, simulate};

/// Healthy standard rig: J/Kt, B/Kt, Tc/Kt, 1/Kt, offset.
pub const NOMINAL: [f32; 5] = [5e-3, 2e-3, 0.0, 20.0, 0.0];

/// Three orders: outer and inner ring with three harmonics, and the shaft's own.
pub fn model(current_delay: f32) -> ShaftModel<3> {
    let orders = BearingGeometry::THESIS.orders();
    let order = |order: f64, weights| TrackedOrder::new(order as f32, weights);
    ShaftModel {
        guard: Guard::within([100.0, 400.0, 5.0]),
        current_delay,
        balance: Balance {
            interval_s: 0.002,
            filter: StateVariable::new((std::f64::consts::PI * 8.0 * 0.002).tan() as f32, 0.002),
            row_interval: 8,
            settle: 100,
            sign_velocity_rad_s: 2.0,
            usual_velocity_rad_s: 28.0,
            load: true,
            scale: [0.015_625, 0.031_25, 8.0, 0.25],
            nominal: NOMINAL,
        },
        tracking: Tracking {
            orders: [
                order(orders.outer, [1.0, 0.4, 0.2]),
                order(orders.inner, [1.0, 0.4, 0.2]),
                order(1.0, [1.0, 0.0, 0.0]),
            ],
            count: 3,
            harmonics: 3,
            // 2 rad/s.
            still: 2_734_261,
            block_samples: 100,
        },
    }
}

/// The standard rig with a defect of full size.
pub fn trace(kind: DefectKind, seed: u64) -> RigTrace {
    simulate(&Scenario::STANDARD.with_defect(Defect::full(kind)), seed).expect("simulates")
}

/// The trace as a drive has it, its angle to so many bits.
pub fn motions(trace: &RigTrace, bits: u32) -> Vec<Motion> {
    let turn = f64::from(bits).exp2();
    let angle = |rad: f64| Angle::from_counts((rad / std::f64::consts::TAU * turn).floor() as i64 as u32, bits);
    (0..trace.t_s.len())
        .map(|k| Motion {
            current_a: trace.current_a[k] as f32,
            velocity_rad_s: trace.velocity_rad_s[k] as f32,
            reference_rad_s: trace.velocity_ref_rad_s[k] as f32,
            load_nm: trace.load_torque_nm[k] as f32,
            angle: angle(trace.angle_rad[k]),
        })
        .collect()
}

/// What a whole segment says.
pub fn run<const K: usize>(model: &ShaftModel<K>, motions: &[Motion]) -> ShaftEstimate<K> {
    let mut shaft = Shaft::new(Some(model));
    motions.iter().for_each(|motion| shaft.step(Some(model), motion));
    model.conclude(&shaft.sums().expect("watching"))
}
