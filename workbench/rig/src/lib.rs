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
//! | [`levels`] | signal levels, and noise for a given signal-to-noise ratio |
//! | [`conditions`] | named changes of a scenario: excitation, load, motor or noise; severities |
//! | [`field_conditions`] | named conditions for the effects of the field |
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

pub mod bearing;
pub mod closed_loop;
pub mod conditions;
pub mod dc_motor;
pub mod ema;
pub mod field;
pub mod field_conditions;
pub mod levels;
pub mod noise;
pub mod scenario;
mod sensors;
pub mod trace;
pub mod waveform;

pub use bearing::{BearingGeometry, BearingOrders, Defect, DefectKind, DefectTorque};
pub use closed_loop::simulate;
pub use conditions::{Condition, SEVERITIES};
pub use dc_motor::{Electrical, MotorParameters, Plant, PlantState, Stage, TABLE_2_1, TABLE_2_3};
pub use field::{Drive, Duty, Field, FieldValues};
pub use levels::SignalLevels;
pub use noise::{CurrentFilter, LoadFluctuation, NoiseSource, Stream};
pub use scenario::Scenario;
pub use trace::RigTrace;
pub use waveform::Waveform;

/// Reason why a rig cannot be built or run; each error contains the name of the invalid parameter.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// The value is NaN or infinite.
    #[error("{name} must be finite, got {value}")]
    NotFinite {
        /// Field name with its unit.
        name: &'static str,
        /// The rejected value.
        value: f64,
    },
    /// The value must be positive, but is zero or negative.
    #[error("{name} must be positive, got {value}")]
    NotPositive {
        /// Field name with its unit.
        name: &'static str,
        /// The rejected value.
        value: f64,
    },
    /// The value must not be negative.
    #[error("{name} must not be negative, got {value}")]
    Negative {
        /// Field name with its unit.
        name: &'static str,
        /// The rejected value.
        value: f64,
    },
    /// The value lies outside its range.
    #[error("{name} must lie between {from} and {to}, got {value}")]
    OutOfRange {
        /// Field name with its unit.
        name: &'static str,
        /// The rejected value.
        value: f64,
        /// Smallest value.
        from: f64,
        /// Largest value.
        to: f64,
    },
    /// A trace needs at least one sample.
    #[error("samples must be at least 1")]
    NoSamples,
    /// The fluctuation's AR(1) pole lies on or outside the unit circle.
    #[error("load_fluctuation_pole must lie strictly between -1 and 1, got {0}")]
    UnstableFluctuation(f64),
    /// The loop is unstable: gains, motor and sampling time are not compatible.
    #[error("the closed loop diverges: state no longer finite at t = {t_s} s")]
    Diverged {
        /// Time of the first sample that is not finite.
        t_s: f64,
    },
}

/// The seed of trace `k` of one class in the set of seed `set`. Injective for k < 2²⁹, so that sets with different
/// seeds, and classes of one set, never share a trace.
#[must_use]
pub const fn trace_seed(set: u32, kind: DefectKind, k: u32) -> u64 {
    let class = kind.number() as u64;
    // Three bits of class, the most significant one last, and twenty-nine bits of `k`.
    let class = ((class & 3) << 30) | ((class >> 2) << 29);
    ((set as u64) << 32) | class | (k as u64 & 0x1fff_ffff)
}

/// Returns `value` if it is finite.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<f64, RigError> {
    if value.is_finite() { Ok(value) } else { Err(RigError::NotFinite { name, value }) }
}

/// Returns `value` if it is finite and positive.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, RigError> {
    if finite(name, value)? > 0.0 { Ok(value) } else { Err(RigError::NotPositive { name, value }) }
}

/// Returns `value` if it is finite and not negative.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<f64, RigError> {
    if finite(name, value)? >= 0.0 { Ok(value) } else { Err(RigError::Negative { name, value }) }
}
