//! The torque balance of a drive whose load is not measured, by instruments from the velocity reference.
//!
//! ```text
//! i = x p + T/Kt,   x = (ω̇, ω, s(ω), 1, s(ω)/(1 + (ω/ω_s)²))                                           (1)
//! p = (Zᵀ X)⁻¹ Zᵀ i,   z = (ṙ, r, s(r), 1, s(r)/(1 + (r/ω_s)²))                                         (2)
//! Cov p = n σ² (Zᵀ X)⁻¹ Zᵀ Z (Xᵀ Z)⁻¹,   n: rows per independent row                                   (3)
//! ```
//!
//! The controller answers a load with current, and the load moves the shaft: velocity and load depend on each other,
//! and least squares on (1) gives wrong parameters, the inertia of the simulated rig more than twice too large. The
//! reference r does not depend on the load, so instruments (2) are consistent (Söderström and Stoica, *Instrumental
//! Variable Methods for System Identification*, §3); in records of few periods they keep a part of the bias. All
//! signals pass the filter of the core's torque balance.

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

#[cfg(test)]
mod tests {
    use bearing_watch::model::StateVariable;

    use super::*;
    use crate::rig::{Condition, Scenario, simulate};

    const INTERVAL_S: f64 = 0.002;
    const CUTOFF_HZ: f64 = 4.0;

    fn balance() -> Balance {
        let gain = (std::f64::consts::PI * CUTOFF_HZ * INTERVAL_S).tan() as f32;
        Balance {
            interval_s: INTERVAL_S as f32,
            filter: StateVariable::new(gain, INTERVAL_S as f32),
            row_interval: 16,
            settle: 200,
            sign_velocity_rad_s: 2.0,
            stribeck_velocity_rad_s: 6.0,
            usual_velocity_rad_s: 30.0,
            usual_load_nm: 0.0,
            row_spread: 3.5,
            scale: [1.0; TERMS + 1],
            nominal: [0.0; TERMS],
            prior: [1.0; TERMS],
            deviation: 1.0,
            own_from_rows: 48,
        }
    }

    fn middle(mut values: Vec<f64>) -> f64 {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }

    #[test]
    fn an_exact_balance_is_found() {
        // A velocity of two sines; i = 0.005 ω̇ + 0.02 ω + 0.3 s + 0.1, with ω̇ by central differences.
        let velocity: Vec<f64> = (0..5000)
            .map(|k| f64::from(k) * INTERVAL_S)
            .map(|t| 30.0 * (1.3 * t).sin() + 10.0 * (4.1 * t).sin())
            .collect();
        let slope = |k: usize| match k {
            0 | 4999 => 0.0,
            _ => (velocity[k + 1] - velocity[k - 1]) / (2.0 * INTERVAL_S),
        };
        let balance = balance();
        let current = |(k, w): (usize, &f64)| 0.005 * slope(k) + 0.02 * w + 0.3 * sign(&balance, *w) + 0.1;
        let current_a = velocity.iter().enumerate().map(current).collect();
        let mut motion = MotionTrace { current_a, velocity_rad_s: velocity.clone(), ..MotionTrace::default() };
        assert_eq!(estimate(&motion, &balance, CUTOFF_HZ), None, "no reference");
        motion.reference_rad_s = velocity;
        let found = estimate(&motion, &balance, CUTOFF_HZ).expect("moves");
        for (term, exact) in [(0, 0.005), (1, 0.02), (2, 0.3), (4, 0.1), (6, 0.0)] {
            let (value, deviation) = found[term].expect("a term without a load");
            // Central differences of the fastest sine are short by a part in 10⁵.
            assert!((value - exact).abs() < 1e-4 && deviation < 1e-3, "{term}: {value} ± {deviation}");
        }
        assert!(found[3].is_none() && found[5].is_none());
    }

    #[test]
    fn a_load_that_is_not_measured_biases_least_squares_more_than_instruments() {
        let records: Vec<MotionTrace> = (0..80)
            .map(|seed| {
                let scenario = Condition::MIX.apply(Scenario::STANDARD, 900 + seed);
                MotionTrace::from(&simulate(&scenario, 900 + seed).expect("valid"))
            })
            .collect();
        let inertia = |of: &dyn Fn(&MotionTrace) -> MotionTrace| {
            let each = |record| estimate(&of(record), &balance(), CUTOFF_HZ).and_then(|own| own[0]);
            middle(records.iter().filter_map(each).map(|(value, _)| value).collect())
        };
        let instruments = inertia(&MotionTrace::clone);
        // With the velocity as its own instrument, (2) is least squares.
        let squares =
            inertia(&|record| MotionTrace { reference_rad_s: record.velocity_rad_s.clone(), ..record.clone() });
        println!("J/Kt: instruments {instruments}, least squares {squares}");
        // J/Kt is 0.005 A s²/rad. The middle of 80 records of a deviation of 0.004 has one of 0.0006; 10 s keep a part
        // of the bias.
        assert!((0.0035..0.0075).contains(&instruments) && squares > 0.009, "{instruments} {squares}");
    }
}
