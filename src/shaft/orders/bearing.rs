//! Characteristic orders of a rolling bearing: events a shaft turn, the outer ring at rest.
//!
//! ```text
//! γ = (BD/PD) cos δ
//! outer = n/2 (1 − γ),   inner = n/2 (1 + γ),   cage = ½ (1 − γ),   ball = ½ (PD/BD) (1 − γ²)             (1)
//! ```
//!
//! Randall, *Vibration-based Condition Monitoring*, Eq. 2.13–2.16. `ball` is the rotation of a ball about its own axis;
//! a spall on it meets both rings, so that its second harmonic is as strong. A modulation by the shaft causes sidebands
//! at an order ± m; in the stator currents they lie at |p ± m O| with p pole pairs (thesis Eq. 1.1 in orders of the
//! shaft). Track each like any other order.

use crate::signal::Angle;

/// Dimensions of a rolling bearing.
///
/// ```
/// use bearing_watch::shaft::Bearing;
/// let bearing = Bearing { balls: 9, ball_diameter: 3.0, pitch_diameter: 17.0, contact_angle_rad: 0.1745 };
/// assert!((bearing.outer() - 3.71794).abs() < 1e-4);
/// assert!((bearing.outer() + bearing.inner() - 9.0).abs() < 1e-5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bearing {
    /// Rolling elements n.
    pub balls: u8,
    /// Ball diameter BD, in the unit of the pitch diameter.
    pub ball_diameter: f32,
    /// Pitch diameter PD.
    pub pitch_diameter: f32,
    /// Contact angle δ.
    pub contact_angle_rad: f32,
}

impl Bearing {
    fn gamma(&self) -> f32 {
        self.ball_diameter / self.pitch_diameter * Angle::from_radians(self.contact_angle_rad).sin_cos().cos
    }

    /// Order of a defect on the outer ring.
    #[must_use]
    pub fn outer(&self) -> f32 {
        0.5 * f32::from(self.balls) * (1.0 - self.gamma())
    }

    /// Order of a defect on the inner ring.
    #[must_use]
    pub fn inner(&self) -> f32 {
        0.5 * f32::from(self.balls) * (1.0 + self.gamma())
    }

    /// Order of a defect on a ball.
    #[must_use]
    pub fn ball(&self) -> f32 {
        0.5 * self.pitch_diameter / self.ball_diameter * (1.0 - self.gamma() * self.gamma())
    }

    /// Order of the cage.
    #[must_use]
    pub fn cage(&self) -> f32 {
        0.5 * (1.0 - self.gamma())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makers give these orders of a bearing 6205 to three digits: 3.585, 5.415, 2.357 and 0.398.
    #[test]
    fn orders_are_those_of_a_catalogue() {
        let mut bearing = Bearing { balls: 9, ball_diameter: 7.94, pitch_diameter: 39.04, contact_angle_rad: 0.0 };
        let orders = |bearing: &Bearing| [bearing.outer(), bearing.inner(), bearing.ball(), bearing.cage()];
        for (order, expected) in orders(&bearing).into_iter().zip([3.5848, 5.4152, 2.3567, 0.3983]) {
            assert!((order - expected).abs() < 1e-4, "{order} {expected}");
        }
        // By hand: γ = 7.94 / 39.04 · cos 0.5 = 0.178484.
        bearing.contact_angle_rad = 0.5;
        for (order, expected) in orders(&bearing).into_iter().zip([3.6968, 5.3032, 2.3801, 0.4108]) {
            assert!((order - expected).abs() < 1e-4, "{order} {expected}");
        }
    }
}
