//! Correlations of residuals with inputs, their bounds for a true model, and tests that count the values outside.
//!
//! ```text
//! r_εu(τ) = Σ ε(t) u(t−τ) / √(Σε² Σu²)          τ > 0: past inputs                            (1)
//! var Σ ε u_τ = Σ_k R_v(k) Σ_t w_τ(t) w_τ(t−k),   w_τ = u_τ − K Sᵀ u_τ                        (2)
//! outside:  |r| > 2.576 sd                        1 % of the lags of a true model             (3)
//! ```
//!
//! Without estimated parameters w = u and (2) is the textbook formula Σ R_v R_u. With estimated parameters (module
//! `linearised`) the bounds of the lags used by the fit are narrower; for the regressors of least squares they are
//! zero. Lags fixed in this way are not tested. The colour of v is the autoregressive model of module `noise`; the
//! whiteness test assumes white v, which is its hypothesis. u is centred if a constant is estimated.
//!
//! The bounds of a model from another trace are wider instead, by the covariance of its parameters.
//!
//! Neighbouring lags of a coloured input are correlated, so the number of lags outside is not binomial. The allowed
//! number, and the limit of the largest |r|/sd, are quantiles of 4000 seeded draws of all tested lags from their joint
//! normal distribution; a true model exceeds each of them in 0.5 % of records.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::linearised::Linearised;
use super::noise::Noise;

/// Two-sided 99 % quantile of the standard normal distribution.
pub const NORMAL_99: f64 = 2.575_829_303_548_901;
/// Fraction of Σu² below which a lag is fixed by the fit: rounding leaves 1e-20, a free lag of a nearly dependent input
/// 1e-4.
const FIXED: f64 = 1e-9;
const DRAWS: usize = 4000;

/// Correlation at several lags.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlation {
    /// τ of (1), samples.
    pub lags: Vec<i64>,
    /// r.
    pub value: Vec<f64>,
    /// 99 % bound of |r|; zero where the fit fixes r.
    pub bound: Vec<f64>,
    /// Σ ε u_τ = Gᵀ × white noise of variance 1, one column of G per lag.
    sources: DMatrix<f64>,
}

/// Test result for the tested lags of one or more correlations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// Number of lags that are not fixed by the fit.
    pub tested: usize,
    /// Number of lags outside their 99 % bound.
    pub outside: usize,
    /// Largest number outside that passes.
    pub allowed: usize,
    /// Largest |r| in standard deviations.
    pub largest: f64,
    /// Largest |r| in standard deviations that passes.
    pub limit: f64,
}

impl Test {
    /// Whether the result is consistent with a true model; a true model fails in about 1 % of records.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.outside <= self.allowed && self.largest <= self.limit
    }
}

/// Cross-correlation with an input for lags −`lags` … `lags`.
#[must_use]
pub fn cross(linear: &Linearised, input: &[f64], centred: bool, lags: usize) -> Correlation {
    let (first, rows) = (linear.first, linear.residuals.len());
    let mean = if centred { input.iter().sum::<f64>() / input.len() as f64 } else { 0.0 };
    let noise = corrected(Noise::of(linear.residuals.as_slice()), linear);
    let span = lags as i64;
    let delayed = |lag: i64| {
        let at = |row: usize| usize::try_from((first + row) as i64 - lag).ok().and_then(|place| input.get(place));
        DVector::from_fn(rows, |row, _| at(row).map_or(0.0, |u| u - mean))
    };
    correlate(linear, (-span..=span).collect(), &delayed(0), delayed, &noise)
}

/// Autocorrelation for lags 1 … `lags`, with the bounds of white noise.
#[must_use]
pub fn auto(linear: &Linearised, lags: usize) -> Correlation {
    let residuals = &linear.residuals;
    let noise = corrected(Noise::white(residuals.as_slice()), linear);
    let delayed = |lag: i64| {
        let lag = usize::try_from(lag).unwrap_or(0);
        DVector::from_fn(residuals.len(), |row, _| row.checked_sub(lag).map_or(0.0, |place| residuals[place]))
    };
    correlate(linear, (1..=lags as i64).collect(), residuals, delayed, &noise)
}

/// The noise model, and the factor that corrects λ for the degrees of freedom used by the parameters.
fn corrected(noise: Noise, linear: &Linearised) -> (Noise, f64) {
    let rows = linear.residuals.len() as f64;
    (noise, (rows / (rows - linear.parameters() as f64)).sqrt())
}

fn correlate(
    linear: &Linearised,
    lags: Vec<i64>,
    undelayed: &DVector<f64>,
    delayed: impl Fn(i64) -> DVector<f64>,
    (noise, scale): &(Noise, f64),
) -> Correlation {
    let norm = linear.residuals.norm() * undelayed.norm();
    let (rows, further) = (linear.residuals.len(), linear.spread(undelayed).len());
    let mut sources = DMatrix::zeros(rows + further, lags.len());
    let mut value = vec![0.0; lags.len()];
    let mut bound = vec![0.0; lags.len()];
    for (k, &lag) in lags.iter().enumerate() {
        let signal = delayed(lag);
        let weight = linear.weight(&signal);
        if norm <= 0.0 || weight.norm_squared() <= FIXED * signal.norm_squared() {
            continue;
        }
        let colored = DVector::from_vec(noise.color(weight.as_slice())) * *scale;
        let mut source = colored.resize_vertically(rows + further, 0.0);
        source.rows_mut(rows, further).copy_from(&linear.spread(&signal));
        value[k] = linear.residuals.dot(&signal) / norm;
        bound[k] = NORMAL_99 * source.norm() / norm;
        sources.set_column(k, &source);
    }
    Correlation { lags, value, bound, sources }
}

/// Tests these lags of these correlations together.
#[must_use]
pub fn test(wanted: &[(&Correlation, RangeInclusive<i64>)]) -> Test {
    let (mut ratios, mut columns) = (Vec::new(), Vec::new());
    for (one, lags) in wanted {
        for k in (0..one.lags.len()).filter(|&k| lags.contains(&one.lags[k]) && one.bound[k] > 0.0) {
            ratios.push(NORMAL_99 * one.value[k].abs() / one.bound[k]);
            columns.push(one.sources.column(k).normalize());
        }
    }
    let outside = ratios.iter().filter(|&&r| r > NORMAL_99).count();
    let largest = ratios.iter().copied().fold(0.0, f64::max);
    let (allowed, limit) = if columns.is_empty() { (0, 0.0) } else { null(&DMatrix::from_columns(&columns)) };
    Test { tested: columns.len(), outside, allowed, largest, limit }
}

/// 99.5 % quantiles of the number outside and of the largest ratio, for lags with these unit columns as sources.
fn null(sources: &DMatrix<f64>) -> (usize, f64) {
    let size = sources.ncols();
    let eigen = sources.tr_mul(sources).symmetric_eigen();
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    let factor = eigen.eigenvectors * DMatrix::from_diagonal(&roots);
    let drawn = with_normals(size, |normals| factor * normals);
    let mut counts: Vec<usize> = drawn
        .column_iter()
        .map(|d: nalgebra::DVectorView<f64>| d.iter().filter(|x| x.abs() > NORMAL_99).count())
        .collect();
    let mut largest: Vec<f64> = drawn.column_iter().map(|d| d.amax()).collect();
    counts.sort_unstable();
    largest.sort_by(f64::total_cmp);
    let place = DRAWS - DRAWS / 200 - 1;
    (counts[place], largest[place])
}

thread_local! {
    /// The last draws: a study tests many records at the same lags, and drawing takes longer than the rest of a test.
    static NORMALS: RefCell<DMatrix<f64>> = RefCell::new(DMatrix::zeros(0, 0));
}

/// Gives `use_them` the draws for `size` lags: `size` × `DRAWS` standard normal numbers that depend on `size` only.
fn with_normals<T>(size: usize, use_them: impl FnOnce(&DMatrix<f64>) -> T) -> T {
    NORMALS.with_borrow_mut(|normals| {
        if normals.nrows() != size {
            let mut rng = ChaCha8Rng::seed_from_u64(0);
            *normals = DMatrix::from_fn(size, DRAWS, |_, _| StandardNormal.sample(&mut rng));
        }
        use_them(normals)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn independent_lags_are_binomial() {
        // 50 independent lags at 1 %: P(more than 3) = 0.16 %, P(more than 2) = 1.4 %, so 3 are allowed at 0.5 %;
        // the largest of 50 at 99.5 %: Φ⁻¹ of 1 − 0.005/100 = 3.89, known within ± 0.15 from the 20 draws above it.
        let (allowed, limit) = null(&DMatrix::identity(50, 50));
        assert_eq!(allowed, 3);
        assert!((limit - 3.89).abs() < 0.15, "{limit}");
    }

    #[test]
    fn equal_lags_lie_outside_together() {
        let (allowed, _) = null(&DMatrix::from_element(1, 50, 1.0));
        assert_eq!(allowed, 50, "one lag in fifty guises: outside in 1 % of records, all together");
    }
}
