//! The simulated DC-motor rig: a motor under velocity control with a bearing that can be hurt.
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
//! What enters: one [`Scenario`] (a plain struct literal) and one `u64` seed. What leaves: one
//! [`RigTrace`], the columns a drive could have recorded, in SI units.
//!
//! | room | what it holds |
//! |---|---|
//! | [`dc_motor`] | the motor of thesis Eq. 2.24–2.25, with the current as a state or quasi-static |
//! | [`bearing`] | the characteristic orders, the torque of each defect, the weakened magnet |
//! | [`waveform`] | sine, triangle and square velocity references |
//! | [`noise`] | independent seeded streams, load fluctuation, current measurement filter |
//! | [`scenario`] | the standard rig, the loop that joins the rooms, the recorded trace |
//! | [`levels`] | how strong the signals are, and noise of a wanted signal-to-noise ratio |
//! | [`conditions`] | named changes of a scenario: other excitation, load, motor or noise; severities |
//!
//! Everything is `f64`, and sines and hyperbolic tangents come from `libm`, so that a seed means
//! the same trace on every machine. The rig has its own equations on purpose: it shares no code
//! with the estimators that are judged on it.
//!
//! ```
//! use workbench::rig::{Defect, DefectKind, Scenario, simulate};
//!
//! let scenario = Scenario {
//!     defect: Defect { kind: DefectKind::Spall, severity: 0.5 },
//!     samples: 500,
//!     ..Scenario::STANDARD
//! };
//! let trace = simulate(&scenario, 7)?;
//! assert_eq!(trace.current_a.len(), 500);
//! # Ok::<(), workbench::rig::RigError>(())
//! ```

pub mod bearing;
pub mod conditions;
pub mod dc_motor;
pub mod levels;
pub mod noise;
pub mod scenario;
pub mod waveform;

pub use bearing::{BearingGeometry, BearingOrders, Defect, DefectKind, DefectTorque};
pub use conditions::{Condition, SEVERITIES};
pub use dc_motor::{Electrical, MotorParameters, Plant, PlantState, TABLE_2_1, TABLE_2_3};
pub use levels::SignalLevels;
pub use noise::{CurrentFilter, LoadFluctuation, NoiseSource, Stream};
pub use scenario::{RigTrace, Scenario, simulate};
pub use waveform::Waveform;

/// Why a rig cannot be built or run; each names the parameter at fault.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// NaN or infinite.
    #[error("{name} must be finite, got {value}")]
    NotFinite {
        /// Field name with its unit.
        name: &'static str,
        /// The refused value.
        value: f64,
    },
    /// Zero or negative where only a positive value has a meaning.
    #[error("{name} must be positive, got {value}")]
    NotPositive {
        /// Field name with its unit.
        name: &'static str,
        /// The refused value.
        value: f64,
    },
    /// Negative where zero is the least.
    #[error("{name} must not be negative, got {value}")]
    Negative {
        /// Field name with its unit.
        name: &'static str,
        /// The refused value.
        value: f64,
    },
    /// A trace needs at least one sample.
    #[error("samples must be at least 1")]
    NoSamples,
    /// The fluctuation's AR(1) pole lies on or outside the unit circle.
    #[error("load_fluctuation_pole must lie strictly between -1 and 1, got {0}")]
    UnstableFluctuation(f64),
    /// The loop ran away: gains, motor and sampling time do not go together.
    #[error("the closed loop diverges: state no longer finite at t = {t_s} s")]
    Diverged {
        /// Time of the first sample that is not finite.
        t_s: f64,
    },
}

/// The seed of trace `k` of one class in the set of seed `set`. Injective for k < 2²⁹, so that sets of different
/// seeds, and classes of one set, never share a trace.
#[must_use]
pub const fn trace_seed(set: u32, kind: DefectKind, k: u32) -> u64 {
    let class = kind.number() as u64;
    // Three bits of class, the upper one last, and twenty-nine of count.
    let class = ((class & 3) << 30) | ((class >> 2) << 29);
    ((set as u64) << 32) | class | (k as u64 & 0x1fff_ffff)
}

/// `value`, if it is a finite number.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<f64, RigError> {
    if value.is_finite() { Ok(value) } else { Err(RigError::NotFinite { name, value }) }
}

/// `value`, if it is finite and above zero.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, RigError> {
    if finite(name, value)? > 0.0 { Ok(value) } else { Err(RigError::NotPositive { name, value }) }
}

/// `value`, if it is finite and zero or above.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<f64, RigError> {
    if finite(name, value)? >= 0.0 { Ok(value) } else { Err(RigError::Negative { name, value }) }
}
