//! A permanent-magnet motor, its shaft with friction and load, and a bearing 608.

use core::f32::consts::TAU;

use crate::noise::Noise;
use crate::{Duty, RATE_HZ};

pub const POLE_PAIRS: f32 = 7.0;
pub const ENCODER_COUNTS: u16 = 4096;
/// The largest compare value.
pub const PWM_TOP: u16 = 999;

const SUPPLY_V: f32 = 24.0;
const RESISTANCE_OHM: f32 = 0.36;
const INDUCTANCE_H: f32 = 0.35e-3;
const FLUX_WB: f32 = 5.5e-3;
const SQRT_3: f32 = 1.732_050_8;
const INERTIA_KG_M2: f32 = 9.0e-5;
/// Of the encoder behind the magnets' axis: the mounting is adjusted in this drive.
const COGGING_NM: f32 = 1.5e-3;
/// Balls that pass a place of the outer ring in a turn: seven balls of 3.97 mm on 15 mm, with a slip of 0.5 %.
const OUTER_ORDER: f32 = 3.5 * (1.0 - 3.97 / 15.0) * 0.995;
/// Part of the way between two balls that a pulse takes.
const PULSE: f32 = 0.12;

/// State of the motor; angles are in turns.
#[derive(Debug)]
pub struct Motor {
    /// Direct and quadrature current.
    d_a: f32,
    q_a: f32,
    velocity_rad_s: f32,
    turns: f32,
    /// Balls that have passed the spall.
    balls: f32,
    pub spall_nm: f32,
    coulomb_nm: f32,
    viscous_nm_s_rad: f32,
    load_nm: f32,
    /// The load's own slow change.
    wander_nm: f32,
}

impl Motor {
    pub fn new(duty: Duty, noise: &mut Noise) -> Self {
        Self {
            d_a: 0.0,
            q_a: 0.0,
            velocity_rad_s: 0.0,
            turns: noise.between(0.0, 1.0),
            balls: noise.between(0.0, 1.0),
            spall_nm: duty.spall_nm,
            coulomb_nm: noise.between(0.010, 0.014),
            viscous_nm_s_rad: noise.between(1.0e-4, 1.6e-4),
            load_nm: noise.between(-0.01, 0.01),
            wander_nm: 0.0,
        }
    }

    fn electrical_turns(&self) -> f32 {
        self.turns * POLE_PAIRS
    }

    /// Currents of phases A and B.
    pub fn currents_a(&self) -> [f32; 2] {
        let turns = self.electrical_turns();
        [0.0, 1.0 / 3.0].map(|behind| self.d_a * sin(turns - behind + 0.25) - self.q_a * sin(turns - behind))
    }

    pub fn encoder(&self) -> u16 {
        (self.turns * f32::from(ENCODER_COUNTS)) as u16 % ENCODER_COUNTS
    }

    /// One period of the pulse-width modulation with these compare values.
    pub fn step(&mut self, compare: [u16; 3], noise: &mut Noise) {
        const STEP_S: f32 = 1.0 / RATE_HZ;
        let [a, b, c] = compare.map(|counts| f32::from(counts) / f32::from(PWM_TOP) * SUPPLY_V);
        let (alpha, beta) = ((2.0 * a - b - c) / 3.0, (b - c) / SQRT_3);
        let (re, im) = (sin(self.electrical_turns() + 0.25), sin(self.electrical_turns()));
        let electrical_rad_s = POLE_PAIRS * self.velocity_rad_s;
        let (d_v, q_v) = (re * alpha + im * beta, re * beta - im * alpha);
        let d_slope = d_v - RESISTANCE_OHM * self.d_a + electrical_rad_s * INDUCTANCE_H * self.q_a;
        let q_slope = q_v - RESISTANCE_OHM * self.q_a - electrical_rad_s * (INDUCTANCE_H * self.d_a + FLUX_WB);
        self.d_a += STEP_S / INDUCTANCE_H * d_slope;
        self.q_a += STEP_S / INDUCTANCE_H * q_slope;
        self.wander_nm += STEP_S * (0.01 * noise.normal() - 0.5 * self.wander_nm);
        let torque_nm = 1.5 * POLE_PAIRS * FLUX_WB * self.q_a + COGGING_NM * sin(42.0 * self.turns);
        self.velocity_rad_s += STEP_S / INERTIA_KG_M2 * (torque_nm - self.resistance_nm());
        let moved = STEP_S * self.velocity_rad_s / TAU;
        self.turns = wrapped(self.turns + moved);
        self.balls = wrapped(self.balls + moved * OUTER_ORDER);
    }

    /// Friction, load, and the pulse of a ball in the spall.
    fn resistance_nm(&self) -> f32 {
        // The direction turns smoothly within a few hundredths of rad/s, so that the shaft can rest.
        let direction = (self.velocity_rad_s / 0.05).clamp(-1.0, 1.0);
        let pulse = if self.balls < PULSE { sin(0.5 * self.balls / PULSE) } else { 0.0 };
        let friction_nm = self.coulomb_nm + self.spall_nm * pulse;
        friction_nm * direction + self.viscous_nm_s_rad * self.velocity_rad_s + self.load_nm + self.wander_nm
    }
}

/// The sine of an angle in turns, by its series: libm's computes in double precision, which the chip has not.
pub fn sin(turns: f32) -> f32 {
    let half = turns - libm::floorf(turns + 0.5);
    let quarter = if half.abs() > 0.25 { 0.5f32.copysign(half) - half } else { half };
    let (x, x2) = (TAU * quarter, TAU * TAU * quarter * quarter);
    x * (1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0 * (1.0 - x2 / 72.0 * (1.0 - x2 / 110.0)))))
}

/// Into one turn.
fn wrapped(turns: f32) -> f32 {
    turns - libm::floorf(turns)
}
