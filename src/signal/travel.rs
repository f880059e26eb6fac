//! The velocity against the angle: is the integral of one the motion of the other?
//!
//! ```text
//! block: samples until the angle has moved by 1/8 turn;   x = |Δθ|,   y = Σ ω Ts sgn Δθ                 (1)
//! ratio:      r = Σ y / Σ x                                                                             (2)
//! deviation:  s² = (Σ y²/x / Σ x − r²)/n,   n = Σ x / (1/8 turn)                                        (3)
//! stands:     Σ |Σ ω Ts| of blocks that end by |Σ ω Ts| ≥ 1/2 turn with x < 1/64 of it, at least a turn (4)
//! ```
//!
//! The ratio is 1 if rate, unit and sign of the velocity are right. Blocks of 1/8 turn make steps of the angle's
//! converter and noise of the velocity small. A block that took so long that an offset of the velocity would show in
//! (2) is left out, and so is one with a missing sample. Lags cancel: half of a motion accelerates, half decelerates;
//! what they do to a block is in (3). An angle that stands while the velocity turns (4) is that of a stuck sensor.

use core::f32::consts::{FRAC_PI_4, PI, TAU};

use super::angle::RAD;

/// Motion that closes a block, counts of 2⁻³² turn.
const BLOCK: u32 = 1 << 29;
/// Motion over all blocks that a ratio needs: one turn.
const LEAST_RAD: f32 = TAU;
/// Motion by the velocity over that by the angle from which on the angle stands.
const STANDS: f32 = 64.0;

/// The sums of (2) to (4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TravelSums {
    /// Σ x, rad.
    path_rad: f32,
    /// Σ y, in rad/s times samples.
    along: f32,
    /// Σ y²/x, in the square of this, for each rad.
    squares: f32,
    /// (4), rad.
    stood_rad: f32,
}

impl TravelSums {
    /// The ratio (2); `None` without enough motion.
    #[must_use]
    pub fn ratio(&self, interval_s: f32) -> Option<f32> {
        (self.path_rad >= LEAST_RAD).then(|| self.along * interval_s / self.path_rad)
    }

    /// The standard deviation (3) of the ratio; not a number without motion.
    #[must_use]
    pub fn deviation(&self, interval_s: f32) -> f32 {
        let ratio = self.along * interval_s / self.path_rad;
        let spread = self.squares * interval_s * interval_s / self.path_rad - ratio * ratio;
        libm::sqrtf(spread.max(0.0) * FRAC_PI_4 / self.path_rad)
    }

    /// Whether the angle stood while the velocity turned (4).
    #[must_use]
    pub const fn stands(&self) -> bool {
        self.stood_rad >= LEAST_RAD
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

    /// As [`Travel::step`], and a block also ends if the velocity alone has turned by half a turn; then
    /// [`Travel::close_any`] must be called.
    #[inline(always)]
    pub fn step_or_stand(&mut self, turned: i32, velocity_rad_s: f32, interval_s: f32) -> bool {
        self.step(turned, velocity_rad_s) || (self.velocities * interval_s).abs() >= PI
    }

    /// Closes a block of [`Travel::step_or_stand`], in which the angle may have stood.
    #[cold]
    #[inline(never)]
    pub fn close_any(&mut self, sums: &mut TravelSums, slowest_rad: f32, interval_s: f32) {
        let (path_rad, way_rad) = (self.turned.unsigned_abs() as f32 * RAD, (self.velocities * interval_s).abs());
        if way_rad <= STANDS * path_rad {
            self.close(sums, slowest_rad);
            return;
        }
        if way_rad >= slowest_rad * self.samples as f32 {
            sums.stood_rad += way_rad;
        }
        self.restart();
    }

    /// Closes the block; it counts if on average it moved by at least `slowest_rad` a sample.
    #[cold]
    #[inline(never)]
    pub fn close(&mut self, sums: &mut TravelSums, slowest_rad: f32) {
        let path_rad = self.turned.unsigned_abs() as f32 * RAD;
        if path_rad >= slowest_rad * self.samples as f32 {
            sums.path_rad += path_rad;
            sums.along += if self.turned < 0 { -self.velocities } else { self.velocities };
            sums.squares += self.velocities * self.velocities / path_rad;
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

    /// The sums of `samples` at ± 50 rad/s, the velocity of sample k as measured.
    fn sums(samples: u32, slowest_rad: f32, measured: impl Fn(u32, f32) -> (f32, f32)) -> TravelSums {
        let (mut travel, mut sums) = (Travel::default(), TravelSums::default());
        for k in 0..samples {
            let velocity = if (k / 500) % 2 == 0 { 50.0 } else { -50.0 };
            let (turns_by, velocity) = measured(k, velocity);
            if travel.step_or_stand((turns_by * INTERVAL_S / RAD) as i32, velocity, INTERVAL_S) {
                travel.close_any(&mut sums, slowest_rad, INTERVAL_S);
            }
        }
        sums
    }

    /// The ratio of a velocity that is measured as `scale` times itself.
    fn ratio(samples: u32, scale: f32, slowest_rad: f32) -> Option<f32> {
        sums(samples, slowest_rad, |_, velocity| (velocity, scale * velocity)).ratio(INTERVAL_S)
    }

    #[test]
    fn the_deviation_is_that_of_the_blocks() {
        let exact = sums(4000, 0.0, |_, velocity| (velocity, 0.8 * velocity));
        // Of the rounding of sums of 250 blocks.
        assert!(exact.deviation(INTERVAL_S) < 1e-3, "{}", exact.deviation(INTERVAL_S));
        // Blocks of 16 samples, 1/8 turn, with a velocity 20 % too high or too low in turn: 0.2/√n of n = 254 blocks.
        let scattered = |k: u32, _: f32| (50.0, if (k / 16).is_multiple_of(2) { 60.0 } else { 40.0 });
        let deviation = sums(4000, 0.0, scattered).deviation(INTERVAL_S);
        assert!((deviation * 254.0_f32.sqrt() / 0.2 - 1.0).abs() < 0.02, "{deviation}");
        assert!(TravelSums::default().deviation(INTERVAL_S).is_nan());
    }

    #[test]
    fn an_angle_stands_if_the_velocity_turns_and_it_does_not() {
        let stuck_from = |row: u32| move |k: u32, velocity: f32| (if k < row { velocity } else { 0.0 }, velocity);
        // A turn is 126 samples.
        assert!(sums(4000, 0.0, stuck_from(0)).stands() && sums(4000, 0.0, stuck_from(3500)).stands());
        assert!(!sums(4000, 0.0, stuck_from(3900)).stands(), "less than a turn");
        assert!(!sums(4000, 0.051, stuck_from(0)).stands(), "slower than the slowest: an offset of the velocity");
        assert!(!sums(4000, 0.0, |_, velocity| (velocity, 9.55 * velocity)).stands(), "another unit");
        assert!(!sums(4000, 0.0, |_, _| (0.0, 0.0)).stands() && !sums(4000, 0.0, |_, v| (v, 0.0)).stands());
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
        assert_eq!(travel, Travel::default());
        for _ in 0..40 {
            if travel.step(1 << 28, core::f32::consts::TAU / 16.0) {
                travel.close(&mut sums, 0.0);
            }
        }
        assert!((sums.ratio(1.0).unwrap() - 1.0).abs() < 1e-6);
        assert_eq!(TravelSums::default().ratio(1.0), None);
    }
}
