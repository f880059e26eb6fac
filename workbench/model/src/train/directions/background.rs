//! The other coordinates that explain a part of a rising one.
//!
//! What a coordinate shares with others that no defect raises, a temperature say, is subtracted:
//!
//! ```text
//! y = z_k − Σ β_j z_j,   β: least squares of the run means less those of their drive                  (1)
//! ```
//!
//! Backgrounds enter one by one, that with the smallest remaining sum of squares first, while the F test of the next
//! one is significant (1 %, Bonferroni over those that are left). Of a friction these are torque constant and inertia,
//! never another friction, which a defect raises too; of an order they are the other orders as well: the scores share
//! the floor of noise, and their defects are different ones.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::levels::{self, FEWEST, LEAST_WEIGHT, Sample};

/// Most backgrounds of a direction.
pub(super) const MOST: usize = 4;
/// Probability that a background enters by chance.
const UNLIKELY: f64 = 0.01;

/// Returns coordinate and β of the backgrounds of a coordinate, out of these; `sample` gives the values of one.
pub(super) fn of(coordinate: usize, offered: &[usize], sample: &dyn Fn(usize) -> Sample) -> Vec<(usize, f64)> {
    let mut places = vec![coordinate];
    places.extend_from_slice(offered);
    let Some(rows) = deviations(&places, sample) else { return vec![] };
    let mut chosen: Vec<usize> = vec![];
    let mut fit = rows.fit(&chosen);
    while let Some((_, before)) = fit.clone().filter(|_| chosen.len() < MOST) {
        let left: Vec<usize> = (1..places.len()).filter(|k| !chosen.contains(k)).collect();
        let tried = left.iter().filter_map(|&k| Some((k, rows.fit(&[&chosen[..], &[k]].concat())?)));
        let Some((next, found)) = tried.min_by(|a, b| a.1.1.total_cmp(&b.1.1)) else { break };
        let freedom = rows.freedom - chosen.len() as f64 - 1.0;
        if freedom < FEWEST || !significant((before, found.1), freedom, left.len()) {
            break;
        }
        chosen.push(next);
        fit = Some(found);
    }
    let weights = fit.map(|(weights, _)| weights).unwrap_or_default();
    chosen.iter().zip(weights.iter()).map(|(&k, weight)| (places[k], *weight)).collect()
}

/// Whether a sum of squares falls by more than chance.
fn significant((before, after): (f64, f64), freedom: f64, tried: usize) -> bool {
    let ratio = (before - after) / (after / freedom);
    let law = FisherSnedecor::new(1.0, freedom);
    law.is_ok_and(|law| ratio.is_finite() && law.sf(ratio) * (tried as f64) < UNLIKELY)
}

/// Run means less those of their drive: the coordinate in the first column, those offered behind it.
struct Rows {
    values: DMatrix<f64>,
    /// Runs less drives.
    freedom: f64,
}

impl Rows {
    /// Weights of these columns and the remaining sum of squares; `None` if they depend on each other.
    fn fit(&self, columns: &[usize]) -> Option<(DVector<f64>, f64)> {
        let y = self.values.column(0);
        if columns.is_empty() {
            return Some((DVector::zeros(0), y.norm_squared()));
        }
        let x = self.values.select_columns(columns);
        let scale = DVector::from_iterator(columns.len(), x.column_iter().map(|column| column.norm()));
        if scale.iter().any(|norm| *norm <= 0.0 || !norm.is_finite()) {
            return None;
        }
        let x = DMatrix::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] / scale[j]);
        let normal = x.transpose() * &x + DMatrix::identity(columns.len(), columns.len()) * 1e-9;
        let weights = normal.cholesky()?.solve(&(x.transpose() * y));
        let left = (y - &x * &weights).norm_squared();
        Some((weights.component_div(&scale), left))
    }
}

/// The rows of all runs that have every coordinate; `None` if one is missing or constant.
fn deviations(places: &[usize], sample: &dyn Fn(usize) -> Sample) -> Option<Rows> {
    let mut all: Vec<Vec<Vec<f64>>> = vec![];
    for &place in places {
        let sample = sample(place);
        let within = levels::record(&sample)?;
        let mean = |run: &Vec<[f64; 2]>| match levels::weighted(run, within) {
            (mean, weight) if weight >= LEAST_WEIGHT => mean,
            _ => f64::NAN,
        };
        all.push(sample.iter().map(|runs| runs.iter().map(mean).collect()).collect());
    }
    let mut rows: Vec<Vec<f64>> = vec![];
    let mut drives = 0;
    for drive in 0..all[0].len() {
        let row = |run: usize| -> Vec<f64> { all.iter().map(|means| means[drive][run]).collect() };
        let of_drive = (0..all[0][drive].len()).map(row);
        let of_drive: Vec<Vec<f64>> = of_drive.filter(|row| row.iter().all(|x| x.is_finite())).collect();
        let count = of_drive.len() as f64;
        drives += usize::from(count > 0.0);
        let mean: Vec<f64> =
            (0..places.len()).map(|k| of_drive.iter().map(|row| row[k]).sum::<f64>() / count).collect();
        rows.extend(of_drive.iter().map(|row| row.iter().zip(&mean).map(|(x, mean)| x - mean).collect()));
    }
    let values = DMatrix::from_fn(rows.len(), places.len(), |i, j| rows[i][j]);
    Some(Rows { values, freedom: rows.len().saturating_sub(drives) as f64 })
}
