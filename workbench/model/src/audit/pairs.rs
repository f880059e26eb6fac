//! Two columns, or two traces: collinear channels, lags, equal recordings.

use crate::statistics::mean_sd;
use crate::trace::bridged;

/// Correlation from which on two channels say the same.
pub const COLLINEAR: f64 = 0.995;
/// Lags that are searched, rows.
const LAGS: i32 = 50;
/// Largest number of rows from which a lag is computed.
const LAGGED: usize = 200_000;
/// Rows of two traces that are compared.
const COMPARED: usize = 512;
/// Relative difference below which two traces are the same recording.
const SAME: f64 = 1e-3;

/// Correlation of two columns, by the rows in which no value is missing; 0 if one is constant.
#[must_use]
pub fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let is_whole = |(x, y): &(&f64, &f64)| x.is_finite() && y.is_finite();
    if !x.iter().zip(y).all(|pair| is_whole(&pair)) {
        let (x, y): (Vec<f64>, Vec<f64>) = x.iter().zip(y).filter(is_whole).unzip();
        return correlation(&x, &y);
    }
    let ((mx, sx), (my, sy)) = (mean_sd(x), mean_sd(y));
    let products: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    if sx * sy > 0.0 { products / ((x.len() - 1) as f64 * sx * sy) } else { 0.0 }
}

/// Rows by which `y` comes later than `x`, by the largest correlation of their changes, and this correlation; `None`
/// if they have little in common.
#[must_use]
pub fn lag(x: &[f64], y: &[f64]) -> Option<(f64, f64)> {
    let changes = |x: &[f64]| -> Vec<f64> { x.windows(2).map(|pair| pair[1] - pair[0]).collect() };
    let looked_at = x.len().min(y.len()).min(LAGGED);
    let (x, y) = (changes(&x[..looked_at]), changes(&y[..looked_at]));
    let n = x.len().min(y.len());
    if n < 4 * LAGS as usize {
        return None;
    }
    let at = |lag: i32| {
        let shift = lag.unsigned_abs() as usize;
        let (from_x, from_y) = if lag >= 0 { (0, shift) } else { (shift, 0) };
        correlation(&x[from_x..n - from_y], &y[from_y..n - from_x])
    };
    let best = (-LAGS..=LAGS).map(|lag| (lag, at(lag))).max_by(|one, other| one.1.total_cmp(&other.1))?;
    if best.0.abs() == LAGS || best.1 < 0.3 {
        return None;
    }
    // The vertex of the parabola through the largest value and its neighbours.
    let (before, after) = (at(best.0 - 1), at(best.0 + 1));
    let curve = before - 2.0 * best.1 + after;
    let part = if curve < 0.0 { 0.5 * (before - after) / curve } else { 0.0 };
    Some((f64::from(best.0) + part, best.1))
}

/// Pairs of traces whose columns are equal but for rounding, each column by its own deviation.
#[must_use]
pub fn equal(traces: &[Vec<&[f64]>]) -> Vec<[usize; 2]> {
    let deviation = |column: &&[f64]| mean_sd(&bridged(&column[..column.len().min(COMPARED)])).1;
    let deviations: Vec<Vec<f64>> = traces.iter().map(|columns| columns.iter().map(deviation).collect()).collect();
    let same = |k: usize, j: usize| {
        let pairs = || traces[k].iter().zip(&traces[j]).zip(&deviations[k]);
        let alike = |rows: usize| {
            pairs().all(|((one, other), deviation)| {
                let rows = rows.min(one.len());
                is_same(&one[..rows], &other[..rows], *deviation)
            })
        };
        let shapes = traces[k].len() == traces[j].len() && pairs().all(|((one, other), _)| one.len() == other.len());
        // The start tells nearly all pairs apart.
        shapes && deviations[k].iter().any(|deviation| *deviation > 0.0) && alike(COMPARED) && alike(usize::MAX)
    };
    let mut found = Vec::new();
    for k in 0..traces.len() {
        found.extend((0..k).filter(|j| same(k, *j)).map(|j| [j, k]));
    }
    found
}

/// Whether the rms of the differences of two columns is a small part of the deviation. Rows in which one has no value
/// do not count.
fn is_same(one: &[f64], other: &[f64], deviation: f64) -> bool {
    let limit = (SAME * deviation).powi(2) * one.len() as f64;
    let mut sum = 0.0;
    one.iter().zip(other).all(|(x, y)| {
        let square = (x - y).powi(2);
        sum += if square.is_nan() { 0.0 } else { square };
        sum <= limit
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: u64, rows: usize) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / 2_147_483_648.0 - 0.5
        };
        (0..rows).map(|_| next()).collect()
    }

    #[test]
    fn lags_of_whole_and_half_rows_are_found() {
        let x = noise(1, 4000);
        let smooth: Vec<f64> = (2..3900).map(|k| x[k] + x[k - 1] + x[k - 2]).collect();
        let later = |rows: usize| smooth[..3000 - rows].to_vec();
        let (found, likeness) = lag(&smooth[7..3000], &later(7)).expect("alike");
        assert!((found - 7.0).abs() < 0.05 && likeness > 0.99, "{found}");
        let half: Vec<f64> = smooth.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        let (found, _) = lag(&half[..2000], &smooth[..2000]).expect("alike");
        assert!((found - 0.5).abs() < 0.1, "{found}");
        assert!(lag(&noise(2, 4000), &noise(3, 4000)).is_none());
    }

    #[test]
    fn equal_traces_are_found_under_rounding() {
        let (one, other) = (noise(4, 600), noise(5, 600));
        let rounded: Vec<f64> = one.iter().map(|x| (x * 1e5).round() / 1e5).collect();
        assert_eq!(equal(&[vec![&one[..]], vec![&other], vec![&rounded]]), [[0, 2]]);
        // A large angle that all have makes others no less different, and a late difference counts.
        let angle: Vec<f64> = (0..600).map(|k| 1e5 + f64::from(k)).collect();
        assert!(equal(&[vec![&one[..], &angle], vec![&other, &angle]]).is_empty());
        let mut late = one.clone();
        late[580] += 1.0;
        assert!(equal(&[vec![&one[..]], vec![&late]]).is_empty());
        let mut lacking = one.clone();
        (lacking[3], lacking[99]) = (f64::NAN, f64::NAN);
        assert!((correlation(&one, &lacking) - 1.0).abs() < 1e-12 && correlation(&one, &[f64::NAN; 600]) == 0.0);
        assert_eq!(equal(&[vec![&lacking[..]], vec![&lacking]]), [[0, 1]]);
        let scaled: Vec<f64> = one.iter().map(|x| 3.0 * x + 1.0).collect();
        assert!((correlation(&one, &scaled) - 1.0).abs() < 1e-12 && correlation(&one, &[2.0; 600]) == 0.0);
    }

    #[test]
    fn a_lag_outside_of_the_searched_ones_is_not_told() {
        let x = noise(6, 4000);
        let smooth: Vec<f64> = x.windows(40).map(|rows| rows.iter().sum::<f64>()).collect();
        let smoother: Vec<f64> = smooth.windows(40).map(|rows| rows.iter().sum::<f64>()).collect();
        let later = |rows: usize| lag(&smoother[rows..3000], &smoother[..3000 - rows]);
        assert!(later(49).is_some_and(|(found, _)| (found - 49.0).abs() < 0.1));
        assert!([50, 51, 55].iter().all(|rows| later(*rows).is_none()), "{:?}", later(51));
    }
}
