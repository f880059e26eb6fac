//! Faults of sensors, electronics and wiring: each is named, counted or refused, and none becomes a defect.

pub mod electronics;
mod found_late;
mod implausible;
mod injected;
mod lost_samples;
mod rigs;
mod silent;
mod stuck;
mod table;
mod wiring;
