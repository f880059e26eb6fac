//! The front end, if samples come from raw counts: signals of the drive → filtered samples.
//!
//! Enters: counts of currents and of a resolver, or angles, at the control rate. Leaves: samples for a detector, at the
//! rate of identification. [`FrontEnd`] is the interface; each of its parts can be used by itself. Angles and Park's
//! sign convention are those of the detector: [`Angle`](crate::Angle), [`Park`](crate::Park).
//!
//! ```text
//! current, calibration   counts ─► amperes; offsets at standstill
//! balance                three currents against each other
//! position, resolver, tracking
//!                        sine and cosine, or an angle ─► loop, lock
//! steadiness             stale readings, slips, unequal intervals
//! rotor_frame            electrical angle of the rotor; Clarke, Park
//! wiring                 phases, pole pairs, offset and rate at commissioning
//! decimate               from the control rate to that of identification
//! front_end              ties them
//! ```

#[cfg(feature = "embedded-hal")]
pub mod ad2s1210;
mod balance;
mod calibration;
mod current;
mod decimate;
mod front_end;
mod imbalance;
mod position;
mod resolver;
mod rotor_frame;
mod steadiness;
mod tracking;
mod wiring;

pub use crate::signal::{Abc, AlphaBeta, BlockMean, Dq0, SinCos};
pub use balance::BalanceLimits;
pub use calibration::{CalibrationError, CalibrationLimits, OffsetCalibration};
pub use current::{Phase, PhaseCounts, PhaseFaults, PhaseSensor};
pub use decimate::{By, Factor, FirDecimator, HalfBandDecimator, HalfBandTaps};
pub use front_end::{CleanSample, Faults, FrontEnd, FrontEndConstants, FrontEndError, RawSample};
pub use imbalance::{Alignment, Imbalance};
pub use position::Position;
pub use resolver::{ResolverFaults, ResolverLimits};
pub use rotor_frame::RotorFrame;
pub use tracking::{Lock, PositionFaults, TrackingConstants};
pub use wiring::{Wiring, WiringCheck, WiringFault, WiringLimits};

use balance::CurrentBalance;
use current::CurrentSensors;
use position::Tracked;
use tracking::PositionTracker;
