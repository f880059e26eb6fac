//! The torque balance of a drive whose load is not measured, by instruments from the velocity reference.
//!
//! ```text
//! i = x p + o,   x = (ω̇, ω, s(ω), s(ω)/(1 + (ω/ω_s)²)),   o: offset and mean load of a record                    (1)
//! p = p₀ + (Σ Zᵀ X + D)⁻¹ Σ Zᵀ (i − X p₀),   z = (ṙ, r, s(r), s(r)/(1 + (r/ω_s)²))                            (2)
//! D = n (σ/prior)²,   n: rows per independent row, p₀ and prior of least squares                              (3)
//! w(k) = 2 sin²(π (k + ½)/K)   the weight of row k of K of a record, in all sums and means                    (4)
//! ```
//!
//! The controller answers a load with current, and the load moves the shaft: velocity and load depend on each other,
//! and least squares on (1) gives wrong parameters, the inertia of the simulated rig about twice too large. The
//! reference r does not depend on the load, so instruments (2) are consistent (Söderström and Stoica, *Instrumental
//! Variable Methods for System Identification*, §3). In one record of few periods load and reference are related by
//! chance, which biases the estimate; (2) sums over all records, less the means of each, and less what a weight on an
//! axis explains of each signal, if there is one ([`super::period`]). The window (4) keeps the frequencies of the load
//! apart from those of the reference. All signals pass the filter of the core's torque balance.

use std::f64::consts::{PI, TAU};

use bearing_watch::model::TorqueBalance;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use rayon::prelude::*;

use super::filtered::{COLUMNS, Filtered, Rates, turned};
use crate::trace::{MotionTrace, bridged, median};

/// The parameters of (1) among all terms of the balance.
const OWN: [usize; COLUMNS] = [0, 1, 2, 6];
/// The offset among all terms of the balance.
const OFFSET: usize = 4;
/// Fewest rows of a record.
const FEWEST: usize = 4 * OWN.len();

type Columns = [Vec<f64>; OWN.len()];
type Matrix = SMatrix<f64, { OWN.len() }, { OWN.len() }>;
type Vector = SVector<f64, { OWN.len() }>;

/// Sums of one record, and what of its rows does not change or is of the weight.
struct Sums {
    zx: Matrix,
    zi: Vector,
    offset_x: Vector,
    offset_i: f64,
}

/// What is taken from all signals of a record, with the weights (4): a constant, and with a weight its two sines.
struct Taken {
    weights: Vec<f64>,
    columns: DMatrix<f64>,
    /// The inverse of the columns' weighted products.
    inverse: DMatrix<f64>,
}

impl Taken {
    fn new(weights: Vec<f64>, axis: Option<&[f64]>) -> Option<Self> {
        let turns = |row: usize| axis.map_or(0.0, |axis| TAU * axis[row]);
        let column = |row: usize, column: usize| match column {
            0 => 1.0,
            1 => turns(row).cos(),
            _ => turns(row).sin(),
        };
        let columns = DMatrix::from_fn(weights.len(), if axis.is_some() { 3 } else { 1 }, column);
        let weighted = DMatrix::from_fn(columns.nrows(), columns.ncols(), |row, k| columns[(row, k)] * weights[row]);
        let inverse = columns.tr_mul(&weighted).try_inverse()?;
        Some(Self { weights, columns, inverse })
    }

    /// What is left of a signal, and its constant.
    fn rest(&self, signal: &[f64]) -> (Vec<f64>, f64) {
        let weighted = DVector::from_iterator(signal.len(), signal.iter().zip(&self.weights).map(|(x, w)| x * w));
        let parts = &self.inverse * self.columns.tr_mul(&weighted);
        let explained = &self.columns * &parts;
        (signal.iter().zip(explained.iter()).map(|(x, own)| x - own).collect(), parts[0])
    }
}

/// Replaces the nominal parameters that do not belong to the load by (2), and the offset by the median of o. `axis` are
/// turns of the motor for one of an axis with a weight. Returns whether a record has a reference that moves the shaft;
/// without one, or if they give no positive inertia, nothing changes.
pub(crate) fn correct(balance: &mut TorqueBalance, healthy: &[&MotionTrace], rates: Rates, axis: Option<f64>) -> bool {
    let records: Vec<Sums> = healthy.par_iter().filter_map(|motion| sums(motion, balance, rates, axis)).collect();
    if records.is_empty() {
        return false;
    }
    let before = Vector::from(OWN.map(|term| f64::from(balance.nominal[term])));
    let weight = f64::from(balance.row_spread) * f64::from(balance.deviation).powi(2);
    let weights = Vector::from(OWN.map(|term| weight / f64::from(balance.prior[term]).powi(2))); // (3)
    let (mut zx, mut rest) = (Matrix::from_diagonal(&weights), Vector::zeros());
    for own in &records {
        zx += own.zx;
        rest += own.zi - own.zx * before;
    }
    let Some(inverse) = zx.try_inverse() else { return false };
    let p = before + inverse * rest; // (2)
    // A sine that moves a weight hardly tells the inertia from it.
    if p[0] <= 0.0 {
        return false;
    }
    for (term, own) in OWN.into_iter().zip(p.iter()) {
        balance.nominal[term] = *own as f32;
    }
    let offsets: Vec<f64> = records.iter().map(|own| own.offset_i - own.offset_x.dot(&p)).collect();
    balance.nominal[OFFSET] = median(offsets) as f32;
    true
}

/// The sums of a record; `None` if it has no reference, one that does not move, or too few rows.
fn sums(motion: &MotionTrace, balance: &TorqueBalance, rates: Rates, axis: Option<f64>) -> Option<Sums> {
    if motion.reference_rad_s.is_empty() {
        return None;
    }
    let filtered = Filtered::new(balance, rates);
    let [current, velocity, reference] =
        [&motion.current_a, &motion.velocity_rad_s, &motion.reference_rad_s].map(|signal| bridged(signal));
    let rows: Vec<usize> = filtered.rows(current.len()).collect();
    if rows.len() < FEWEST {
        return None;
    }
    let at = |signal: Vec<f64>| rows.iter().map(|&row| signal[row]).collect::<Vec<f64>>();
    let count = rows.len() as f64;
    let window = |k: usize| 2.0 / count * (PI * (k as f64 + 0.5) / count).sin().powi(2); // (4)
    let axis = axis.map(|turns| {
        at(filtered.signal(&turned(&motion.angle_rad))).into_iter().map(|own| own / turns).collect::<Vec<_>>()
    });
    let taken = Taken::new((0..rows.len()).map(window).collect(), axis.as_deref())?;
    let rest = |columns: Columns| columns.map(|column| taken.rest(&at(column)));
    let (moved, asked) = (rest(filtered.columns(&velocity)), rest(filtered.columns(&reference)));
    let (i, offset_i) = taken.rest(&at(filtered.signal(&current)));
    let of = |columns: &[(Vec<f64>, f64); OWN.len()], row: usize| Vector::from_fn(|k, _| columns[k].0[row]);
    let (mut zx, mut zi, mut motion) = (Matrix::zeros(), Vector::zeros(), 0.0);
    for (row, weight) in taken.weights.iter().enumerate() {
        let z = of(&asked, row) * *weight * count;
        zx += z * of(&moved, row).transpose();
        zi += z * i[row];
        motion += asked[1].0[row].powi(2) * weight;
    }
    // A reference that stands still but for rounding, or not a number anywhere, tells nothing.
    let moves = motion > 1e-12 * asked[1].1.powi(2) && zx[(1, 1)] > 0.0;
    let offset_x = Vector::from_fn(|k, _| moved[k].1);
    (moves && zx.iter().all(|own| own.is_finite())).then_some(Sums { zx, zi, offset_x, offset_i })
}

#[cfg(test)]
mod tests {
    use bearing_watch::model::{StateVariable, TERMS};

    use super::*;
    use crate::train::estimator::filtered::sign;
    use crate::train::estimator::motion_of;
    use rig::{Condition, Scenario, simulate};

    const INTERVAL_S: f64 = 0.002;
    const CUTOFF_HZ: f64 = 4.0;

    fn balance() -> TorqueBalance {
        let gain = (std::f64::consts::PI * CUTOFF_HZ * INTERVAL_S).tan() as f32;
        TorqueBalance {
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
            adapt_after_rows: 48,
            largest_change_rad: f32::INFINITY,
        }
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
        let before = TorqueBalance { deviation: 1e-6, ..balance() };
        let current = |(k, w): (usize, &f64)| 0.005 * slope(k) + 0.02 * w + 0.3 * sign(&before, *w) + 0.1;
        let current_a = velocity.iter().enumerate().map(current).collect();
        let mut motion = MotionTrace { current_a, velocity_rad_s: velocity.clone(), ..MotionTrace::default() };
        let mut found = before;
        assert!(!correct(&mut found, &[&motion], (CUTOFF_HZ, 1), None), "no reference");
        motion.reference_rad_s = vec![1.0; velocity.len()];
        assert!(!correct(&mut found, &[&motion], (CUTOFF_HZ, 1), None), "a reference that stands still");
        assert_eq!(found, before);
        motion.reference_rad_s = velocity;
        assert!(correct(&mut found, &[&motion], (CUTOFF_HZ, 1), None));
        for (term, exact) in [(0, 0.005), (1, 0.02), (2, 0.3), (4, 0.1), (6, 0.0)] {
            // Central differences of the fastest sine are short by a part in 10⁵.
            assert!((f64::from(found.nominal[term]) - exact).abs() < 1e-4, "{term}: {}", found.nominal[term]);
        }
        assert_eq!((found.nominal[3], found.nominal[5]), (before.nominal[3], before.nominal[5]), "terms of the load");
        // Without any motion of the shaft the prior is all that is known.
        motion.velocity_rad_s.fill(0.0);
        motion.current_a.fill(0.5);
        assert!(!correct(&mut found, &[&motion], (CUTOFF_HZ, 1), None), "a shaft that stands still");
    }

    #[test]
    fn a_load_that_is_not_measured_biases_least_squares_and_not_instruments() {
        let records: Vec<MotionTrace> = (0..80)
            .map(|seed| {
                let scenario = Condition::MIX.apply(Scenario::STANDARD, 900 + seed);
                motion_of(simulate(&scenario, 900 + seed).expect("valid"))
            })
            .collect();
        let inertia = |records: &[MotionTrace]| {
            let mut found = balance();
            assert!(correct(&mut found, &records.iter().collect::<Vec<_>>(), (CUTOFF_HZ, 1), None));
            f64::from(found.nominal[0])
        };
        let instruments = inertia(&records);
        // With the velocity as its own instrument, (2) is least squares.
        let own =
            |record: &MotionTrace| MotionTrace { reference_rad_s: record.velocity_rad_s.clone(), ..record.clone() };
        let squares = inertia(&records.iter().map(own).collect::<Vec<_>>());
        println!("J/Kt: instruments {instruments}, least squares {squares}");
        // J/Kt is 0.005 A s²/rad. The estimate of as many records scatters by about 0.001.
        assert!((0.0035..0.0065).contains(&instruments) && squares > 0.009, "{instruments} {squares}");
    }
}
