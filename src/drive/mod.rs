//! From signals of the drive to filtered samples.
//!
//! [`FrontEnd`] is the interface: raw counts at the control rate in, samples for a detector out. Each of its parts can
//! be used by itself.
//!
//! ```text
//! current, calibration   counts ─► amperes; offsets at standstill
//! balance                three currents against each other
//! resolver, tracking     sine and cosine, or an angle ─► loop, lock
//! angle, frame           binary angles; Clarke, Park ─► rotor_frame
//! travel, wiring         velocity against angle; phases, pole pairs, offset and rate at commissioning
//! decimate               from the control rate to that of identification
//! front_end              ties them
//! ```

#[cfg(feature = "embedded-hal")]
pub mod ad2s1210;
pub mod angle;
pub mod balance;
pub mod calibration;
pub mod current;
pub mod decimate;
pub mod frame;
pub mod front_end;
pub mod resolver;
pub mod rotor_frame;
pub mod tracking;
pub mod travel;
pub mod wiring;

pub use angle::{Angle, SinCos};
pub use balance::{BalanceLimits, CurrentBalance, Imbalance};
pub use calibration::{CalibrationError, CalibrationLimits, OffsetCalibration};
pub use current::{CurrentSensors, Phase, PhaseCounts, PhaseFaults, PhaseSensor};
pub use decimate::{BlockMean, By, Decimate, Factor, FirDecimator, HalfBandDecimator, HalfBandTaps};
pub use frame::{Abc, AlphaBeta, Dq0, Park};
pub use front_end::{CleanSample, Faults, FrontEnd, FrontEndConstants, FrontEndError, RawSample};
pub use resolver::{ResolverFaults, ResolverLimits};
pub use rotor_frame::RotorFrame;
pub use tracking::{Lock, Position, PositionFaults, PositionTracker, Tracked, TrackingConstants};
pub use wiring::{Wiring, WiringCheck, WiringFault, WiringLimits};
