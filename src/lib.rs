//! Bearing-fault detection next to the current loop, from signals that a motor drive already has.
//!
//! ```
//! use bearing_watch::{Detector, Monitor, Verdict};
//! // `bearing-watch train --rust model.rs` writes this module: the plan `Drive`, its `Sample`, and `MODEL`.
//! # mod model { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/support/standard_rig/model.rs")); }
//! use model::{MODEL, Sample};
//!
//! let mut detector = Detector::new(&MODEL); // of the sampling interrupt
//! let mut monitor = Monitor::new(&MODEL); // of the main loop
//! for k in 0..10_000 {
//!     // On a drive: the quadrature current, the velocity reference and the load at each sampling instant.
//!     let t = 0.002 * k as f32;
//!     let sample = Sample { current_a: t.sin(), velocity_ref_rad_s: 40.0 * t.cos(), load_torque_nm: 0.1 };
//!     if let Some(segment) = detector.collect(&sample) {
//!         let now = monitor.conclude(segment);
//!         match now.report.verdict {
//!             Verdict::Class(class) => println!("{}", MODEL.label(class)),
//!             Verdict::Novel | Verdict::Ambiguous => println!("unknown"),
//!             Verdict::Undetermined(reason) => println!("no verdict: {reason}"),
//!         }
//!         if let Some(alarm) = now.alarm {
//!             println!("alarm since segment {}", alarm.segment);
//!         }
//!     }
//! }
//! ```
//!
//! ```text
//! drive       raw counts ─► currents, angle ─► quadrature current, velocity, decimation; optional
//! plan        what a detector is made of: channels, structure, sizes
//! signal         ▼ gate: which channels may be used                means of channels
//! regression  δ-form rows by least squares or instruments ─┐      shaft   balance: torque balance ─► Friction
//!   factor    triangular factor, solve                     │              orders: its residual ─► OrderStrength
//!   estimate     ▼                                         │                 │
//!             Estimate: parameters, covariance, σ² ◄───────┘                 │
//! decide         ▼ features ─► covariates ─► projection ─► discriminant, gates ◄───────────┘
//!             Decision ─► Verdict
//! alarm       Evidence ─► Alarm
//! model       trained constants: checked at compile time, or read from bytes
//! detector    Detector, of the interrupt: samples ─► Segment;   Monitor, of the main loop: Segment ─► Report, Alarm
//!             alarm as bytes
//! watch       front end, detector and monitor as one static, for interrupts and main loop, on request
//! storage     records in flash that survive power-off
//! telemetry   reports and samples as frames for a serial line, and their decoder; reports as frames for CAN
//! signature   signed models, and saved states under a key of the drive
//! ```
//!
//! A [`Model`] holds trained constants (flash). A [`Detector`] is what the sampling interrupt owns, and a [`Monitor`]
//! what the main loop owns. All take one type parameter, the plan ([`plan!`]). The crate is `no_std`, allocates nothing
//! (but for the host's feature `alloc`), contains no `unsafe`, and uses no fused multiply-add: the same samples give
//! the same bits on a host and on a Cortex-M4F. A bad sample is counted and skipped; no function panics.
//!
//! Features: `watch` ([`watch::Watch`], one object for interrupts and main loop), `defmt` (formats, and a log line for
//! each segment), `embedded-hal` (the driver `ad2s1210`), `embedded-storage` (records in flash), `telemetry` (frames for
//! a serial line or CAN), `embedded-can` (those for CAN by the traits of a driver), `signature` (signed models, sealed
//! states), `nalgebra` (conversions of covariance and projection), `alloc` (the plan `RunTime` of host programs),
//! `bounded` (array lengths that a model brings, without an allocator, as the C interface needs them), `internals`
//! (parts for this repository's tests and measurements; not stable).
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::float_cmp,
        clippy::cast_possible_truncation
    )
)]

#[cfg(any(test, feature = "alloc"))]
extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod alarm;
#[cfg(doctest)]
mod book;
mod checksum;
mod decide;
mod detector;
pub mod drive;
mod known_answers;
mod logarithm;
pub mod model;
pub mod plan;
mod printable;
mod reason;
mod regression;
mod report;
pub mod shaft;
mod signal;
#[cfg(feature = "signature")]
pub mod signature;
#[cfg(feature = "embedded-storage")]
pub mod storage;
#[cfg(feature = "telemetry")]
pub mod telemetry;
#[cfg(test)]
mod tests;
mod unroll;
#[cfg(all(feature = "watch", target_has_atomic = "8"))]
pub mod watch;
mod watch_static;

pub use alarm::evidence::{Alarm, Cause, Evidence};
pub use decide::Decision;
pub use detector::{Conclusion, Detector, Exchange, Monitor, Segment};
pub use known_answers::{arithmetic_test, known_answer_test};
pub use model::{Model, ModelError};
pub use reason::{FrictionTerm, Implausible, Kernel, Obstacle, Part, Reason};
pub use regression::estimate::Estimate;
pub use report::{Report, Verdict};
pub use signal::{Angle, Average, ChannelSet, Counts, CountsPerTurn, Liveness, LivenessLimits, Park, RateCheck, Stage};

#[cfg(feature = "defmt")]
#[doc(hidden)]
pub use defmt;

/// Parts of the detector, for the tests and measurements of this repository; not stable.
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals {
    pub use crate::decide::{Classification, MAX_SURPRISE};
    pub use crate::detector::{Solver, conclude};
    pub use crate::regression::estimate::{Alone, Detached, Estimator, RegressionSolve, RegressionSums, is_stable};
    pub use crate::regression::factor::{
        Mass, NEVER, PRIOR, Problem, Row, Solution, SolveError, Solved, Sums, Triangle,
    };
    pub use crate::regression::{Inputs, Rows};
    pub use crate::shaft::orders::{LAGS, MIN_BLOCKS};
    pub use crate::shaft::solve::ShaftSolve;
    pub use crate::shaft::state::{BRIDGE, Shaft, ShaftSums};
    pub use crate::signal::Gate;
}
