//! Batch estimators in double precision, in a, b, c, written apart from the core and the workbench: what the streaming
//! estimators are measured against.
//!
//! ```text
//! f = (1 + Σâ)/Â · in   for y, u1, u2;   x̂_f = B̂/Â u1_f + Ĉ/Â u2_f,   both from rest           (1)
//! Z = Q R by Householder,   θ = (QᵀX)⁻¹ Qᵀ y = (ZᵀX)⁻¹ Zᵀ y                                   (2)
//! cov θ = σ² (QᵀX)⁻¹ (QᵀX)⁻ᵀ = σ² (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹,   σ² = Σ(y − Xθ)²/(N − n)               (3)
//! ```
//!
//! By (2) no condition number is squared: raw regressors of slow models reach 1e6.

use std::ops::Range;

use bearing_watch::{Order, Sample};
use nalgebra::{DMatrix, DVector};

/// A record in double precision.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Output, first input, second input.
    pub signals: [Vec<f64>; 3],
}

impl Record {
    /// The very numbers that the core gets.
    #[must_use]
    pub fn new(samples: &[Sample]) -> Self {
        let column = |of: fn(&Sample) -> f32| samples.iter().map(|sample| f64::from(of(sample))).collect();
        Self { signals: [column(|s| s.y), column(|s| s.u1), column(|s| s.u2)] }
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.signals[0].len()
    }
}

/// Parameters a, b, c with what is known about them.
#[derive(Clone, Debug)]
pub struct Fit {
    /// a₁…, b₁…, c₁….
    pub theta: DVector<f64>,
    /// Covariance of `theta`.
    pub covariance: DMatrix<f64>,
    /// σ².
    pub variance: f64,
    /// Number of rows.
    pub rows: usize,
}

impl Fit {
    /// As δ-parameters t, β, γ.
    #[must_use]
    pub fn delta(&self, order: Order) -> Self {
        let (map, shift) = delta_map(order);
        let covariance = &map * &self.covariance * map.transpose();
        Self { theta: &map * &self.theta + shift, covariance, ..self.clone() }
    }

    /// Standard deviations of `theta`.
    #[must_use]
    pub fn deviations(&self) -> Vec<f64> {
        self.covariance.diagonal().iter().map(|v| v.sqrt()).collect()
    }
}

/// δ-parameters = map · (a, b, c) + shift: t₀ = −1 − Σa, t_k = Σ_{i>k} aᵢ; β₀ = Σb, β_k = −Σ_{j>k} b_j; γ likewise.
#[must_use]
pub fn delta_map(order: Order) -> (DMatrix<f64>, DVector<f64>) {
    let n = order.parameters();
    let mut map = DMatrix::zeros(n, n);
    let mut first = 0;
    for (count, sign) in [(order.na, -1.0), (order.nb, 1.0), (order.nc, 1.0)] {
        let count = count as usize;
        for k in 0..count {
            let sign = if k == 0 { sign } else { -sign };
            // Behind a level come all terms, behind a difference those from the next one on.
            (k..count).for_each(|i| map[(first + k, first + i)] = sign);
        }
        first += count;
    }
    let mut shift = DVector::zeros(n);
    if order.na > 0 {
        shift[0] = -1.0;
    }
    (map, shift)
}

/// The auxiliary model (a, b, c) that holds from a sample on, until the next one's.
pub type Auxiliary = (usize, Vec<f64>);

/// One pass of simplified refined IV over `rows`, with filters and instruments that run from the record's beginning.
#[must_use]
pub fn one_pass(record: &Record, order: Order, auxiliaries: &[Auxiliary], rows: Range<usize>) -> Fit {
    let end = rows.end;
    let [y, u1, u2] = record.signals.each_ref().map(|signal| filtered(&signal[..end], order, auxiliaries));
    let simulated = simulated([&u1, &u2], order, auxiliaries);
    let x = regressors(order, [&y, &u1, &u2], &rows);
    let z = regressors(order, [&simulated, &u1, &u2], &rows);
    solve(x, z, &DVector::from_column_slice(&y[rows]))
}

/// Simplified refined IV over `rows`, repeated with its own model from a start until it rests; and the passes made.
/// Every third pass is relaxed, which ends the going to and fro that plain repetition can fall into.
#[must_use]
pub fn batch(record: &Record, order: Order, start: &[f64], rows: Range<usize>) -> Option<(Fit, usize)> {
    let mut theta = DVector::from_column_slice(start);
    for pass in 1..=200 {
        let fit = one_pass(record, order, &[(0, theta.as_slice().to_vec())], rows.clone());
        let step = &fit.theta - &theta;
        if step.iter().any(|step| !step.is_finite()) {
            return None;
        }
        let deviations = fit.delta(order).deviations();
        if (delta_map(order).0 * &step).iter().zip(&deviations).all(|(step, sd)| step.abs() <= 1e-6 * sd) {
            return Some((fit, pass));
        }
        theta += if pass % 3 == 0 { 0.5 } else { 1.0 } * step;
    }
    None
}

/// IV without filters: instruments are the output simulated by the auxiliary model.
#[must_use]
pub fn instrumental(record: &Record, order: Order, auxiliaries: &[Auxiliary], rows: Range<usize>) -> Fit {
    let [y, u1, u2] = record.signals.each_ref().map(|signal| &signal[..rows.end]);
    let simulated = simulated([u1, u2], order, auxiliaries);
    let x = regressors(order, [y, u1, u2], &rows);
    let z = regressors(order, [&simulated, u1, u2], &rows);
    solve(x, z, &DVector::from_column_slice(&y[rows]))
}

/// Least squares with weights λ^(age); N is then 1/(1−λ) and the covariance carries 1/(1+λ), as the core has it.
#[must_use]
pub fn least_squares(record: &Record, order: Order, rows: Range<usize>, lambda: f64) -> Fit {
    let signals = record.signals.each_ref().map(Vec::as_slice);
    let mut x = regressors(order, signals, &rows);
    let mut target = DVector::from_column_slice(&signals[0][rows]);
    let count = target.len();
    if lambda < 1.0 {
        let root = lambda.sqrt();
        let weight = |row: usize| root.powi(i32::try_from(count - 1 - row).expect("few rows"));
        for (row, mut cells) in x.row_iter_mut().enumerate() {
            cells *= weight(row);
        }
        target.iter_mut().enumerate().for_each(|(row, cell)| *cell *= weight(row));
        let mut fit = solve(x.clone(), x, &target);
        let n = fit.theta.len() as f64;
        let rows = 1.0 / (1.0 - lambda);
        let factor = (count as f64 - n) / (rows - n);
        fit.variance *= factor;
        fit.covariance *= factor / (1.0 + lambda);
        return fit;
    }
    solve(x.clone(), x, &target)
}

/// 2-norm condition numbers of the regressor, its columns scaled to one length: raw, and in the δ-form.
#[must_use]
pub fn conditions(record: &Record, order: Order, rows: Range<usize>) -> [f64; 2] {
    let x = regressors(order, record.signals.each_ref().map(Vec::as_slice), &rows);
    // Φ θ = φ_δ θ_δ up to the target's shift, and θ_δ = map θ.
    let delta = &x * delta_map(order).0.try_inverse().expect("triangular");
    [x, delta].map(|mut x| {
        for mut column in x.column_iter_mut() {
            column.normalize_mut();
        }
        let values = x.qr().r().singular_values();
        values.max() / values.min()
    })
}

/// The model that holds at each sample.
fn holding(auxiliaries: &[Auxiliary], t: usize) -> &[f64] {
    let from = auxiliaries.partition_point(|(start, _)| *start <= t);
    &auxiliaries[from - 1].1
}

/// (1) from rest, with the states going on where the model changes.
fn filtered(x: &[f64], order: Order, auxiliaries: &[Auxiliary]) -> Vec<f64> {
    let mut f: Vec<f64> = Vec::with_capacity(x.len());
    for (t, x) in x.iter().enumerate() {
        let a = &holding(auxiliaries, t)[..order.na as usize];
        let past: f64 = a.iter().enumerate().map(|(k, a)| a * lag(&f, t, k + 1)).sum();
        f.push((1.0 + a.iter().sum::<f64>()) * x - past);
    }
    f
}

/// Output of the auxiliary model from rest.
fn simulated([u1, u2]: [&[f64]; 2], order: Order, auxiliaries: &[Auxiliary]) -> Vec<f64> {
    let (na, nb) = (order.na as usize, order.nb as usize);
    let mut x: Vec<f64> = Vec::with_capacity(u1.len());
    for t in 0..u1.len() {
        let (a, rest) = holding(auxiliaries, t).split_at(na);
        let (b, c) = rest.split_at(nb);
        let sum = |terms: &[f64], x: &[f64], delay: usize| -> f64 {
            terms.iter().enumerate().map(|(k, term)| term * lag(x, t, k + delay)).sum()
        };
        x.push(sum(b, u1, order.nkb as usize) + sum(c, u2, order.nkc as usize) - sum(a, &x, 1));
    }
    x
}

fn lag(x: &[f64], t: usize, lag: usize) -> f64 {
    if t >= lag { x[t - lag] } else { 0.0 }
}

/// −y(t−1)…, u1(t−nkb)…, u2(t−nkc)… for each row.
fn regressors(order: Order, [y, u1, u2]: [&[f64]; 3], rows: &Range<usize>) -> DMatrix<f64> {
    let Order { na, nb, nc, nkb, nkc } = order;
    let columns = [(y, -1.0, 1, na), (u1, 1.0, nkb, nb), (u2, 1.0, nkc, nc)];
    let columns = columns
        .into_iter()
        .flat_map(|(x, sign, delay, count)| (0..count).map(move |k| (x, sign, usize::from(delay) + usize::from(k))));
    let columns: Vec<DVector<f64>> = columns
        .map(|(x, sign, delay)| DVector::from_iterator(rows.len(), rows.clone().map(|t| sign * lag(x, t, delay))))
        .collect();
    DMatrix::from_columns(&columns)
}

/// (2) and (3).
fn solve(x: DMatrix<f64>, z: DMatrix<f64>, target: &DVector<f64>) -> Fit {
    let (rows, n) = x.shape();
    let q = z.qr().q();
    let inverse = (q.transpose() * &x).try_inverse().unwrap_or_else(|| DMatrix::from_element(n, n, f64::NAN));
    let theta = &inverse * (q.transpose() * target);
    let variance = (target - x * &theta).norm_squared() / (rows - n) as f64;
    Fit { covariance: &inverse * inverse.transpose() * variance, theta, variance, rows }
}
