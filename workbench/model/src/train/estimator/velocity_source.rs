//! Where the shaft's velocity comes from: its channel, or the differences of the angle.
//!
//! ```text
//! ω(k) = (θ(k) − θ(k−n))/(n Ts),   n − 1 ≤ 8: samples lost before k                                    (1)
//! ```
//!
//! [`super::estimating`] tells which is better.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use bearing_watch::model::BRIDGE;

use super::nominal::median;
use crate::trace::MotionTrace;

/// Source of the velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VelocitySource {
    /// The channel or the angle: that which leaves less noise at the bearing orders of healthy traces; without orders,
    /// or if averages of the channel are features, the channel.
    #[default]
    Best,
    /// The channel.
    Channel,
    /// The angle (1).
    Angle,
}

impl VelocitySource {
    /// Returns the motion with the velocity from this source; before the choice, that of the channel.
    pub(crate) fn motion(self, motion: &MotionTrace, interval_s: f64) -> Cow<'_, MotionTrace> {
        match self {
            Self::Best | Self::Channel => Cow::Borrowed(motion),
            Self::Angle => Cow::Owned(differenced(motion, interval_s)),
        }
    }
}

/// Returns the motion with the velocity (1). A sample of which any signal is missing is lost, as it is for the core.
fn differenced(motion: &MotionTrace, interval_s: f64) -> MotionTrace {
    let MotionTrace { current_a, load_nm, angle_rad, .. } = motion;
    // Sample, angle and velocity.
    let mut last: Option<(usize, f64, f64)> = None;
    let each = |(k, angle): (usize, &f64)| {
        if !(current_a[k].is_finite() && load_nm[k].is_finite() && angle.is_finite()) {
            return f64::NAN;
        }
        // Of a wrapped angle, the step of less than half a turn; over lost samples, the velocity next to the last one.
        let step = |(from, before, held): (usize, f64, f64)| {
            let passed_s = (k - from) as f64 * interval_s;
            let expected = if k - from > 1 && held.is_finite() { held * passed_s } else { 0.0 };
            let velocity = (expected + (angle - before - expected + PI).rem_euclid(TAU) - PI) / passed_s;
            if k - from > 1 + usize::from(BRIDGE) { f64::NAN } else { velocity }
        };
        let velocity = last.map_or(f64::NAN, step);
        last = Some((k, *angle, velocity));
        velocity
    };
    let mut velocity_rad_s: Vec<f64> = angle_rad.iter().enumerate().map(each).collect();
    // The first sample has the velocity of the next one.
    if let [first, second, ..] = &mut velocity_rad_s[..] {
        *first = *second;
    }
    MotionTrace { velocity_rad_s, ..motion.clone() }
}

/// Standard deviation of the velocity's white noise: second differences of white noise have six times its variance.
pub(crate) fn velocity_noise(traces: &[&MotionTrace]) -> f64 {
    let second = |t: &&MotionTrace| {
        let differences = t.velocity_rad_s.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs());
        median(differences.filter(|x| x.is_finite()).collect())
    };
    1.483 * median(traces.iter().map(second).collect()) / 6.0_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rig::{Scenario, simulate};

    fn motion(angle_rad: Vec<f64>) -> MotionTrace {
        let zeros = vec![0.0; angle_rad.len()];
        MotionTrace {
            current_a: zeros.clone(),
            velocity_rad_s: zeros.clone(),
            load_nm: zeros,
            angle_rad,
            ..MotionTrace::default()
        }
    }

    #[test]
    fn wrapped_angles_and_lost_samples_have_the_mean_velocity() {
        // 2 rad a sample, wrapped; the third sample is lost, and 4 rad between two samples are more than half a turn.
        let angles = [0.0, 2.0, f64::NAN, 6.0 - TAU, 8.0 - TAU, 10.0 - TAU];
        let found = differenced(&motion(angles.to_vec()), 0.5).velocity_rad_s;
        let expected = [4.0, 4.0, f64::NAN, 4.0, 4.0, 4.0];
        let near =
            |(found, expected): (&f64, &f64)| (found - expected).abs() < 1e-12 || found.is_nan() && expected.is_nan();
        assert!(found.iter().zip(&expected).all(near), "{found:?}");
        // Over nine lost samples the core has no velocity.
        for (lost, bridged) in [(8, true), (9, false)] {
            let mut angles: Vec<f64> = (0..20).map(|k| f64::from(k) * 0.1).collect();
            angles[5..5 + lost].fill(f64::NAN);
            let after = differenced(&motion(angles), 0.5).velocity_rad_s[5 + lost];
            assert_eq!((after.is_finite(), (after - 0.2).abs() < 1e-9), (bridged, bridged), "{lost}");
        }
    }

    #[test]
    fn the_velocity_of_the_rig_is_that_of_its_angle_half_a_sample_later() {
        let scenario = Scenario { velocity_noise_rad_s: 0.0, samples: 500, ..Scenario::STANDARD };
        let trace = simulate(&scenario, 3).expect("valid");
        let exact = &trace.velocity_rad_s;
        let found = differenced(&motion(trace.angle_rad.clone()), scenario.sample_time_s).velocity_rad_s;
        let rms = |at: fn(f64, f64) -> f64| {
            let squares = (1..500).map(|k| (found[k] - at(exact[k - 1], exact[k])).powi(2));
            (squares.sum::<f64>() / 499.0).sqrt()
        };
        let errors = [rms(|from, to| 0.5 * (from + to)), rms(|from, _| from), rms(|_, to| to)];
        // Loads of 0.06 N·m change the acceleration by 240 rad/s² a sample: a twelfth of that in 2 ms, and at the ends
        // of the interval half a sample of the acceleration.
        assert!(errors[0] < 0.07 && errors[1] > 0.14 && errors[2] > 0.14, "{errors:?}");
    }
}
