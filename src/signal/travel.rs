//! The velocity against the angle: is the integral of one the motion of the other?
//!
//! ```text
//! block: samples until the angle has moved by 1/8 turn;   x = Δθ,   y = Σ ω Ts          (1)
//! ratio = Σ y sgn x / Σ |x|                                                             (2)
//! ```
//!
//! The ratio is 1 if rate, unit and sign of the velocity are right. Blocks of 1/8 turn make steps of the angle's
//! converter and noise of the velocity small. A block that took so long that an offset of the velocity would show in
//! (2) is left out, and so is one with a missing sample. Lags cancel: half of a motion accelerates, half decelerates.

use super::angle::RAD;

/// Motion that closes a block, counts of 2⁻³² turn.
const BLOCK: u32 = 1 << 29;
/// Motion over all blocks that a ratio needs: one turn.
const LEAST_RAD: f32 = core::f32::consts::TAU;

/// The sums of (2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TravelSums {
    /// Σ |x|, rad.
    path_rad: f32,
    /// Σ y sgn x, in rad/s times samples.
    along: f32,
}

impl TravelSums {
    /// The ratio (2); `None` without enough motion.
    #[must_use]
    pub fn ratio(&self, interval_s: f32) -> Option<f32> {
        (self.path_rad >= LEAST_RAD).then(|| self.along * interval_s / self.path_rad)
    }
}

/// The open block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Travel {
    /// x so far, counts of 2⁻³² turn.
    turned: i32,
    /// Σ ω so far.
    velocities: f32,
    samples: u32,
}

impl Travel {
    /// Takes the motion of the angle since the last sample, counts of 2⁻³² turn, and the velocity, rad/s; returns
    /// whether [`Travel::close`] must be called.
    #[inline(always)]
    pub fn step(&mut self, turned: i32, velocity_rad_s: f32) -> bool {
        self.turned = self.turned.saturating_add(turned);
        self.velocities += velocity_rad_s;
        self.samples = self.samples.saturating_add(1);
        self.turned.unsigned_abs() >= BLOCK
    }

    /// Closes the block; it counts if on average it moved by at least `slowest_rad` a sample.
    #[cold]
    #[inline(never)]
    pub fn close(&mut self, sums: &mut TravelSums, slowest_rad: f32) {
        let path_rad = self.turned.unsigned_abs() as f32 * RAD;
        if path_rad >= slowest_rad * self.samples as f32 {
            sums.path_rad += path_rad;
            sums.along += if self.turned < 0 { -self.velocities } else { self.velocities };
        }
        self.restart();
    }

    /// Starts a block: the samples so far are left out.
    #[inline(always)]
    pub const fn restart(&mut self) {
        (self.turned, self.velocities, self.samples) = (0, 0.0, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVAL_S: f32 = 0.001;

    /// The ratio of `samples` at ± 50 rad/s, whose velocity is measured as `scale` times itself.
    fn ratio(samples: u32, scale: f32, slowest_rad: f32) -> Option<f32> {
        let (mut travel, mut sums) = (Travel::default(), TravelSums::default());
        for k in 0..samples {
            let velocity = if (k / 500) % 2 == 0 { 50.0 } else { -50.0 };
            if travel.step((velocity * INTERVAL_S / RAD) as i32, scale * velocity) {
                travel.close(&mut sums, slowest_rad);
            }
        }
        sums.ratio(INTERVAL_S)
    }

    #[test]
    fn the_ratio_is_that_of_the_scale() {
        for scale in [1.0, -1.0, 0.5, 2.0, 9.549_3] {
            let estimated = ratio(4000, scale, 0.0).unwrap();
            // A block that spans a reversal adds a lag's worth: none here; rounding of sixteen sums.
            assert!((estimated / scale - 1.0).abs() < 1e-5, "{scale}: {estimated}");
        }
    }

    #[test]
    fn without_motion_or_below_the_slowest_speed_there_is_no_ratio() {
        // 0.05 rad a sample: a turn is 126 samples.
        assert_eq!((ratio(100, 1.0, 0.0), ratio(4000, 1.0, 0.051)), (None, None));
        assert!(ratio(4000, 1.0, 0.049).is_some());
    }

    #[test]
    fn a_restart_leaves_the_block_out() {
        let (mut travel, mut sums) = (Travel::default(), TravelSums::default());
        // Half of a block whose velocity is nonsense.
        assert!(!travel.step(1 << 28, 1e9));
        travel.restart();
        for _ in 0..40 {
            if travel.step(1 << 28, core::f32::consts::TAU / 16.0) {
                travel.close(&mut sums, 0.0);
            }
        }
        assert!((sums.ratio(1.0).unwrap() - 1.0).abs() < 1e-6);
        assert_eq!(TravelSums::default().ratio(1.0), None);
    }
}
