//! The axis of both rigs against an own integrator, written from the equations of a motor that moves an axis: classical
//! Runge–Kutta with a step of its own, driven by the recorded voltages.
//!
//! ```text
//! stiff   d/dt (½ J(φ) ω²)/ω = Kt i − B ω − T_brake − T_gear − W(φ),   φ = θ/r
//! belt    J₁ ω̇₁ = Kt i − B ω₁ − T_brake − T_k,   J₂(φ) ω̇₂ = T_k − ½ J₂′ ω₂² − T_gear − W(φ),   φ = θ₂/r
//! ```

use std::f64::consts::PI;

use rig::axis::cycle::Motion;
use rig::axis::gear::GearValues;
use rig::axis::parts::AxisOptions;
use rig::axis::{Axis, AxisPart, Gear, Gravity};
use rig::ema::{EmaLoad, EmaScenario, Logging, SensorErrors};
use rig::field::MechanicsValues;
use rig::{FieldValues, NoiseSource, Scenario, Stream};

/// Motor: velocity and angle; load side: velocity and angle; currents of the actuator.
type State = [f64; 6];

/// What the equations need; torques and inertia at the motor.
#[derive(Clone, Copy)]
struct Machine {
    axis: Axis,
    gear: Option<GearValues>,
    belt: Option<MechanicsValues>,
    /// Angle of the motor per angle of the axis.
    per_phi: f64,
    linear: bool,
    inertia: f64,
    viscous: f64,
    coulomb: f64,
    /// 1/η − 1 of the screw.
    screw: f64,
    payload: f64,
    /// Angle at which the brake has closed.
    brake: Option<f64>,
}

impl Machine {
    fn weight(&self, phi: f64) -> f64 {
        let Some(Gravity { weight_nm: w, counterbalance: c, .. }) = self.axis.gravity else { return 0.0 };
        if self.linear { w * (self.payload - c - 0.2 * c * phi / PI) } else { w * (self.payload - c) * phi.sin() }
    }

    /// Inertia of the load side that depends on the axis, and its derivative by the motor's angle.
    fn swing(&self, phi: f64) -> (f64, f64) {
        let Some(Gravity { payload_inertia: s, inertia_swing: v, .. }) = self.axis.gravity else { return (0.0, 0.0) };
        let share = s * (self.payload - 1.0) + v * phi.cos();
        (self.inertia * share, -self.inertia * v * phi.sin() / self.per_phi)
    }

    /// Weight, gear and screw against a velocity.
    fn against(&self, angle: f64, velocity: f64) -> f64 {
        let weight = self.weight(angle / self.per_phi);
        let sign = velocity.tanh();
        let mut torque = weight + sign * self.screw * weight.abs();
        if let Some(gear) = self.gear {
            let side = if velocity < 0.0 { 1 } else { 0 };
            torque += sign * (gear.friction_nm[side] + gear.load_friction[side] * weight.abs());
            for k in 0..4 {
                torque += gear.ripple_nm[k] * (gear.orders[k] * angle + gear.phases_rad[k]).cos();
            }
        }
        torque
    }

    /// Accelerations of motor and load side under the torque of the motor.
    fn accelerate(&self, driving: f64, [w1, q1, w2, q2, ..]: State) -> [f64; 2] {
        let mut motor = driving - self.viscous * w1 - self.coulomb * w1.tanh();
        if let (Some(closed), Some(brake)) = (self.brake, self.axis.brake) {
            let w = 2.0 * PI * 60.0;
            let lining = w * w * self.inertia * (q1 - closed) + 0.6 * w * self.inertia * w1;
            motor -= lining.max(-brake.torque_nm).min(brake.torque_nm);
        }
        let Some(belt) = self.belt else {
            let (added, slope) = self.swing(q1 / self.per_phi);
            let net = motor - self.against(q1, w1) - 0.5 * slope * w1 * w1;
            return [net / (self.inertia + added), 0.0];
        };
        let (j1, j2) = ((1.0 - belt.load_share) * self.inertia, belt.load_share * self.inertia);
        let (reduced, w) = (j1 * j2 / (j1 + j2), 2.0 * PI * belt.resonance_hz);
        let (twist, half) = (q1 - q2, 0.5 * belt.backlash_rad);
        let strain = if twist > half { twist - half } else { (twist + half).min(0.0) };
        let touching = strain != 0.0 || half == 0.0;
        let damping = if touching { 2.0 * belt.damping_ratio * w * reduced * (w1 - w2) } else { 0.0 };
        let coupling = w * w * reduced * strain + damping;
        let (added, slope) = self.swing(q2 / self.per_phi);
        let load = self.against(q2, w2) + 0.5 * slope * w2 * w2;
        [(motor - coupling) / j1, (coupling - load) / (j2 + added)]
    }
}

fn runge_kutta(x: State, h: f64, slope: impl Fn(State) -> State) -> State {
    let plus = |a: State, h: f64, b: State| std::array::from_fn(|k| a[k] + h * b[k]);
    let k1 = slope(x);
    let k2 = slope(plus(x, h / 2.0, k1));
    let k3 = slope(plus(x, h / 2.0, k2));
    let k4 = slope(plus(x, h, k3));
    std::array::from_fn(|k| x[k] + h / 6.0 * (k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]))
}

/// The load side at rest where it holds the weight.
fn held(machine: &Machine, angle: f64) -> f64 {
    let Some(belt) = machine.belt else { return angle };
    let stiffness =
        (2.0 * PI * belt.resonance_hz).powi(2) * machine.inertia * belt.load_share * (1.0 - belt.load_share);
    // The twist depends on the weight, which the twist hardly changes: the weight at the motor's angle holds.
    let weight = machine.weight(angle / machine.per_phi);
    angle - weight / stiffness - 0.5 * belt.backlash_rad * if weight == 0.0 { 0.0 } else { weight.signum() }
}

/// The motors of both rigs without friction of their own, noise and load.
fn quiet() -> Scenario {
    Scenario {
        load_amplitude_nm: 0.0,
        load_fluctuation_nm: 0.0,
        current_noise_a: 0.0,
        velocity_noise_rad_s: 0.0,
        ..Scenario::STANDARD
    }
}

/// Largest differences of velocity and of axis angle between the DC-motor rig and the integrator.
fn dc_differences(parts: &[AxisPart], ratio: f64, seed: u64) -> [f64; 2] {
    let scenario = quiet().on_axis(parts, AxisOptions { ratio: Some(ratio), weight_nm: Some(0.3) });
    let trace = rig::simulate(&scenario, seed).expect("valid");
    let axis = scenario.axis.expect("on");
    let mut machine = Machine {
        axis,
        gear: axis.gear.map(|gear| gear.draw(ratio, NoiseSource::new(seed, Stream::Gear))),
        belt: FieldValues::draw(&scenario, seed).mechanics,
        per_phi: ratio,
        linear: false,
        inertia: 2.5e-4,
        viscous: 1e-4,
        coulomb: 0.0,
        screw: 0.0,
        payload: trace.axis.payload[0],
        brake: None,
    };
    let start = trace.angle_rad[0];
    let mut x = [0.0, start, 0.0, held(&machine, start), 0.0, 0.0];
    let mut worst = [0.0_f64; 2];
    for k in 0..trace.len() - 1 {
        let side = if machine.belt.is_some() { x[3] } else { x[1] };
        worst[0] = worst[0].max((x[0] - trace.velocity_rad_s[k]).abs());
        worst[1] = worst[1].max((side / ratio - trace.axis.axis_rad[k]).abs());
        machine.payload = trace.axis.payload[k];
        machine.brake = (trace.axis.brake_closed[k] == 1.0).then(|| machine.brake.unwrap_or(x[1]));
        for _ in 0..80 {
            x = runge_kutta(x, 0.002 / 80.0, |x| {
                let driving = 0.05 * (trace.voltage_v[k] - 0.05 * x[0]) / 0.5;
                let [a1, a2] = machine.accelerate(driving, x);
                [a1, x[0], a2, x[2], 0.0, 0.0]
            });
        }
    }
    worst
}

#[test]
fn the_motor_of_the_rig_moves_its_axis_as_the_equations_say() {
    use AxisPart::{AnyCycle, Belt, Brake, Cycle, Gravity, PayloadSteps};
    // The rig's midpoint rule of h = 0.1 ms errs by (λ h)²/6 of a swing of rate λ: of the loop, 200 1/s, 7e-5 of some
    // rad/s; of a belt of 20 Hz, 3e-5; of the lining of the brake, 60 Hz, 2.4e-4, and of a gear of 80 Hz with backlash
    // 4e-4, both of some rad/s, with the instants of impacts.
    let cases: [(&[AxisPart], f64, f64); 6] = [
        (&[Gravity, Cycle], 50.0, 5e-4),
        (&[Gravity, AnyCycle], 5.0, 5e-4),
        (&[PayloadSteps, Cycle], 160.0, 5e-4),
        (&[Gravity, Belt, AnyCycle], 50.0, 5e-4),
        (&[Gravity, Brake, Cycle], 50.0, 3e-3),
        (&[Gravity, AxisPart::Gear, AnyCycle], 20.0, 3e-3),
    ];
    for (parts, ratio, bound) in cases {
        let [velocity, angle] = dc_differences(parts, ratio, 11);
        println!("{parts:?}: {velocity:.1e} rad/s, {angle:.1e} rad");
        assert!(velocity < bound, "{parts:?} {velocity}");
        // A difference of velocity lasts for at most about a second.
        assert!(angle < bound / ratio, "{parts:?} {angle}");
    }
}

/// Largest difference of velocity between the actuator and the integrator.
fn ema_difference(parts: &[AxisPart], gear: Option<Gear>, seed: u64) -> f64 {
    let base = EmaScenario {
        sensors: SensorErrors { resolver_bits: 30, ..SensorErrors::QUIET },
        load_fluctuation_n: 0.0,
        logging: Logging { every: 1, hold: 1 },
        rows: 24_000,
        ..EmaScenario::STANDARD
    };
    let mut scenario = base.on_axis(parts, AxisOptions::default());
    scenario.axis = scenario.axis.map(|axis| Axis { gear, ..axis });
    assert_eq!((scenario.load, scenario.cycle), (EmaLoad::Constant { force_n: 0.0 }, Some(Motion::Same)));
    let trace = rig::ema::simulate(&scenario, seed).expect("valid");
    let (axis, rotor) = (scenario.axis.expect("on"), scenario.actuator);
    let metres = rotor.lead_m / (2.0 * PI);
    let source = |stream| NoiseSource::new(seed, stream);
    // Angles count from mid-stroke.
    let mut machine = Machine {
        axis,
        gear: axis.gear.map(|gear| gear.draw(axis.ratio, source(Stream::Gear))),
        belt: None,
        per_phi: 0.07 / PI / metres,
        linear: true,
        inertia: 1.5e-3 + 40.0 * metres * metres,
        viscous: 2e-3,
        coulomb: 0.25,
        screw: 1.0 / 0.9 - 1.0,
        payload: trace.axis.payload[0],
        brake: None,
    };
    let kt = 1.5 * 6.0 * rotor.flux_wb;
    let mut x = [0.0, 0.0, 0.0, 0.0, 0.0, machine.weight(0.0) / kt];
    let mut worst = 0.0_f64;
    for k in 0..trace.len() - 1 {
        worst = worst.max((x[0] - trace.velocity_rad_s[k]).abs());
        machine.payload = trace.axis.payload[k];
        machine.brake = (trace.axis.brake_closed[k] == 1.0).then(|| machine.brake.unwrap_or(x[1]));
        let (vd, vq) = (trace.voltage_d_v[k], trace.voltage_q_v[k]);
        for _ in 0..4 {
            x = runge_kutta(x, 1.0 / 48_000.0, |x| {
                let [a, ..] = machine.accelerate(kt * x[5], x);
                let electrical = 6.0 * x[0];
                let d = (vd - 0.6 * x[4] + electrical * 3e-3 * x[5]) / 3e-3;
                let q = (vq - 0.6 * x[5] - electrical * (3e-3 * x[4] + rotor.flux_wb)) / 3e-3;
                [a, x[0], 0.0, 0.0, d, q]
            });
        }
    }
    worst
}

#[test]
fn the_actuator_moves_its_axis_as_the_equations_say() {
    use AxisPart::{Brake, Cycle, Gravity, PayloadSteps};
    // Wheels and friction of a gear, without its backlash.
    let cases: [(&[AxisPart], Option<Gear>); 4] = [
        (&[Gravity, Cycle], None),
        (&[Gravity, Cycle], Some(Gear::LINEAR)),
        (&[PayloadSteps, Cycle], None),
        (&[Gravity, Brake, Cycle], None),
    ];
    for (parts, gear) in cases {
        let difference = ema_difference(parts, gear, 7);
        println!("{parts:?}: {difference:.1e} rad/s");
        // Both rules are of the fourth order, 2e-7 a step; the voltage turns by the steps of a resolver of 30 bits.
        assert!(difference < 1e-4, "{parts:?} {difference}");
    }
}
