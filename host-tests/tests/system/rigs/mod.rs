//! The simulated DC motor against closed forms and another simulator, and the torques that turn with its rotor.

mod cogging;
mod dc_motor_recordings;
mod dc_motor_rig;
