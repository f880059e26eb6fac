//! Residuals → the autoregressive model that whitens them.

use super::kernel::triangle::Triangle;

/// AR polynomial `1 + l₁ q⁻¹ + … + l_n q⁻ⁿ` that whitens the noise, by least squares from the n-th sample of each
/// record.
pub(super) fn autoregression(noise: &[&[f64]], n: usize) -> Option<Vec<f64>> {
    let mut triangle = Triangle::new(n, n + 1);
    let mut block = Vec::new();
    for w in noise {
        if w.len() <= 2 * n {
            return None;
        }
        let columns: Vec<&[f64]> = (1..=n).chain([0]).map(|lag| &w[n - lag..w.len() - lag]).collect();
        triangle.absorb_columns(&columns, &mut block);
    }
    if triangle.dependent().is_some() {
        return None;
    }
    let mut taps = triangle.column(n).to_vec();
    triangle.substitute(&mut taps);
    Some(std::iter::once(1.0).chain(taps.iter().map(|l| -l)).collect())
}
