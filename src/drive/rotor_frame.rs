//! The frame of a motor's rotor.
//!
//! Input: stator currents and mechanical shaft angle. Output: direct and quadrature current.

use crate::signal::{AlphaBeta, Angle, Dq0, Park};

/// Stator currents and mechanical shaft angle → currents in the rotor frame.
///
/// The electrical angle is `pole_pairs · shaft + electrical_offset`, in wrapping integers, so it accumulates no error
/// over time. An integrated velocity would: the transform is very sensitive to errors of the angle (thesis Fig. 5.35).
///
/// ```
/// use bearing_watch::drive::{Abc, AlphaBeta, RotorFrame};
/// use bearing_watch::{Angle, Park};
/// let frame = RotorFrame { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard };
/// // A current vector 90° (electrical) ahead of the magnet axis is pure quadrature current.
/// let dq = frame.transform(AlphaBeta::from_two(0.0, 8.660_254), Angle::ZERO); // two current sensors
/// assert!((dq.q - 10.0).abs() < 1e-5 && dq.d.abs() < 1e-5);
/// let three = Abc { a: 0.0, b: 8.660_254, c: -8.660_254 };
/// assert!((frame.transform(three.clarke(), Angle::ZERO).q - 10.0).abs() < 1e-5); // three of them
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RotorFrame {
    /// Pole pairs of the motor (electrical turns per mechanical turn).
    pub pole_pairs: u32,
    /// Electrical angle of the magnet axis when the shaft angle is zero.
    pub electrical_offset: Angle,
    /// Sign convention of the quadrature axis.
    pub park: Park,
}

impl RotorFrame {
    /// The electrical angle of a shaft angle.
    #[inline]
    #[must_use]
    pub const fn electrical(&self, shaft: Angle) -> Angle {
        shaft.times(self.pole_pairs).plus(self.electrical_offset)
    }

    /// Transforms the stator currents sampled at shaft angle `shaft`, which must increase in the direction of the phase
    /// sequence (otherwise use [`Angle::negated`]).
    #[inline]
    #[must_use]
    pub fn transform(&self, currents: AlphaBeta, shaft: Angle) -> Dq0 {
        self.park.forward(currents, self.electrical(shaft).sin_cos())
    }
}
