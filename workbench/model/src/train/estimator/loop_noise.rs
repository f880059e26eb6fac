//! Inertia and lag of the current of a drive whose load is not measured, by the noise of its velocity in the loop.
//!
//! ```text
//! c_x(l) = Σ_k z(k) x(k+l),   z: the measured velocity, all signals behind a high-pass                     (1)
//! c_i(l) = Σ_q f(q) c_a(l−q),   q = −1 … 2,   l = 1 … 16, by least squares                              (2)
//! J/Kt = Σ_q f(q),   lag = Σ_q q f(q)/Σ_q f(q),                                                       (3)
//! of ī(k) = (i(k) + i(k−1))/2 and a(k) = (ω(k) − ω(k−1))/Ts, ω(k) = (θ(k) − θ(k−1))/Ts                    (4)
//! ```
//!
//! The controller answers the noise of the measured velocity with current, which moves the shaft; at frequencies above
//! those of motion and load little else does so. The noise of a sample is not related to a load that comes later, so
//! that it is an instrument (Söderström and Stoica, §3) where the reference tells nothing: a sine that moves an axis
//! with a weight needs the same current for its inertia as for the weight. The f(q) are the filter and the delay of the
//! measured current; (4) both lag half a sample behind the angle. (3) is taken if its median over the records is
//! known: a drive whose velocity has no noise has other values in each.

use bearing_watch::model::{MAX_LAG, TorqueBalance};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::nominal::median;
use super::velocity_source::{VelocitySource, velocity_noise};
use crate::trace::{MotionTrace, bridged};

/// Corner of the high-pass, Hz.
const CORNER_HZ: f64 = 10.0;
/// q and l of (2).
const TAPS: std::ops::Range<i64> = -1..3;
const LAGS: std::ops::Range<i64> = 1..17;
/// Largest relative deviation of the median of (3).
const AGREE: f64 = 0.1;
/// The least lag of (3), samples: that of a current that is as early as the angle.
const EARLIEST: f64 = -0.5;
/// The least noise of the measured velocity, in parts of that of the differences of the angle: the velocity is then not
/// made of the same angle.
const NOISIER: f64 = 2.0;
/// Fewest records.
const FEWEST: usize = 5;

/// What the noise of the loop tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LoopNoise {
    /// J/Kt, A·s²/rad, and its spread between records.
    pub inertia: f64,
    pub spread: f64,
    /// Samples by which the current lags behind the angle.
    pub current_lag: f64,
}

impl LoopNoise {
    /// The medians of (3) over records, if these agree.
    pub(crate) fn of(records: &[&MotionTrace], interval_s: f64) -> Option<Self> {
        let by_angle: Vec<_> = records.iter().map(|own| VelocitySource::Angle.motion(own, interval_s)).collect();
        // Noise that the angle has too would be in a(k) itself.
        if velocity_noise(records) < NOISIER * velocity_noise(&by_angle.iter().map(AsRef::as_ref).collect::<Vec<_>>()) {
            return None;
        }
        let all: Vec<(f64, f64)> = records.par_iter().filter_map(|own| of_record(own, interval_s)).collect();
        if all.len() < FEWEST || 2 * all.len() < records.len() {
            return None;
        }
        let inertia = median(all.iter().map(|own| own.0).collect());
        let spread = 1.483 * median(all.iter().map(|own| (own.0 - inertia).abs()).collect());
        let lag = median(all.iter().map(|own| own.1).collect());
        // The median of n normal numbers has 1.25 times the deviation of their mean. A current that leads answers a
        // load that fluctuates.
        let agree = lag > EARLIEST && inertia > 0.0 && 1.25 * spread < AGREE * inertia * (all.len() as f64).sqrt();
        agree.then(|| Self { inertia, spread, current_lag: (0.5 + lag).clamp(0.0, MAX_LAG.into()) })
    }

    /// Holds the inertia of the balance.
    pub(crate) fn hold(self, balance: &mut TorqueBalance) {
        balance.nominal[0] = self.inertia as f32;
        balance.prior[0] = self.spread.max(0.02 * self.inertia) as f32;
    }
}

/// (3); `None` of a record that does not tell it.
fn of_record(record: &MotionTrace, interval_s: f64) -> Option<(f64, f64)> {
    let pole = (-std::f64::consts::TAU * CORNER_HZ * interval_s).exp();
    let once = |signal: Vec<f64>| {
        let (mut last, mut state) = (signal.first().copied().unwrap_or(0.0), 0.0);
        let step = |now: f64| {
            state = pole * (state + now - last);
            last = now;
            state
        };
        signal.into_iter().map(step).collect::<Vec<f64>>()
    };
    // Twice: a weight of amperes is to be less than the noise.
    let high = |signal: Vec<f64>| once(once(signal));
    let velocity = bridged(&VelocitySource::Angle.motion(record, interval_s).velocity_rad_s);
    // The first two velocities of the angle are the same.
    let changes = velocity.windows(2).map(|own| (own[1] - own[0]) / interval_s);
    let change = high(std::iter::once(0.0).chain(changes).collect());
    let noise = high(bridged(&record.velocity_rad_s));
    let current = bridged(&record.current_a);
    let means = current.windows(2).map(|own| 0.5 * (own[0] + own[1]));
    let current = high(current.iter().take(1).copied().chain(means).collect());
    let product = |signal: &[f64], lag: i64| -> f64 {
        let (early, late) = if lag >= 0 { (0, lag) } else { (-lag, 0) };
        let later = signal.get(late as usize..).unwrap_or_default();
        noise.get(early as usize..).unwrap_or_default().iter().zip(later).map(|(z, x)| z * x).sum()
    };
    let lags: Vec<i64> = LAGS.collect();
    let taps: Vec<i64> = TAPS.collect();
    let of_change = DMatrix::from_fn(lags.len(), taps.len(), |row, tap| product(&change, lags[row] - taps[tap]));
    let of_current = DVector::from_fn(lags.len(), |row, _| product(&current, lags[row]));
    let solved = of_change.svd(true, true).solve(&of_current, 1e-12).ok()?;
    let (sum, moment) = (solved.sum(), taps.iter().zip(solved.iter()).map(|(tap, own)| *tap as f64 * own).sum::<f64>());
    Some((sum, moment / sum)).filter(|(sum, lag)| (sum + lag).is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::estimator::motion_of;
    use rig::{Condition, Scenario, simulate};

    fn records(condition: &Condition, noise: bool) -> Vec<MotionTrace> {
        let record = |seed| {
            let mut scenario = condition.apply(Scenario::WITH_RESOLVER, seed);
            if !noise {
                scenario.velocity_noise_rad_s = 0.0;
            }
            motion_of(simulate(&scenario, seed).expect("valid"))
        };
        (700..720).map(record).collect()
    }

    #[test]
    fn the_noise_of_the_loop_tells_inertia_and_lag_whatever_moves_the_axis() {
        for condition in Condition::AXES {
            let records = records(&condition, true);
            let found = LoopNoise::of(&records.iter().collect::<Vec<_>>(), 0.002).expect("noise in the loop");
            println!("{}: {found:?}", condition.name);
            let LoopNoise { inertia, spread, current_lag } = found;
            // 0.005 A·s²/rad, ± 3 % from record to record; the current's filter of 140 Hz is late by 0.8 samples.
            assert!((inertia / 0.005 - 1.0).abs() < 0.1 && spread < 6e-4, "{}: {inertia} ± {spread}", condition.name);
            assert!((current_lag - 0.8).abs() < 0.2, "{}: {current_lag}", condition.name);
        }
    }

    #[test]
    fn without_noise_or_with_a_load_that_fluctuates_nothing_is_told() {
        let none = |records: &[MotionTrace]| LoopNoise::of(&records.iter().collect::<Vec<_>>(), 0.002).is_none();
        assert!(none(&records(&Condition::AXES[3], false)));
        let without_sensor =
            Condition::FIELD.into_iter().find(|own| own.name == "no-load-sensor").expect("a condition");
        assert!(none(&records(&without_sensor, true)));
        // A velocity that is made of the angle has its noise, which is no motion.
        let mut derived = records(&Condition::AXES[0], true);
        for own in &mut derived {
            own.velocity_rad_s = VelocitySource::Angle.motion(own, 0.002).velocity_rad_s.clone();
        }
        assert!(none(&derived));
    }
}
