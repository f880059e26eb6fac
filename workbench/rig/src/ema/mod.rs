//! The simulated electromechanical actuator: a synchronous motor with a ball screw under position control (thesis
//! chapter 5).
//!
//! ```text
//!  x_ref ─►(+)─► P ─► ω_ref ─►(+)─► PI ─► i_ref ─►(+)─► PI, decoupling ─► |v| ≤ U/√3 ─► motor ─► screw ─► mass ─► x
//!          −▲                 −▲                  −▲                                      │ θ, i      ▲
//!           x_m                ω_m                 i_d, i_q ◄── Park ◄── phase currents ◄─┤      force or springs
//!                                                               ▲                         │
//!                                                               └──── resolver counts ◄───┘
//! ```
//!
//! Input: one [`EmaScenario`] and one `u64` seed. Output: one [`EmaTrace`], in SI units. Currents are peak values, and
//! a positive force opposes positive motion.
//!
//! | module | content |
//! |---|---|
//! | [`actuator`] | constants of motor, screw and friction; temperature |
//! | [`defect`] | spalls of both races, lost lubrication |
//! | [`plant`] | the equations of motion in the rotor frame and their integration |
//! | [`control`] | position, velocity and current loop, limits |
//! | [`load`] | hydraulic force, springs |
//! | [`sensors`] | resolver, phase currents, position, velocity |
//! | [`scenario`] | the standard experiment, and random conditions |
//! | [`conditions`] | named conditions of the rigs at Moog and at RIT |
//! | [`closed_loop`] | the closed loop of all parts |
//! | [`trace`] | the recorded trace |
//!
//! Seeds have the scheme of [`trace_seed`](super::trace_seed). A seed has the same noise under every condition.
//!
//! ```
//! use bearing_watch_rig::ema::{EmaCondition, EmaDefect, EmaScenario, Race, simulate};
//! use bearing_watch_rig::{DefectKind, trace_seed};
//!
//! let condition = EmaCondition::named("moog-1-mix").expect("known");
//! let seed = trace_seed(1, DefectKind::Spall, 0);
//! let defect = EmaDefect::of(DefectKind::Spall, 1.0, Race::Inner);
//! let trace = simulate(&EmaScenario { rows: 60, defect, ..condition.scenario(seed) }, seed)?;
//! assert_eq!(trace.current_a.len(), 60);
//! # Ok::<(), bearing_watch_rig::RigError>(())
//! ```

pub mod actuator;
pub mod closed_loop;
pub mod conditions;
pub mod control;
pub mod defect;
mod front_end;
pub mod load;
pub mod plant;
pub mod scenario;
pub mod sensors;
pub mod trace;

pub use actuator::Actuator;
pub use closed_loop::simulate;
pub use conditions::EmaCondition;
pub use control::{Commands, Controller, DriveSettings, Feedback};
pub use defect::{EmaDefect, Pulses, Race};
pub use load::EmaLoad;
pub use plant::{DqVoltage, EmaPlant, EmaState};
pub use scenario::{EmaScenario, Logging};
pub use sensors::SensorErrors;
pub use trace::EmaTrace;
