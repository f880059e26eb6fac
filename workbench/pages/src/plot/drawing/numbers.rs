//! Ranges of data, and numbers with as many digits as a plot shows.

/// Whether the value is finite and small enough that a range of these values does not overflow.
pub(in crate::plot) fn usable(value: f64) -> bool {
    value.abs() < 1e150
}

/// A range in data units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plot) struct Range {
    pub(in crate::plot) lo: f64,
    pub(in crate::plot) hi: f64,
}

impl Range {
    /// The range of the usable values; `None` if there are none.
    pub(in crate::plot) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        values.into_iter().filter(|&v| usable(v)).fold(None, |range: Option<Self>, v| {
            Some(range.map_or(Self { lo: v, hi: v }, |r| Self { lo: r.lo.min(v), hi: r.hi.max(v) }))
        })
    }

    /// Like [`Range::of`], but a few outliers do not widen it: at most 40 % of the width of the central 96 % is added
    /// on either side. Normally distributed points normally lie within this range.
    pub(in crate::plot) fn robust(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().filter(|&v| usable(v)).collect();
        sorted.sort_by(f64::total_cmp);
        let (&lo, &hi) = (sorted.first()?, sorted.last()?);
        let skipped = sorted.len() / 50;
        let (low, high) = (sorted[skipped], sorted[sorted.len() - 1 - skipped]);
        let width = high - low;
        // If nearly all values are equal, the central width is zero and the full range is used.
        if width > 0.0 {
            Some(Self { lo: lo.max(low - 0.4 * width), hi: hi.min(high + 0.4 * width) })
        } else {
            Some(Self { lo, hi })
        }
    }

    /// Widens the range by a share of its width on both sides; a range of zero width is widened by 10 % of its value.
    pub(in crate::plot) fn padded(self, share: f64) -> Self {
        let size = self.lo.abs().max(self.hi.abs());
        let width = self.width();
        if width <= size * 1e-12 {
            let half = if size > 0.0 { size * 0.1 } else { 1.0 };
            return Self { lo: self.lo - half, hi: self.hi + half };
        }
        Self { lo: self.lo - share * width, hi: self.hi + share * width }
    }

    pub(in crate::plot) fn contains(self, value: f64) -> bool {
        (self.lo..=self.hi).contains(&value)
    }

    pub(in crate::plot) fn width(self) -> f64 {
        self.hi - self.lo
    }

    pub(in crate::plot) fn axis(self) -> [f64; 2] {
        [self.rounded(self.lo), self.rounded(self.hi)]
    }

    /// The value rounded to about a millionth of the range; values that are not usable become NaN, which leaves a gap.
    pub(in crate::plot) fn rounded(self, value: f64) -> f64 {
        if !usable(value) {
            return f64::NAN;
        }
        let places = 6.0 - self.width().max(f64::MIN_POSITIVE).log10().floor();
        if !(-300.0..=300.0).contains(&places) {
            return value;
        }
        let scale = 10.0_f64.powi(places as i32);
        let rounded = (value * scale).round() / scale;
        if rounded.is_finite() { rounded } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_outliers_do_not_widen_a_robust_range() {
        let values = (0..1000).map(f64::from).chain([1e9, f64::NAN]);
        let range = Range::robust(values).expect("values");
        assert!(range.lo <= 0.0 && range.contains(999.0) && range.hi < 1500.0, "{range:?}");
        assert_eq!(Range::robust([f64::NAN]), None);
    }

    #[test]
    fn numbers_keep_what_the_range_resolves() {
        let range = Range { lo: 0.0, hi: 10.0 };
        assert_eq!(range.rounded(1.234_567_89).to_string(), "1.23457");
        let far = Range { lo: 1.7e9, hi: 1.7e9 + 1.0 };
        assert!((far.rounded(1.7e9 + 0.123_456) - (1.7e9 + 0.123_456)).abs() < 1e-6);
        assert!(range.rounded(f64::INFINITY).is_nan());
        assert!(Range { lo: 3.0, hi: 3.0 }.rounded(3.5) > 3.4);
    }
}
