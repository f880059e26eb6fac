//! The control: a velocity loop, and the current loops of the crate `foc`.

use core::f32::consts::TAU;

use fixed::types::I16F16;
use foc::Foc;
use foc::pid::PIController;
use foc::pwm::SpaceVector;

use crate::RATE_HZ;
use crate::motor::{ENCODER_COUNTS, POLE_PAIRS, PWM_TOP};

pub const AMPERES_A_COUNT: f32 = 0.01;
/// Steps of the current loop for one of the velocity loop.
const VELOCITY_STEPS: u32 = 8;
/// Gains of the velocity loop, A s/rad and A/rad.
const PROPORTIONAL: f32 = 0.08;
const INTEGRAL: f32 = 1.2;
const MOST_CURRENT_A: f32 = 5.0;
/// Part of a new value in the velocity that is fed back: quantisation is averaged over some steps.
const SMOOTHING: f32 = 0.2;

pub struct Control {
    foc: Foc<SpaceVector, PWM_TOP>,
    steps: u32,
    last: Option<u16>,
    velocity_rad_s: f32,
    integral_a: f32,
    current_ref_a: f32,
}

impl core::fmt::Debug for Control {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Control").field("current_ref_a", &self.current_ref_a).finish_non_exhaustive()
    }
}

impl Control {
    pub fn new() -> Self {
        // The crate takes measurement minus setpoint, hence the signs; its time is in ms. A voltage of 1 is half of the
        // supply.
        let gains = || PIController::new(I16F16::from_num(-0.08), I16F16::from_num(-0.04));
        Self {
            foc: Foc::new(gains(), gains()),
            steps: 0,
            last: None,
            velocity_rad_s: 0.0,
            integral_a: 0.0,
            current_ref_a: 0.0,
        }
    }

    /// Compare values of the three phases.
    pub fn step(&mut self, phases: [u16; 2], encoder: u16, velocity_ref_rad_s: f32) -> [u16; 3] {
        if self.steps.is_multiple_of(VELOCITY_STEPS) {
            self.velocity(encoder, velocity_ref_rad_s);
        }
        self.steps = self.steps.wrapping_add(1);
        let currents = phases.map(|counts| I16F16::from_num((f32::from(counts) - 2048.0) * AMPERES_A_COUNT));
        let turns = f32::from(encoder) / f32::from(ENCODER_COUNTS) * POLE_PAIRS;
        let angle = I16F16::from_num(TAU * (turns - libm::floorf(turns + 0.5)));
        self.foc.update(currents, angle, I16F16::from_num(self.current_ref_a), I16F16::from_num(1e3 / RATE_HZ))
    }

    fn velocity(&mut self, encoder: u16, velocity_ref_rad_s: f32) {
        let half = ENCODER_COUNTS / 2;
        let last = self.last.replace(encoder).unwrap_or(encoder);
        let moved = (encoder.wrapping_sub(last).wrapping_add(half) % ENCODER_COUNTS) as f32 - f32::from(half);
        let period_s = VELOCITY_STEPS as f32 / RATE_HZ;
        let velocity_rad_s = TAU * moved / f32::from(ENCODER_COUNTS) / period_s;
        self.velocity_rad_s += SMOOTHING * (velocity_rad_s - self.velocity_rad_s);
        let error = velocity_ref_rad_s - self.velocity_rad_s;
        self.integral_a = (self.integral_a + INTEGRAL * error * period_s).clamp(-MOST_CURRENT_A, MOST_CURRENT_A);
        self.current_ref_a = (PROPORTIONAL * error + self.integral_a).clamp(-MOST_CURRENT_A, MOST_CURRENT_A);
    }
}
