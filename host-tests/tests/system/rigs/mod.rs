//! The simulated rigs against closed forms, other integrators and another simulator, and the torques that turn with the
//! rotor.

mod axis;
mod cogging;
mod dc_motor_recordings;
mod dc_motor_rig;
