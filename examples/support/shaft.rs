//! A shaft with a bearing to watch: constants, and a motion for them.

use bearing_watch::estimate::{Balance, StateVariable, TrackedOrder, Tracking};
use bearing_watch::{Angle, Bearing, Guard, Motion, ShaftModel};

use super::numbers::Numbers;

const INTERVAL_S: f32 = 0.002;

/// i = p₀ ω̇ + p₁ ω + p₂ s(r) + p₃ T + p₄ of the healthy shaft.
const NOMINAL: [f32; 5] = [5e-3, 2e-3, 0.1, 20.0, 0.05];

/// `K` orders of a bearing, each with so many harmonics that all weigh the same; blocks of so many samples.
pub fn model<const K: usize>(harmonics: u8, block_samples: u16) -> ShaftModel<K> {
    let bearing = Bearing { balls: 9, ball_diameter: 3.0, pitch_diameter: 17.0, contact_angle_rad: 0.1745 };
    let mut found = [bearing.outer(), bearing.inner(), bearing.ball(), bearing.cage()].into_iter();
    let weights = core::array::from_fn(|h| if h < harmonics as usize { 1.0 } else { 0.0 });
    let mut count = 0;
    let orders: [TrackedOrder; K] = core::array::from_fn(|_| match found.next() {
        Some(order) => {
            count += 1;
            TrackedOrder::new(order, weights)
        }
        None => TrackedOrder::NONE,
    });
    ShaftModel {
        guard: Guard::within([100.0, 500.0, 2.0]),
        current_delay: 0.7,
        balance: Balance {
            interval_s: INTERVAL_S,
            // 8 Hz.
            filter: StateVariable::new(0.050_307, INTERVAL_S),
            row_interval: 8,
            settle: 100,
            sign_velocity_rad_s: 2.0,
            usual_velocity_rad_s: 28.0,
            load: true,
            scale: [0.031_25, 0.031_25, 8.0, 0.5],
            nominal: NOMINAL,
        },
        tracking: Tracking { orders, count, harmonics, still: 4_000_000, block_samples },
    }
}

/// Turns to and fro by 40 rad/s against a load, the bearing dragging at its outer ring; one sample in 701 is lost.
pub struct Plant {
    numbers: Numbers,
    /// Phases of reference and load, and the shaft's angle, as binary fractions of a turn.
    reference: Angle,
    load: Angle,
    shaft: Angle,
    /// Turns times the outer ring's order, and the current's lag.
    drag: f32,
    last_current_a: f32,
    last_velocity_rad_s: f32,
    time: u32,
}

impl Plant {
    /// At rest.
    pub const fn new(seed: u32) -> Self {
        Self {
            numbers: Numbers(seed),
            reference: Angle::ZERO,
            load: Angle::ZERO,
            shaft: Angle::ZERO,
            drag: 0.0,
            last_current_a: 0.0,
            last_velocity_rad_s: 0.0,
            time: 0,
        }
    }

    /// The next sample.
    pub fn motion(&mut self) -> Motion {
        // 0.9 and 1.7 Hz.
        self.reference = self.reference.plus(Angle::from_bits(7_730_941));
        self.load = self.load.plus(Angle::from_bits(14_602_888));
        let reference_rad_s = 40.0 * self.reference.sin_cos().sin;
        let [noise, fluctuation, current_noise] = self.numbers.array();
        let velocity_rad_s = reference_rad_s + 0.5 * noise;
        let load_nm = 0.15 * self.load.sin_cos().sin + 0.06 * fluctuation;
        let turned = Angle::from_radians(velocity_rad_s * INTERVAL_S);
        self.shaft = self.shaft.plus(turned);
        self.drag += 3.717_94 * velocity_rad_s * INTERVAL_S;
        let sign = (reference_rad_s / 2.0).clamp(-1.0, 1.0);
        let [inertia, viscous, coulomb, load, offset] = NOMINAL;
        let slope = (velocity_rad_s - self.last_velocity_rad_s) / INTERVAL_S;
        self.last_velocity_rad_s = velocity_rad_s;
        let drag = 0.3 * sign * Angle::from_radians(self.drag).sin_cos().cos;
        let torque = inertia * slope + viscous * velocity_rad_s + coulomb * sign + load * load_nm + offset + drag;
        let current_a = 0.7 * self.last_current_a + 0.3 * torque + 0.1 * current_noise;
        self.last_current_a = torque;
        self.time = self.time.wrapping_add(1);
        let current_a = if self.time.is_multiple_of(701) { f32::NAN } else { current_a };
        Motion { current_a, velocity_rad_s, reference_rad_s, load_nm, angle: self.shaft }
    }
}
