//! The nominal parameters of the torque balance, and how much they vary, from healthy traces.
//!
//! ```text
//! nominal    median p over the traces that determine it, estimated by the core                            (1)
//! prior      three times the deviation of p over these traces; for terms on which a defect has no effect, 1.5
//!            times what of it the deviations of the estimates do not explain                           (2)
//! ```
//!
//! Without a load sensor the estimates of the core are biased: [`super::reference_instruments`] then corrects them.
//!
//! And the largest change of the angle's motion from one sample to the next, beyond which rows are lost.
//!
//! ```text
//! c = 2 max(q, I Ts²/(J/Kt))                                                                             (3)
//! ```
//!
//! q is the magnitude of θ(k+1) − 2 θ(k) + θ(k−1) that 2 of 1000 samples of training exceed, so that a few lost rows in
//! a recording do not make it larger: it has the steps of the sensor, its noise and the jitter of the rows. I is the
//! largest current of training, which may accelerate the shaft more than q at a few instants.

use std::f64::consts::{PI, TAU};

use bearing_watch::FrictionTerm;
use bearing_watch::model::TorqueBalance;
use bearing_watch::shaft::Friction;

use crate::trace::{self, MotionTrace};

/// Terms on which a defect of a bearing has no effect: their spread over healthy traces is that over all traces.
const SPARED: [FrictionTerm; 3] = [FrictionTerm::Offset, FrictionTerm::LoadFriction, FrictionTerm::Stribeck];

/// Sets nominal parameters (1), their prior deviations (2), and the deviation of a row.
pub(crate) fn learn(balance: &mut TorqueBalance, estimates: &[Friction]) {
    for (term, (nominal, prior)) in
        FrictionTerm::ALL.into_iter().zip(balance.nominal.iter_mut().zip(&mut balance.prior))
    {
        let all: Vec<(f64, f64)> = estimates
            .iter()
            .filter_map(|friction| friction.parameter(term))
            .map(|own| (f64::from(own.value), f64::from(own.deviation)))
            .collect();
        let (usual, determined) = (usual(&all), determined(&all));
        if determined.is_empty() {
            continue;
        }
        let middle = median(determined.clone());
        let spread = 1.483 * median(determined.iter().map(|value| (value - middle).abs()).collect());
        *nominal = middle as f32;
        let width = if SPARED.contains(&term) {
            let own = (spread * spread - usual * usual).max(0.0).sqrt();
            (1.5 * own).max(0.25 * usual)
        } else {
            (3.0 * spread).max(usual)
        };
        *prior = width.max(0.01 * middle.abs()).max(1e-9) as f32;
    }
    let variance = median(estimates.iter().map(|friction| f64::from(friction.variance)).collect());
    balance.deviation = variance.sqrt().max(1e-6) as f32;
}

/// The values whose deviation is at most twice the usual one.
fn determined(all: &[(f64, f64)]) -> Vec<f64> {
    let usual = usual(all);
    all.iter().filter(|(_, own)| *own <= 2.0 * usual).map(|(value, _)| *value).collect()
}

/// The median deviation of values.
fn usual(all: &[(f64, f64)]) -> f64 {
    median(all.iter().map(|(_, deviation)| *deviation).collect())
}

/// The median; zero of nothing.
pub(crate) fn median(values: Vec<f64>) -> f64 {
    if values.is_empty() { 0.0 } else { trace::median(values) }
}

/// Part of the samples that may exceed q.
const ABOVE: f64 = 0.002;
/// The factor of (3).
const MARGIN: f64 = 2.0;
/// Smaller than any step of a sensor, rad.
const LEAST_RAD: f64 = 1e-7;

/// Returns (3), rad; without a positive inertia J/Kt by the largest change instead of q.
pub(crate) fn of(traces: &[&MotionTrace], interval_s: f64, inertia: f32) -> f32 {
    let wrapped = |angle: f64| (angle + PI).rem_euclid(TAU) - PI;
    let each = |w: &[f64]| wrapped(wrapped(w[2] - w[1]) - wrapped(w[1] - w[0])).abs();
    let all = traces.iter().flat_map(|trace| trace.angle_rad.windows(3).map(each));
    let mut changes: Vec<f64> = all.filter(|change| change.is_finite()).collect();
    let Some(last) = changes.len().checked_sub(1) else { return f32::INFINITY };
    let physical = if inertia > 0.0 {
        let currents = traces.iter().flat_map(|trace| &trace.current_a).filter(|current| current.is_finite());
        let largest = currents.fold(0.0_f64, |most, current| most.max(current.abs()));
        largest * interval_s * interval_s / f64::from(inertia)
    } else {
        changes.iter().copied().fold(0.0, f64::max)
    };
    let place = last - (ABOVE * changes.len() as f64) as usize;
    let (_, quantile, _) = changes.select_nth_unstable_by(place, f64::total_cmp);
    (MARGIN * quantile.max(physical).max(LEAST_RAD)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lost_rows_of_training_do_not_raise_it_and_the_largest_current_does() {
        // ±40 rad/s in a second, 2 ms a row: 0.5 rad/s a row at most, and a sensor of 14 bits.
        let angle = |k: f64| 40.0 / TAU * -(TAU * k * 0.002).cos();
        let step = TAU / 16_384.0;
        let motion = |lost: &[usize]| {
            let rows = (0..5000).filter(|k| !lost.contains(k)).map(|k| angle(k as f64));
            let angle_rad: Vec<f64> = rows.map(|angle| (angle / step).floor() * step).collect();
            MotionTrace { current_a: vec![-2.0; angle_rad.len()], angle_rad, ..MotionTrace::default() }
        };
        let (whole, lost) = (motion(&[]), motion(&[700, 1234, 4210]));
        // 40 rad/s · 2π/s · Ts² and up to two steps of the sensor, twice.
        let expected = 2.0 * (40.0 * TAU * 4e-6 + step);
        let [one, other] = [&whole, &lost].map(|own| f64::from(of(&[own], 0.002, 1.0)));
        assert!((one / expected - 1.0).abs() < 0.3 && (other / one - 1.0).abs() < 0.1, "{one} {other} {expected}");
        assert!((of(&[&whole], 0.002, 1e-3) / 0.016 - 1.0).abs() < 1e-6, "2 · 2 A · Ts²/(J/Kt)");
        // Row 700 is lost at 40 sin(2π 1.4) = 23.5 rad/s, a change of 0.047 rad.
        assert!((of(&[&lost], 0.002, 0.0) / 0.094 - 1.0).abs() < 0.03);
        assert_eq!(of(&[], 0.002, 1.0), f32::INFINITY);
    }
}
