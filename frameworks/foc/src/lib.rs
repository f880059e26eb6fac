//! A drive that knows nothing of bearing-watch: a motor with its load, and the field-oriented control of the crate
//! [`foc`] around it. It runs on the computer, to be recorded, and in the firmware, in closed loop beside the monitor.
//!
//! ```text
//! command ─► velocity ─► foc::Foc ─► duty cycles ─► motor, shaft, bearing ─┐
//!               ▲            ▲                                             │
//!               └────────────┴── counts: two phase currents, encoder ◄─────┘
//! ```

#![no_std]

mod control;
mod motor;
mod noise;

use control::Control;
use motor::Motor;
use noise::Noise;

/// The rate of the current loop, Hz.
pub const RATE_HZ: f32 = 8000.0;

/// What differs from one record to the next.
#[derive(Clone, Copy, Debug)]
pub struct Duty {
    /// Seed of the noise, and of what else is left to chance.
    pub seed: u32,
    /// Torque of the pulses of a spall of the outer ring, N·m; 0 for a sound bearing.
    pub spall_nm: f32,
}

/// What the drive reads at one instant, in the words of its own converters.
#[derive(Clone, Copy, Debug)]
pub struct Counts {
    /// Counts of the currents of phases A and B: 2048 at 0 A, 10 mA a count.
    pub phases: [u16; 2],
    /// Counts of the encoder, 4096 a turn.
    pub encoder: u16,
    /// The command of the velocity, rad/s.
    pub velocity_ref_rad_s: f32,
}

/// Control and motor.
#[derive(Debug)]
pub struct Drive {
    control: Control,
    motor: Motor,
    noise: Noise,
    /// Amplitude of the command, rad/s.
    amplitude_rad_s: f32,
    /// Part of a period of the command in one step.
    step: f32,
    /// Part of a period that has passed.
    phase: f32,
}

impl Drive {
    /// At rest, with the amplitude and the period of the command, friction and load of this record.
    pub fn new(duty: Duty) -> Self {
        let mut noise = Noise::new(duty.seed);
        let amplitude_rad_s = noise.between(25.0, 40.0);
        let step = noise.between(0.3, 0.6) / RATE_HZ;
        Self { control: Control::new(), motor: Motor::new(duty, &mut noise), noise, amplitude_rad_s, step, phase: 0.0 }
    }

    /// The size of a spall from now on, N·m.
    pub fn damage(&mut self, spall_nm: f32) {
        self.motor.spall_nm = spall_nm;
    }

    /// One period of the current loop: reads the converters, and drives the motor until the next reading.
    pub fn step(&mut self) -> Counts {
        self.phase = (self.phase + self.step) % 1.0;
        let velocity_ref_rad_s = self.amplitude_rad_s * motor::sin(self.phase);
        let phases = self.motor.currents_a().map(|current_a| {
            let counts = 2048.0 + current_a / control::AMPERES_A_COUNT + self.noise.normal();
            libm::roundf(counts).clamp(0.0, 4095.0) as u16
        });
        let encoder = self.motor.encoder();
        let duty_cycles = self.control.step(phases, encoder, velocity_ref_rad_s);
        self.motor.step(duty_cycles, &mut self.noise);
        Counts { phases, encoder, velocity_ref_rad_s }
    }
}
