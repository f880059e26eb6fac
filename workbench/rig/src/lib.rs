//! The simulated DC-motor rig: a motor under velocity control whose bearing can have a defect.
//!
//! ```text
//!  reference ─►(+)── e ──► PI ── v held over Ts ──► motor (i, ω, θ) ──► i ─► 140 Hz ─►(+)─► current_a
//!              −▲                                    ▲       ▲  │                      ▲
//!               │                       load torque ─┘       │  └── ω        current noise
//!               └────────── velocity_rad_s ◄──(+)◄───────────┼──────┘
//!                                              ▲    bearing torque(θ, ω, i)
//!                                        velocity noise
//! ```
//!
//! Input: one [`Scenario`] (a plain struct literal) and one `u64` seed. Output: one [`RigTrace`], the columns that a
//! drive could have recorded, in SI units.
//!
//! | module | content |
//! |---|---|
//! | [`dc_motor`] | the motor of thesis Eq. 2.24–2.25, with the current as a state or quasi-static |
//! | [`bearing`] | the characteristic orders, the torque of each defect, the weak magnet |
//! | [`waveform`] | sine, triangle and square velocity references |
//! | [`noise`] | independent seeded streams, load fluctuation, current measurement filter |
//! | [`scenario`] | the standard rig |
//! | [`closed_loop`] | the closed loop of all parts |
//! | [`trace`] | the recorded trace |
//! | [`field`] | effects that drives in the field have and the standard rig does not have |
//! | [`axis`] | an axis of a machine: weight, gear, belt, brake, cycles |
//! | [`levels`] | signal levels, and noise for a given signal-to-noise ratio |
//! | [`conditions`] | named changes of a scenario: excitation, load, motor or noise; severities |
//! | [`field_conditions`] | named conditions for the effects of the field |
//! | [`axis_conditions`] | named conditions of axes |
//! | [`ema`] | the other rig: an electromechanical actuator |
//!
//! All values are `f64`, and sines and hyperbolic tangents are computed by `libm`, so that a seed produces the same
//! trace on every machine. The rig deliberately has its own equations: it shares no code with the estimators that
//! are tested on it.
//!
//! ```
//! use bearing_watch_rig::{Defect, DefectKind, Scenario, simulate};
//!
//! let scenario = Scenario {
//!     defect: Defect { kind: DefectKind::Spall, severity: 0.5 },
//!     samples: 500,
//!     ..Scenario::STANDARD
//! };
//! let trace = simulate(&scenario, 7)?;
//! assert_eq!(trace.current_a.len(), 500);
//! # Ok::<(), bearing_watch_rig::RigError>(())
//! ```

pub mod axis;
pub mod axis_conditions;
pub mod bearing;
pub mod closed_loop;
pub mod conditions;
pub mod dc_motor;
pub mod ema;
mod error;
pub mod field;
pub mod field_conditions;
pub mod levels;
pub mod noise;
pub mod scenario;
mod sensors;
pub mod trace;
pub mod waveform;

pub use axis::{Axis, AxisPart};
pub use bearing::{BearingGeometry, BearingOrders, Defect, DefectKind, DefectTorque};
pub use closed_loop::simulate;
pub use conditions::{Condition, SEVERITIES};
pub use dc_motor::{Electrical, MotorParameters, Plant, PlantState, Stage, TABLE_2_1, TABLE_2_3};
pub use error::RigError;
pub(crate) use error::{finite, fraction, not_negative, positive, within};
pub use field::{Drive, Duty, Field, FieldValues};
pub use levels::SignalLevels;
pub use noise::{CurrentFilter, LoadFluctuation, NoiseSource, Stream};
pub use scenario::Scenario;
pub use trace::RigTrace;
pub use waveform::Waveform;

/// The seed of trace `k` of one class in the set of seed `set`. Injective for k < 2²⁹, so that sets with different
/// seeds, and classes of one set, never share a trace.
#[must_use]
pub const fn trace_seed(set: u32, kind: DefectKind, k: u32) -> u64 {
    let class = kind.number() as u64;
    // Three bits of class, the most significant one last, and twenty-nine bits of `k`.
    let class = ((class & 3) << 30) | ((class >> 2) << 29);
    ((set as u64) << 32) | class | (k as u64 & 0x1fff_ffff)
}
