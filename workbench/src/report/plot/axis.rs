//! Axis with round tick values and short labels, computed from the range of the data.
//!
//! Labels of very large or small values share one power of ten, which is written in the axis title:
//!
//! ```text
//! tick = label · 10^(3k)        0 ≤ k chosen when |tick| ≥ 10⁵ or |tick| < 10⁻²
//! step ∈ {1, 2, 5} · 10^n
//! ```

/// Width of a label's character and height of a label at the larger of the two text sizes of the style sheet
/// (phone), in drawing units. This space is reserved, so that labels fit at every page width.
pub(super) const CHAR_WIDTH: f64 = 11.0;
pub(super) const LABEL_HEIGHT: f64 = 22.0;

/// Whether the value is finite and small enough that a range of these values does not overflow.
pub(super) fn usable(value: f64) -> bool {
    value.abs() < 1e150
}

/// A range in data units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub(super) lo: f64,
    pub(super) hi: f64,
}

impl Range {
    /// The range of the usable values; `None` if there are none.
    pub(super) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        values.into_iter().filter(|&v| usable(v)).fold(None, |range: Option<Self>, v| {
            Some(range.map_or(Self { lo: v, hi: v }, |r| Self { lo: r.lo.min(v), hi: r.hi.max(v) }))
        })
    }

    /// Like [`Range::of`], but a few outliers do not widen it: at most 40 % of the width of the central 96 % is added
    /// on either side. Normally distributed points normally lie within this range.
    pub(super) fn robust(values: impl IntoIterator<Item = f64>) -> Option<Self> {
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
    pub(super) fn padded(self, share: f64) -> Self {
        let size = self.lo.abs().max(self.hi.abs());
        let width = self.hi - self.lo;
        if width <= size * 1e-12 {
            let half = if size > 0.0 { size * 0.1 } else { 1.0 };
            return Self { lo: self.lo - half, hi: self.hi + half };
        }
        Self { lo: self.lo - share * width, hi: self.hi + share * width }
    }

    pub(super) fn contains(self, value: f64) -> bool {
        (self.lo..=self.hi).contains(&value)
    }
}

/// A range with ticks, laid out along `from..to` in drawing units.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub(super) range: Range,
    from: f64,
    to: f64,
    /// Tick values in data units.
    pub(super) ticks: Vec<f64>,
    exponent: i32,
    decimals: usize,
    /// If true, values are decimal logarithms of the labelled values.
    logarithmic: bool,
}

impl Axis {
    /// A horizontal axis whose values are decimal logarithms. The ticks are the powers of ten; over few decades also
    /// 2 and 5 times these powers.
    pub(super) fn decades(range: Range, left: f64, right: f64) -> Self {
        let steps: &[f64] = if range.hi - range.lo > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let (first, last) = (floor_to_i32(range.lo), floor_to_i32(range.hi));
        let all = (first..=last).flat_map(|power| steps.iter().map(move |step| f64::from(power) + step.log10()));
        let ticks: Vec<f64> = all.filter(|&tick| range.contains(tick)).collect();
        Self { range, from: left, to: right, ticks, exponent: 0, decimals: 0, logarithmic: true }
    }

    /// A horizontal axis with the largest number of ticks whose labels fit side by side.
    pub(super) fn horizontal(range: Range, left: f64, right: f64) -> Self {
        let room = |axis: &Self| {
            let spacing = (right - left) * axis.step() / (range.hi - range.lo);
            axis.label_width() + 1.5 * CHAR_WIDTH <= spacing
        };
        (3..=8u8)
            .rev()
            .map(|count| Self::new(range, left, right, count))
            .find(room)
            .unwrap_or_else(|| Self::new(range, left, right, 2))
    }

    /// A vertical axis; values increase upwards.
    pub(super) fn vertical(range: Range, top: f64, bottom: f64) -> Self {
        let fits = ((bottom - top) / (1.3 * LABEL_HEIGHT)).floor();
        let count = (2..=8u8).rev().find(|&n| f64::from(n) <= fits).unwrap_or(2);
        // A low panel may contain only one tick between two round steps: then a smaller step is tried.
        let finer = (count..=count + 3).map(|count| Self::new(range, bottom, top, count));
        finer.into_iter().find(|axis| axis.ticks.len() > 1).unwrap_or_else(|| Self::new(range, bottom, top, count))
    }

    fn new(range: Range, from: f64, to: f64, count: u8) -> Self {
        let step = nice_step((range.hi - range.lo) / f64::from(count));
        let first = (range.lo / step - 1e-9).ceil();
        let mut ticks = Vec::new();
        let mut k = 0.0;
        while (first + k) * step <= range.hi + 1e-9 * step && ticks.len() < 20 {
            ticks.push((first + k) * step);
            k += 1.0;
        }
        let largest = ticks.iter().fold(0.0_f64, |a, t| a.max(t.abs()));
        let exponent =
            if largest > 0.0 && !(1e-2..1e5).contains(&largest) { floor_to_i32(largest.log10() / 3.0) * 3 } else { 0 };
        let decimals = (exponent - floor_to_i32(step.log10() + 1e-9)).clamp(0, 15);
        Self { range, from, to, ticks, exponent, decimals: usize::try_from(decimals).unwrap_or(0), logarithmic: false }
    }

    /// The same axis without ticks below zero, because other marks are drawn there.
    pub(super) fn above_zero(mut self) -> Self {
        self.ticks.retain(|&tick| tick >= 0.0);
        self
    }

    /// The same range without ticks, for a panel without data.
    pub(super) fn without_ticks(self) -> Self {
        Self { ticks: Vec::new(), ..self }
    }

    fn step(&self) -> f64 {
        match self.ticks.as_slice() {
            [a, b, ..] => b - a,
            _ => self.range.hi - self.range.lo,
        }
    }

    /// Position of a value in drawing units.
    pub(super) fn at(&self, value: f64) -> f64 {
        self.from + (value - self.range.lo) / (self.range.hi - self.range.lo) * (self.to - self.from)
    }

    /// The value at a position in drawing units.
    pub(super) fn value(&self, position: f64) -> f64 {
        self.range.lo + (position - self.from) / (self.to - self.from) * (self.range.hi - self.range.lo)
    }

    /// The text of a tick label, with a typographic minus sign.
    pub(super) fn label(&self, tick: f64) -> String {
        if self.logarithmic {
            // Two digits suffice for 1, 2 and 5 times a power of ten.
            let decimals = usize::try_from(1 - floor_to_i32(tick + 1e-9)).unwrap_or(0);
            let text = format!("{:.decimals$}", 10f64.powf(tick));
            let short = text.trim_end_matches('0').trim_end_matches('.');
            return if text.contains('.') { short.to_owned() } else { text };
        }
        let scaled = tick / 10f64.powi(self.exponent);
        let text = format!("{scaled:.*}", self.decimals);
        match text.strip_prefix('-') {
            // Rounding may leave "-0.0": omit its sign.
            Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
            Some(rest) => format!("−{rest}"),
            None => text,
        }
    }

    /// Width of the widest label.
    pub(super) fn label_width(&self) -> f64 {
        let longest = self.ticks.iter().map(|&t| self.label(t).chars().count()).max().unwrap_or(0);
        CHAR_WIDTH * f64::from(u16::try_from(longest).unwrap_or(u16::MAX))
    }

    /// The axis title with the labels' common power of ten, if they have one.
    pub(super) fn title(&self, title: &str) -> String {
        if self.exponent == 0 {
            return title.to_owned();
        }
        let digit = |c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            // The other superscripts are consecutive in Unicode, starting at ⁰.
            c => char::from_u32(0x2070 + c as u32 - '0' as u32).unwrap_or(c),
        };
        format!("{title}  (×10{})", self.exponent.to_string().chars().map(digit).collect::<String>())
    }
}

/// The smallest of 1, 2, 5 and 10 times a power of ten that is not below `raw`.
fn nice_step(raw: f64) -> f64 {
    let power = 10f64.powf(raw.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= raw * (1.0 - 1e-9)).unwrap_or(10.0);
    factor * power
}

#[expect(clippy::cast_possible_truncation, reason = "logarithms of finite values are within ±400")]
fn floor_to_i32(value: f64) -> i32 {
    value.floor() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(lo: f64, hi: f64) -> (Vec<String>, String) {
        let axis = Axis::new(Range { lo, hi }, 0.0, 100.0, 5);
        (axis.ticks.iter().map(|&t| axis.label(t)).collect(), axis.title("y"))
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(-0.23, 1.04).0, ["0.0", "0.5", "1.0"]);
        assert_eq!(labels(-10.0, 10.0).0, ["−10", "−5", "0", "5", "10"]);
        assert_eq!(
            labels(0.0, 2.5e6),
            (
                vec!["0.0".into(), "0.5".into(), "1.0".into(), "1.5".into(), "2.0".into(), "2.5".into()],
                "y  (×10⁶)".into()
            )
        );
        assert_eq!(labels(0.0, 4e-6).1, "y  (×10⁻⁶)");
    }

    #[test]
    fn extreme_and_constant_ranges_stay_finite() {
        for (lo, hi) in [(0.0, 0.0), (5.0, 5.0), (-1e149, 1e149), (1e-300, 1e-300), (1e9, 1e9 + 1e-3)] {
            let axis = Axis::horizontal(Range { lo, hi }.padded(0.05), 60.0, 740.0);
            assert!(!axis.ticks.is_empty() && axis.ticks.len() <= 20, "{lo} {hi}: {:?}", axis.ticks);
            assert!(axis.at(lo).is_finite() && (60.0..=740.0).contains(&axis.at(hi)));
        }
    }

    #[test]
    fn a_second_of_unix_time_keeps_its_ticks_apart() {
        let axis = Axis::horizontal(Range { lo: 1.7e9, hi: 1.7e9 + 1.0 }.padded(0.0), 60.0, 740.0);
        let mut labels: Vec<String> = axis.ticks.iter().map(|&t| axis.label(t)).collect();
        let count = labels.len();
        labels.dedup();
        assert!(count >= 3 && labels.len() == count, "{labels:?}");
    }

    #[test]
    fn robust_range_ignores_a_lone_outlier() {
        let values = || (0..200).map(f64::from);
        assert_eq!(Range::robust(values()), Range::of(values()));
        let range = Range::robust(values().chain([1e6])).expect("has values");
        assert!(range.hi < 400.0 && range.lo == 0.0);
        assert_eq!(Range::robust([f64::NAN]), None);
    }

    #[test]
    fn value_inverts_at() {
        let axis = Axis::vertical(Range { lo: -2.0, hi: 6.0 }, 10.0, 210.0);
        assert!((axis.value(axis.at(1.25)) - 1.25).abs() < 1e-12);
        assert!(axis.at(6.0) < axis.at(-2.0), "up the page is up in value");
    }

    #[test]
    fn decades_say_what_their_logarithms_mean() {
        let labels = |lo: f64, hi: f64| {
            let axis = Axis::decades(Range { lo, hi }, 0.0, 100.0);
            axis.ticks.iter().map(|&t| axis.label(t)).collect::<Vec<_>>()
        };
        assert_eq!(labels(-2.0, 2.3), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(0.5, 2.4), ["5", "10", "20", "50", "100", "200"]);
    }
}
