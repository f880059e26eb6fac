//! Batch estimators in double precision, in a, b, c, written apart from the core and the workbench: what the streaming
//! estimators are measured against.
//!
//! ```text
//! f = (1 + Σâ)/Â · in   for y, u1, u2;   x̂_f = B̂/Â u1_f + Ĉ/Â u2_f                            (1)
//! Z = Q R by Householder,   θ = (QᵀX)⁻¹ Qᵀ y = (ZᵀX)⁻¹ Zᵀ y                                   (2)
//! cov θ = σ² (QᵀX)⁻¹ (QᵀX)⁻ᵀ = σ² (ZᵀX)⁻¹ ZᵀZ (XᵀZ)⁻¹,   σ² = Σ(y − Xθ)²/(N − n)               (3)
//! ```
//!
//! By (2) no condition number is squared: raw regressors of slow models reach 1e6.

use std::ops::Range;

use bearing_watch::plan::Structure;
use nalgebra::{DMatrix, DVector};

use crate::Inputs;

/// A record in double precision.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Output, first input, second input.
    pub signals: [Vec<f64>; 3],
}

impl Record {
    /// The very numbers that the core gets.
    #[must_use]
    pub fn new(samples: &[Inputs]) -> Self {
        let column = |of: fn(&Inputs) -> f32| samples.iter().map(|sample| f64::from(of(sample))).collect();
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
    pub fn delta(&self, structure: Structure) -> Self {
        let (map, shift) = delta_map(structure);
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
pub fn delta_map(structure: Structure) -> (DMatrix<f64>, DVector<f64>) {
    let n = structure.terms();
    let mut map = DMatrix::zeros(n, n);
    let mut first = 0;
    for (count, sign) in [(structure.na, -1.0), (structure.nb, 1.0), (structure.nc, 1.0)] {
        let count = count as usize;
        for k in 0..count {
            let sign = if k == 0 { sign } else { -sign };
            // Behind a level come all terms, behind a difference those from the next one on.
            (k..count).for_each(|i| map[(first + k, first + i)] = sign);
        }
        first += count;
    }
    let mut shift = DVector::zeros(n);
    if structure.na > 0 {
        shift[0] = -1.0;
    }
    (map, shift)
}

/// The parameters a, b, c of a δ-form.
#[must_use]
pub fn raw(structure: Structure, delta: &[f32]) -> Vec<f64> {
    let (map, shift) = delta_map(structure);
    let delta = DVector::from_iterator(shift.len(), delta.iter().map(|x| f64::from(*x)).take(shift.len()));
    let raw = map.try_inverse().expect("triangular") * (delta - shift);
    raw.as_slice().to_vec()
}

/// The δ-form of parameters a, b, c.
#[must_use]
pub fn delta(structure: Structure, raw: &[f64]) -> DVector<f64> {
    let (map, shift) = delta_map(structure);
    map * DVector::from_column_slice(raw) + shift
}

/// What filters and instruments ran with since the record's beginning. Their states go on where the model changes.
#[derive(Clone, Debug)]
pub struct Course {
    /// The auxiliary models (a, b, c), each with the sample from which it holds.
    pub auxiliaries: Vec<(usize, Vec<f64>)>,
    /// Sample on which the filters start, as if the signals had rested on its values and the simulated output on the
    /// measured one; without it everything is zero before the record.
    pub rest_on: Option<usize>,
}

impl Course {
    /// One model from the record's beginning, from zero.
    #[must_use]
    pub fn fixed(auxiliary: &[f64]) -> Self {
        Self { auxiliaries: vec![(0, auxiliary.to_vec())], rest_on: None }
    }

    /// The model that holds at a sample.
    fn at(&self, t: usize) -> &[f64] {
        let from = self.auxiliaries.partition_point(|(start, _)| *start <= t);
        &self.auxiliaries[from - 1].1
    }
}

/// One pass of simplified refined IV over `rows`.
#[must_use]
pub fn one_pass(record: &Record, structure: Structure, course: &Course, rows: Range<usize>) -> Fit {
    let delays = [0, structure.nkb, structure.nkc];
    let delayed: Vec<Vec<f64>> = record.signals.iter().zip(delays).map(|(x, by)| delayed(&x[..rows.end], by)).collect();
    let [y, u1, u2] = [0, 1, 2].map(|k| filtered(&delayed[k], structure, course));
    let simulated = simulated([&u1, &u2], structure, course, course.rest_on.map_or(0.0, |on| y[on]));
    // The delays are in the signals already.
    let structure = Structure { nkb: 0, nkc: 0, ..structure };
    let x = regressors(structure, [&y, &u1, &u2], &rows);
    let z = regressors(structure, [&simulated, &u1, &u2], &rows);
    solve(x, z, &DVector::from_column_slice(&y[rows]))
}

/// Simplified refined IV over `rows`, repeated with its own model from a start until it rests; and the passes made.
/// Every third pass is relaxed, which ends the going to and fro that plain repetition can fall into.
#[must_use]
pub fn batch(record: &Record, structure: Structure, start: &[f64], rows: Range<usize>) -> Option<(Fit, usize)> {
    let mut theta = DVector::from_column_slice(start);
    for pass in 1..=200 {
        let fit = one_pass(record, structure, &Course::fixed(theta.as_slice()), rows.clone());
        let step = &fit.theta - &theta;
        if step.iter().any(|step| !step.is_finite()) {
            return None;
        }
        let deviations = fit.delta(structure).deviations();
        if (delta_map(structure).0 * &step).iter().zip(&deviations).all(|(step, sd)| step.abs() <= 1e-6 * sd) {
            return Some((fit, pass));
        }
        theta += if pass % 3 == 0 { 0.5 } else { 1.0 } * step;
    }
    None
}

/// IV without filters: instruments are the output simulated by the auxiliary model.
#[must_use]
pub fn instrumental(record: &Record, structure: Structure, auxiliary: &[f64], rows: Range<usize>) -> Fit {
    let [y, u1, u2] = record.signals.each_ref().map(|signal| &signal[..rows.end]);
    let (d1, d2) = (delayed(u1, structure.nkb), delayed(u2, structure.nkc));
    let simulated = simulated([&d1, &d2], structure, &Course::fixed(auxiliary), 0.0);
    let x = regressors(structure, [y, u1, u2], &rows);
    let z = regressors(structure, [&simulated, u1, u2], &rows);
    solve(x, z, &DVector::from_column_slice(&y[rows]))
}

/// Least squares with weights λ^(age); N is then 1/(1−λ) and the covariance carries 1/(1+λ), as the core has it.
#[must_use]
pub fn least_squares(record: &Record, structure: Structure, rows: Range<usize>, lambda: f64) -> Fit {
    let signals = record.signals.each_ref().map(Vec::as_slice);
    let mut x = regressors(structure, signals, &rows);
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
pub fn conditions(record: &Record, structure: Structure, rows: Range<usize>) -> [f64; 2] {
    let x = regressors(structure, record.signals.each_ref().map(Vec::as_slice), &rows);
    // Φ θ = φ_δ θ_δ up to the target's shift, and θ_δ = map θ.
    let delta = &x * delta_map(structure).0.try_inverse().expect("triangular");
    [x, delta].map(|mut x| {
        for mut column in x.column_iter_mut() {
            column.normalize_mut();
        }
        let values = x.qr().r().singular_values();
        values.max() / values.min()
    })
}

/// The signal delayed by that number of samples; zeros before.
fn delayed(x: &[f64], by: u8) -> Vec<f64> {
    (0..x.len()).map(|t| lag(x, t, by as usize)).collect()
}

/// (1), first part.
fn filtered(x: &[f64], structure: Structure, course: &Course) -> Vec<f64> {
    let mut f: Vec<f64> = course.rest_on.map_or_else(Vec::new, |on| vec![x[on]; on + 1]);
    #[expect(clippy::needless_range_loop, reason = "the recurrence's own index")]
    for t in f.len()..x.len() {
        let a = &course.at(t)[..structure.na as usize];
        let past: f64 = a.iter().enumerate().map(|(k, a)| a * before(&f, t, k + 1, course)).sum();
        f.push((1.0 + a.iter().sum::<f64>()) * x[t] - past);
    }
    f
}

/// (1), second part, from inputs that carry their delays.
fn simulated([u1, u2]: [&[f64]; 2], structure: Structure, course: &Course, rest: f64) -> Vec<f64> {
    let (na, nb) = (structure.na as usize, structure.nb as usize);
    let mut x: Vec<f64> = course.rest_on.map_or_else(Vec::new, |on| vec![rest; on + 1]);
    for t in x.len()..u1.len() {
        let (a, rest) = course.at(t).split_at(na);
        let (b, c) = rest.split_at(nb);
        let sum = |terms: &[f64], x: &[f64], first: usize| -> f64 {
            terms.iter().enumerate().map(|(k, term)| term * before(x, t, k + first, course)).sum()
        };
        x.push(sum(b, u1, 0) + sum(c, u2, 0) - sum(a, &x, 1));
    }
    x
}

/// A value of a filtered signal, at rest before the filters start.
fn before(x: &[f64], t: usize, lag: usize, course: &Course) -> f64 {
    let rest = if course.rest_on.is_some() { x[0] } else { 0.0 };
    if t >= lag { x[t - lag] } else { rest }
}

fn lag(x: &[f64], t: usize, lag: usize) -> f64 {
    if t >= lag { x[t - lag] } else { 0.0 }
}

/// −y(t−1)…, u1(t−nkb)…, u2(t−nkc)… for each row.
fn regressors(structure: Structure, [y, u1, u2]: [&[f64]; 3], rows: &Range<usize>) -> DMatrix<f64> {
    let Structure { na, nb, nc, nkb, nkc, .. } = structure;
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

/// How one pass over `rows` answers to its auxiliary model: ∂θ̂/∂θ_aux at a fit, in δ-form, by central differences of a
/// twentieth of σ. Without noise it vanishes: the estimate is then the truth whatever the auxiliary model.
#[must_use]
pub fn sensitivity(record: &Record, structure: Structure, at: &Fit, rows: &Range<usize>) -> DMatrix<f64> {
    let back = delta_map(structure).0.try_inverse().expect("triangular");
    let columns = at.delta(structure).deviations().into_iter().enumerate().map(|(k, sd)| {
        let moved = |step: f64| {
            let auxiliary = &at.theta + back.column(k) * step;
            one_pass(record, structure, &Course::fixed(auxiliary.as_slice()), rows.clone()).delta(structure).theta
        };
        (moved(0.05 * sd) - moved(-0.05 * sd)) / (0.1 * sd)
    });
    DMatrix::from_columns(&columns.collect::<Vec<_>>())
}
