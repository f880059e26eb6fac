//! From signals of the drive to filtered samples.
//!
//! [`FrontEnd`] is the interface: stator currents and shaft angle in, direct and quadrature current out.

pub mod angle;
pub mod decimate;
pub mod frame;

pub use angle::{Angle, SinCos};
pub use decimate::{BlockMean, FirDecimator, HalfBandDecimator, HalfBandTaps};
pub use frame::{Abc, AlphaBeta, Dq0, Park};

/// Stator currents and mechanical shaft angle → currents in the rotor frame.
///
/// The electrical angle is `pole_pairs · shaft + electrical_offset`, in wrapping integers, so it accumulates no error
/// over time. An integrated velocity would: the transform is very sensitive to errors of the angle (thesis Fig. 5.35).
///
/// ```
/// use bearing_watch::{Abc, AlphaBeta, Angle, FrontEnd, Park};
/// let front = FrontEnd { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard };
/// // A current vector 90° (electrical) ahead of the magnet axis is pure quadrature current.
/// let dq = front.transform(AlphaBeta::from_two(0.0, 8.660_254), Angle::ZERO); // two current sensors
/// assert!((dq.q - 10.0).abs() < 1e-5 && dq.d.abs() < 1e-5);
/// let three = Abc { a: 0.0, b: 8.660_254, c: -8.660_254 };
/// assert!((front.transform(three.clarke(), Angle::ZERO).q - 10.0).abs() < 1e-5); // three of them
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrontEnd {
    /// Pole pairs of the motor (electrical turns per mechanical turn).
    pub pole_pairs: u32,
    /// Electrical angle of the magnet axis when the shaft angle is zero.
    pub electrical_offset: Angle,
    /// Sign convention of the quadrature axis.
    pub park: Park,
}

impl FrontEnd {
    /// Transforms the stator currents sampled at shaft angle `shaft`, which must increase in the direction of the phase
    /// sequence (otherwise use [`Angle::negated`]).
    #[inline]
    #[must_use]
    pub fn transform(&self, currents: AlphaBeta, shaft: Angle) -> Dq0 {
        let electrical = shaft.times(self.pole_pairs).plus(self.electrical_offset);
        self.park.forward(currents, electrical.sin_cos())
    }
}
