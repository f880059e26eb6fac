//! Sums computed as several partial sums, so that an addition does not depend on the one before it.

/// Sum of products, in 32 partial sums.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    const WIDE: usize = 32;
    let mut sums = [0.0; WIDE];
    let (wide_a, wide_b) = (a.chunks_exact(WIDE), b.chunks_exact(WIDE));
    let tail: f64 = wide_a.remainder().iter().zip(wide_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in wide_a.zip(wide_b) {
        for k in 0..WIDE {
            sums[k] += x[k] * y[k];
        }
    }
    total(sums) + tail
}

/// Adds the upper half to the lower half until one sum is left. Not inlined: the compiler would vectorise the loop of
/// [`dot`] in the order of these additions, which is slower.
#[inline(never)]
fn total(mut sums: [f64; 32]) -> f64 {
    let mut half = sums.len() / 2;
    while half > 0 {
        for k in 0..half {
            sums[k] += sums[k + half];
        }
        half /= 2;
    }
    sums[0]
}

/// ‖y − ŷ‖², in eight partial sums.
pub(crate) fn distance(y: &[f64], simulated: &[f64]) -> f64 {
    by_eight(y, simulated, |y, s| (y - s) * (y - s))
}

/// ‖y − mean y‖².
pub(crate) fn spread(y: &[f64]) -> f64 {
    let mean = by_eight(y, y, |y, _| y) / y.len() as f64;
    by_eight(y, y, |y, _| (y - mean) * (y - mean))
}

#[inline(always)]
fn by_eight(x: &[f64], y: &[f64], term: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; 8];
    let (wide_x, wide_y) = (x.chunks_exact(8), y.chunks_exact(8));
    let tail: f64 = wide_x.remainder().iter().zip(wide_y.remainder()).map(|(x, y)| term(*x, *y)).sum();
    for (x, y) in wide_x.zip(wide_y) {
        for k in 0..8 {
            sums[k] += term(x[k], y[k]);
        }
    }
    sums.iter().sum::<f64>() + tail
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_take_any_length() {
        for n in [1, 7, 8, 19, 40, 75] {
            let x: Vec<f64> = (0..n).map(f64::from).collect();
            let squares = f64::from(n * (n - 1) * (2 * n - 1) / 6);
            assert_eq!(dot(&x, &x), squares);
            assert_eq!(distance(&x, &vec![0.0; x.len()]), squares);
            let mean = f64::from(n - 1) / 2.0;
            assert_eq!(spread(&x), squares - f64::from(n) * mean * mean);
        }
        assert_eq!(dot(&[], &[]), 0.0);
    }
}
