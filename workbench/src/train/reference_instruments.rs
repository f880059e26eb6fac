//! The torque balance of a drive whose load is not measured, by instruments from the velocity reference.
//!
//! ```text
//! i = x p + T/Kt,   x = (ω̇, ω, s(ω), 1, s(ω)/(1 + (ω/ω_s)²))                                           (1)
//! p = (Zᵀ X)⁻¹ Zᵀ i,   z = (ṙ, r, s(r), 1, s(r)/(1 + (r/ω_s)²))                                         (2)
//! Cov p = n σ² (Zᵀ X)⁻¹ Zᵀ Z (Xᵀ Z)⁻¹,   n: rows per independent row                                   (3)
//! ```
//!
//! The controller answers a load with current, and the load moves the shaft: velocity and load depend on each other, and
//! least squares on (1) gives wrong parameters, the inertia of the simulated rig more than twice too large. The
//! reference r does not depend on the load, so instruments (2) are not biased (Söderström and Stoica, *Instrumental
//! Variable Methods for System Identification*, §3). All signals pass the filter of the core's torque balance.

use bearing_watch::model::{Balance, TERMS};
use nalgebra::{DMatrix, DVector};

use crate::grey_box::filter::LowPass;
use crate::trace::{MotionTrace, bridged};

/// The parameters of (1) among all terms of the balance.
const OWN: [usize; 5] = [0, 1, 2, 4, 6];

/// Value and deviation of each term of the balance; `None` for those of the load.
pub(super) type Estimate = [Option<(f64, f64)>; TERMS];

/// Returns (2) with the deviations of (3); `None` if the trace has no reference, or one that does not move the shaft.
pub(super) fn estimate(motion: &MotionTrace, balance: &Balance, cutoff_hz: f64) -> Option<Estimate> {
    let interval_s = f64::from(balance.interval_s);
    let filter = LowPass::butterworth(1, cutoff_hz * interval_s);
    let columns = |velocity: &[f64]| {
        let term = |each: fn(&Balance, f64) -> f64| {
            filter.forward(&velocity.iter().map(|w| each(balance, *w)).collect::<Vec<_>>())
        };
        let slope = filter.derivative(velocity).into_iter().map(|x| x / interval_s).collect();
        [slope, term(|_, w| w), term(sign), vec![1.0; velocity.len()], term(stribeck)]
    };
    if motion.reference_rad_s.is_empty() {
        return None;
    }
    let [current, velocity, reference] =
        [&motion.current_a, &motion.velocity_rad_s, &motion.reference_rad_s].map(|signal| bridged(signal));
    let (i, moved, asked) = (filter.forward(&current), columns(&velocity), columns(&reference));
    let rows: Vec<usize> =
        (usize::from(balance.settle)..i.len()).step_by(usize::from(balance.row_interval).max(1)).collect();
    if rows.len() < 4 * OWN.len() {
        return None;
    }
    let of = |columns: &[Vec<f64>; 5]| DMatrix::from_fn(rows.len(), OWN.len(), |row, k| columns[k][rows[row]]);
    let (x, z) = (of(&moved), of(&asked));
    let y = DVector::from_iterator(rows.len(), rows.iter().map(|&k| i[k]));
    let inverse = z.tr_mul(&x).try_inverse()?;
    let p = &inverse * z.tr_mul(&y); // (2)
    let variance = (&y - &x * &p).norm_squared() / (rows.len() - OWN.len()) as f64;
    let covariance = &inverse * z.tr_mul(&z) * inverse.transpose() * variance * f64::from(balance.row_spread); // (3)
    let mut estimate = Estimate::default();
    for (k, term) in OWN.into_iter().enumerate() {
        estimate[term] = Some((p[k], covariance[(k, k)].max(0.0).sqrt()));
    }
    Some(estimate)
}

fn sign(balance: &Balance, velocity: f64) -> f64 {
    (velocity / f64::from(balance.sign_velocity_rad_s)).clamp(-1.0, 1.0)
}

fn stribeck(balance: &Balance, velocity: f64) -> f64 {
    let ratio = velocity / f64::from(balance.stribeck_velocity_rad_s);
    sign(balance, velocity) / (1.0 + ratio * ratio)
}
