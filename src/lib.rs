//! Bearing-fault detection next to the current loop, from signals that a motor drive already has.
//!
//! ```
//! // `bearing-watch train … --front-end front_end.toml --rust model.rs` writes this module.
//! # mod model { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/support/actuator/model.rs")); }
//! use model::{FRONT_END, MODEL, Reading, WATCH};
//! use bearing_watch::watch::StartError;
//!
//! /// At boot: checks model, constants and processor; a wrong one is an error with its reason.
//! pub fn start() -> Result<(), StartError> {
//!     WATCH.start(&MODEL, &FRONT_END)
//! }
//!
//! /// In the interrupt of the current loop, with raw counts by name; returns whether to request the interrupt below it.
//! pub fn current_loop(reading: Reading) -> bool {
//!     WATCH.sample(reading)
//! }
//!
//! /// In an interrupt below the current loop, once a clean sample: the detector.
//! pub fn below() {
//!     WATCH.collect();
//! }
//!
//! /// In the main loop: verdict and alarm, once in a few seconds.
//! pub fn main_loop() -> Option<bool> {
//!     WATCH.advance(|now| now.alarm.is_some())
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
//! watch       front end, detector and monitor as one static, for interrupts and main loop
//! storage     records in flash that survive power-off
//! telemetry   reports and samples as frames for a serial line, and their decoder; reports as frames for CAN
//! signature   signed models, and saved states under a key of the drive
//! ```
//!
//! A [`Model`] holds trained constants (flash). A [`watch::Watch`] holds the rest: front end, [`Detector`] and
//! [`Monitor`]. All take one type parameter, the plan ([`plan!`]). The crate is `no_std`, allocates nothing (but for
//! the host's feature `alloc`), contains no `unsafe`, and uses no fused multiply-add: the same samples give the same
//! bits on a host and on a Cortex-M4F. A bad sample is counted and skipped; no function panics.
//!
//! Features: `watch` ([`watch::Watch`]; on by default), `defmt` (formats, and a log line for each segment),
//! `embedded-hal` (the driver `ad2s1210`), `embedded-storage` (records in flash), `telemetry` (frames for a serial line
//! or CAN, these also by the traits of a driver), `signature` (signed models, sealed states), `alloc` (the plan
//! `RunTime` of host programs), `bounded` (array lengths that a model brings, without an allocator, as the C interface
//! needs them).
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
pub use reason::{ArithmeticFault, FrictionTerm, Implausible, Obstacle, Part, Reason};
pub use regression::estimate::Estimate;
pub use report::{Report, Verdict};
pub use signal::{Angle, Average, ChannelSet, Counts, EncoderCounts, Liveness, LivenessLimits, Park, RateCheck, Stage};

#[cfg(feature = "defmt")]
#[doc(hidden)]
pub use defmt;

/// Recursive estimation alone, for programs that want the parameters of a model of their signals and no verdict: least
/// squares and instruments with forgetting, as the detector has them.
pub mod recursive {
    pub use crate::regression::estimate::{ClosedSegment, RecursiveEstimator, is_stable};
    pub use crate::regression::factor::Triangle;
}
