//! Bearing-fault detection beside the current loop, from signals a motor drive already has.
//!
//! ```text
//! drive      phase currents, shaft angle ─► Clarke, Park ─► quadrature current, block means
//!               │ y (current)   u1 (velocity, its reference, or their difference)   u2 (load, or another input)
//! estimate      ▼
//!            δ-form regressor ─► square-root-free triangle ─► Estimate: parameters, covariance, σ²
//!            Motion ─► torque balance ─► Friction;   its residual ─► order tracking ─► OrderStrength
//! decide        ▼
//!            features ─► projection ─► discriminant, novelty ─► Decision: posteriors, class, distance from healthy
//!               │ one a segment
//!               ▼
//!            evidence ─► Alarm, trend
//! ```
//!
//! A [`Model`] holds trained constants (flash), a [`Detector`] holds running state (RAM). Call
//! [`Detector::step`] once a sample; once a segment it hands back a [`Report`]. A model that watches the shaft takes its
//! [`Motion`] beside the sample ([`Detector::step_with_motion`]); [`Evidence`] gathers decisions into an alarm.
//!
//! The crate is `no_std`, allocates nothing, holds no `unsafe`, and uses no fused multiply-add: the same samples
//! give the same bits on a host and on a Cortex-M4F. A bad sample is a value (counted, skipped), never a panic.
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

#[cfg(test)]
extern crate std;

pub mod decide;
pub mod detector;
pub mod drive;
pub mod estimate;
pub mod model;

pub use decide::{Alarm, Classifier, Decision, Evidence, EvidencePlan};
pub use detector::{Detector, Report, Sample, Verdict};
pub use drive::{Abc, AlphaBeta, Angle, BlockMean, Dq0, FirDecimator, FrontEnd, HalfBandDecimator, HalfBandTaps};
pub use drive::{Park, SinCos};
pub use estimate::{Bearing, Friction, Motion, NoShaft, OrderStrength, Shaft, ShaftEstimate, ShaftModel};
pub use estimate::{Counts, Estimate, Estimator, Guard, Instruments, Order, Reason, Regression, Regressor, Segment};
pub use model::{Label, Model, ModelError, Sampling};
