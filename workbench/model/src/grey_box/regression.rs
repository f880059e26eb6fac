//! Linear regression with instruments; the standard deviations are valid for correlated residuals too.
//!
//! ```text
//! Z = Q R,   θ = (QᵀX)⁻¹ Qᵀ y,   P = (QᵀX)⁻¹ Qᵀ                                   (1)
//! cov θ = N/(N−n) Σ_|l|≤L (1 − |l|/(L+1)) Σ_t g(t) g(t−l)ᵀ,   g(t) = P_t e(t)     (2)
//! ```
//!
//! With Z = X, (1) is least squares. (2) is the form of Newey and West (1987): filters before the regression spread
//! each disturbance over about L rows, and the white-noise formula would return standard deviations that are too small.
//! Columns are first scaled to unit norm, so that the test for linear dependence does not depend on units.

use nalgebra::{DMatrix, DVector};

/// Diagonal of R for a unit column below which the column counts as linearly dependent: rounding leaves 1e-15.
const DEPENDENT: f64 = 1e-10;

/// θ with its covariance (2).
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub theta: DVector<f64>,
    pub covariance: DMatrix<f64>,
    /// ‖y − Xθ‖ / ‖y‖.
    pub relative_error: f64,
}

/// Solves (1); the error is the first column that the data do not determine.
pub(crate) fn solve(
    x: &DMatrix<f64>,
    instruments: &DMatrix<f64>,
    y: &DVector<f64>,
    lags: usize,
) -> Result<Solution, usize> {
    let n = x.ncols();
    let (x_scaled, x_norms) = unit_columns(x)?;
    let (z_scaled, _) = unit_columns(instruments)?;
    independent(&x_scaled)?;
    let q = {
        independent(&z_scaled)?;
        z_scaled.qr().q()
    };
    let system = (q.transpose() * &x_scaled).qr();
    let projected = q.transpose();
    // (1); the rows of `influence` are those of P.
    let mut influence = system.solve(&projected).ok_or(n - 1)?;
    for (mut row, norm) in influence.row_iter_mut().zip(&x_norms) {
        row /= *norm;
    }
    let theta = &influence * y;
    if !theta.iter().all(|p| p.is_finite()) {
        return Err(n - 1);
    }
    let residuals = y - x * &theta;
    let relative_error = residuals.norm() / y.norm();
    for (mut column, e) in influence.column_iter_mut().zip(residuals.iter()) {
        column *= *e;
    }
    let score = |t: usize, g: &mut DVector<f64>| g.copy_from(&influence.column(t));
    Ok(Solution { covariance: covariance(influence.shape(), score, lags), theta, relative_error })
}

fn unit_columns(x: &DMatrix<f64>) -> Result<(DMatrix<f64>, Vec<f64>), usize> {
    let norms: Vec<f64> = x.column_iter().map(|column| column.norm()).collect();
    if let Some(zero) = norms.iter().position(|norm| !(*norm > 0.0 && norm.is_finite())) {
        return Err(zero);
    }
    let mut scaled = x.clone();
    for (mut column, norm) in scaled.column_iter_mut().zip(&norms) {
        column /= *norm;
    }
    Ok((scaled, norms))
}

fn independent(scaled: &DMatrix<f64>) -> Result<(), usize> {
    let r = scaled.clone().qr().r();
    (0..r.ncols()).find(|&k| r[(k, k)].abs() < DEPENDENT).map_or(Ok(()), Err)
}

/// (2), from scores g(t) of `n` parameters in `rows` rows, which `score` writes. Bartlett's weights are those of sums
/// of L + 1 consecutive scores: Σ_|l|≤L (1 − |l|/(L+1)) Σ_t g(t) g(t−l)ᵀ = 1/(L+1) Σ_t s(t) s(t)ᵀ, s(t) = g(t) + … +
/// g(t−L), with zeros before the first and after the last score. One pass, however long the lags.
pub(crate) fn covariance(
    (n, rows): (usize, usize),
    score: impl Fn(usize, &mut DVector<f64>),
    lags: usize,
) -> DMatrix<f64> {
    let (mut sum, mut window) = (DMatrix::zeros(n, n), DVector::zeros(n));
    let mut g = DVector::zeros(n);
    for t in 0..rows + lags {
        if t < rows {
            score(t, &mut g);
            window += &g;
        }
        if let Some(last) = t.checked_sub(lags + 1) {
            score(last, &mut g);
            window -= &g;
        }
        sum.ger(1.0, &window, &window, 1.0);
    }
    sum * (rows as f64 / ((rows - n) as f64 * (lags + 1) as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    #[test]
    fn exact_data_give_exact_parameters_whatever_the_units() {
        let x = DMatrix::from_fn(20, 2, |t, k| if k == 0 { 1e6 * (t as f64).sin() } else { 1e-6 * t as f64 });
        let theta = DVector::from_column_slice(&[2e-6, 3e6]);
        let solution = solve(&x, &x, &(&x * &theta), 3).expect("regular");
        assert!(
            (solution.theta[0] / theta[0] - 1.0).abs() < 1e-12 && (solution.theta[1] / theta[1] - 1.0).abs() < 1e-12
        );
        assert!(solution.relative_error < 1e-14); // rounding
    }

    #[test]
    fn a_dependent_column_is_named() {
        let x = DMatrix::from_fn(20, 3, |t, k| if k == 2 { 2.0 * t as f64 } else { (t as f64).powi(1 - k as i32) });
        assert_eq!(solve(&x, &x, &DVector::zeros(20), 0).expect_err("columns 0 and 2 agree"), 2);
    }

    #[test]
    fn the_covariance_is_the_weighted_sum_over_lags() {
        let influence = DMatrix::from_fn(2, 9, |k, t| ((3 * t + 5 * k) as f64).sin());
        let residuals = DVector::from_fn(9, |t, _| 1.0 + (t as f64).cos());
        let g = |t: i64| usize::try_from(t).ok().filter(|t| *t < 9).map(|t| influence.column(t) * residuals[t]);
        for lags in [0, 1, 4, 8, 20] {
            let mut expected = DMatrix::zeros(2, 2);
            for (l, t) in (-lags..=lags).flat_map(|l| (0..9).map(move |t| (l, t))) {
                if let (Some(now), Some(then)) = (g(t), g(t - l)) {
                    expected += now * then.transpose() * (1.0 - l.abs() as f64 / (lags + 1) as f64);
                }
            }
            expected *= 9.0 / 7.0;
            let score = |t: usize, g: &mut DVector<f64>| *g = influence.column(t) * residuals[t];
            let covariance = covariance((2, 9), score, lags as usize);
            let error = (&covariance - &expected).norm();
            assert!(error < 1e-13 * expected.norm(), "{lags}: {covariance} {expected}"); // rounding
        }
    }

    #[test]
    fn deviations_hold_under_correlated_noise() {
        // Mean of an AR(1) process with pole 0.8: sd = σ_e/(1 − 0.8)/√N; the white-noise formula returns a third of it.
        let (rows, mut rng) = (4000, ChaCha8Rng::seed_from_u64(1));
        let mut noise = 0.0;
        let y = DVector::from_fn(rows, |_, _| {
            let white: f64 = StandardNormal.sample(&mut rng);
            noise = 0.8 * noise + white;
            noise
        });
        let ones = DMatrix::from_element(rows, 1, 1.0);
        let sd = |lags| solve(&ones, &ones, &y, lags).expect("regular").covariance[(0, 0)].sqrt();
        let truth = 5.0 / (rows as f64).sqrt();
        // The estimate of a long-run variance scatters by about √(L/N) = 10 %, and Bartlett's weights reduce it by
        // about 10 %.
        assert!((0.75..1.25).contains(&(sd(40) / truth)), "{}", sd(40) / truth);
        assert!(sd(0) < 0.45 * truth, "white formula: {}", sd(0) / truth);
    }
}
