//! Values that are no measurements: codes in the place of a missing value.
//!
//! ```text
//! a code    the least or largest value, equal in several rows, 20 widths w of the others away from them; 1/2 of their
//!           range for values that loggers write for missing ones (−9999, −32768, 65535, …)
//! ```

/// Widths of all values but the outermost hundredth, and the largest part of rows that are rare.
const WIDTHS: f64 = 20.0;
const RARE: f64 = 0.01;
/// Fewest rows that are looked at, and largest part of the rows that are usual codes, or other values: a tenth of the
/// rows is a state of the machine.
const FEWEST: usize = 100;
const MOST: f64 = 0.5;
const MOST_OTHERS: f64 = 0.05;
/// Distance of a usual code from the others, in their range.
const GAP: f64 = 0.5;
/// Values that loggers and drives write where nothing was measured.
const CODES: [f64; 22] = [
    -999.0,
    -9999.0,
    -99_999.0,
    -999_999.0,
    -999.25,
    -999.9,
    999.0,
    9999.0,
    99_999.0,
    999_999.0,
    -128.0,
    -32_768.0,
    32_767.0,
    65_535.0,
    -2_147_483_648.0,
    2_147_483_647.0,
    4_294_967_295.0,
    9.9e37,
    9.91e37,
    1e30,
    -1e30,
    3.402_823_466_385_288_6e38,
];

/// The first row far outside of all others, and how many are; the values are sorted beside them.
pub(crate) fn outside(x: &[f64], sorted: &[f64]) -> Option<(usize, usize)> {
    if sorted.len() < FEWEST {
        return None;
    }
    let at = |part: f64| sorted[((sorted.len() - 1) as f64 * part) as usize];
    let (low, high) = (at(0.5 * RARE), at(1.0 - 0.5 * RARE));
    let width = high - low;
    let is_outside = |x: &f64| width > 0.0 && (*x > high + WIDTHS * width || *x < low - WIDTHS * width);
    match x.iter().position(is_outside) {
        Some(first) => Some((first, x.iter().filter(|x| is_outside(x)).count())),
        None => {
            let code = code(sorted)?;
            Some((x.iter().position(|x| *x == code)?, x.iter().filter(|x| **x == code).count()))
        }
    }
}

/// The least or largest value, if it is a code.
fn code(sorted: &[f64]) -> Option<f64> {
    let (least, largest) = (*sorted.first()?, *sorted.last()?);
    let below = sorted.partition_point(|x| *x <= least);
    let above = sorted.partition_point(|x| *x < largest);
    let is_code = |value: f64, count: usize, others: &[f64]| {
        let (Some(low), Some(high)) = (others.first(), others.last()) else { return false };
        let distance = (low - value).max(value - high);
        let (widths, most) = if CODES.contains(&value) { (GAP, MOST) } else { (WIDTHS, MOST_OTHERS) };
        let is_rare = count >= 2 && (count as f64) < most * sorted.len() as f64;
        is_rare && high > low && distance > widths * (high - low)
    };
    if is_code(least, below, &sorted[below..]) {
        return Some(least);
    }
    is_code(largest, sorted.len() - above, &sorted[..above]).then_some(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(size: f64) -> Vec<f64> {
        (0..2000).map(|k| size * (0.037 * f64::from(k)).sin() + 0.01 * f64::from(k * 7 % 11)).collect()
    }

    fn sorted(x: &[f64]) -> Vec<f64> {
        let mut sorted = x.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted
    }

    #[test]
    fn codes_are_found_however_many_there_are() {
        for (code, every, size) in [
            (-9999.0, 100, 5.0),
            (-9999.0, 7, 5.0),
            (-32_768.0, 50, 3000.0),
            (32_767.0, 30, 12_000.0),
            (9.9e37, 20, 1.0),
            (65_535.0, 9, 20_000.0),
            (1e6, 25, 10.0),
        ] {
            let mut x = wave(size);
            x.iter_mut().skip(3).step_by(every).for_each(|x| *x = code);
            let found = outside(&x, &sorted(&x));
            assert_eq!(found, Some((3, (2000 - 3_usize).div_ceil(every))), "{code} every {every}");
        }
        for x in [wave(5.0), wave(32_767.0), wave(5.0).iter().map(|x| x.min(4.0)).collect()] {
            assert_eq!(outside(&x, &sorted(&x)), None);
        }
    }
}
