//! Converts coordinates to compact SVG text.
//!
//! Drawing units equal pixels at full page width. One path element contains a whole series or all markers of a
//! class, with coordinates rounded to a tenth of a unit and written relative to each other; this needs much less space
//! than one element per point.

use std::fmt::Write as _;

use super::super::escape::escape;
use super::super::palette::Marker;

/// Horizontal alignment of a text relative to its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// An SVG element under construction.
#[derive(Debug, Clone, Default)]
pub(super) struct Svg {
    body: String,
}

impl Svg {
    pub(super) fn new() -> Self {
        Self::default()
    }

    /// Adds a path; `attributes` must already be valid markup. An empty path is omitted.
    pub(super) fn path(&mut self, attributes: &str, d: &str) {
        if !d.is_empty() {
            // Writing to a String cannot fail.
            let _ = write!(self.body, "<path {attributes} d=\"{d}\"/>");
        }
    }

    pub(super) fn rect(&mut self, attributes: &str, x: f64, y: f64, width: f64, height: f64) {
        let (x, y, width, height) = (num(x), num(y), num(width), num(height));
        let _ = write!(self.body, "<rect {attributes} x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>");
    }

    /// Adds text centred vertically on `y`, without using the metrics of the font.
    pub(super) fn text(&mut self, attributes: &str, anchor: Anchor, x: f64, y: f64, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (x, y, text) = (num(x), num(y), escape(text));
        let _ = write!(
            self.body,
            "<text {attributes} x=\"{x}\" y=\"{y}\" dy=\".35em\" text-anchor=\"{anchor}\">{text}</text>"
        );
    }

    /// The finished element. It scales with the page; `label` is its text for screen readers.
    pub(super) fn finish(&self, label: &str, width: f64, height: f64) -> String {
        let (label, width, height) = (escape(label), num(width), num(height));
        format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\">{}</svg>", self.body)
    }
}

impl Svg {
    /// The finished element as a file with a style sheet of its own.
    pub(super) fn standalone(&self, label: &str, (width, height): (f64, f64), style: &str) -> String {
        let own =
            format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" ", num(width), num(height));
        let text = self.finish(label, width, height).replacen("<svg ", &own, 1);
        text.replacen('>', &format!("><style>{style}</style>"), 1) + "\n"
    }
}

/// A coordinate rounded to a tenth, in its shortest form: `12.5`, `-.3`, `7`.
pub(super) fn num(value: f64) -> String {
    let mut out = String::new();
    push_tenths(&mut out, tenths(value));
    out
}

/// A polyline as path data: the first point absolute, the others relative.
pub(super) fn polyline(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut out = String::new();
    let mut last = None;
    for (x, y) in points {
        let (x, y) = (tenths(x), tenths(y));
        match last {
            None => push_pair(&mut out, 'M', x, y),
            // Differences of rounded positions, so that rounding errors do not accumulate along the line.
            Some((x0, y0)) => push_pair(&mut out, 'l', x - x0, y - y0),
        }
        last = Some((x, y));
    }
    if last.is_some() && !out.contains('l') {
        // A single point: a line of zero length is drawn as a dot with round caps.
        out.push_str("h0");
    }
    out
}

/// All markers of one shape as the data of one path.
pub(super) fn markers(marker: Marker, points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut out = String::new();
    for (x, y) in points {
        push_pair(&mut out, 'M', tenths(x), tenths(y));
        out.push_str(marker.steps());
    }
    out
}

/// A filled rectangle as path data.
pub(super) fn block(x0: f64, y0: f64, x1: f64, y1: f64) -> String {
    format!("M{} {}H{}V{}H{}z", num(x0), num(y0), num(x1), num(y1), num(x0))
}

/// Rising diagonal lines that fill a rectangle. All rectangles of a drawing use the same line positions, so that the
/// lines of adjacent rectangles join. A `<pattern>` would need an id that is unique on the page.
pub(super) fn hatch(x0: f64, y0: f64, x1: f64, y1: f64) -> String {
    const SPACING: f64 = 7.0;
    let mut out = String::new();
    // On a rising diagonal x + y is constant.
    let mut sum = ((x0 + y0) / SPACING).ceil() * SPACING;
    while sum < x1 + y1 {
        let (left, right) = (x0.max(sum - y1), x1.min(sum - y0));
        if right - left > 0.05 {
            let _ = write!(out, "M{} {}L{} {}", num(left), num(sum - left), num(right), num(sum - right));
        }
        sum += SPACING;
    }
    out
}

#[expect(clippy::cast_possible_truncation, reason = "coordinates are a few thousand tenths; casts saturate")]
fn tenths(value: f64) -> i64 {
    (value * 10.0).round() as i64
}

fn push_tenths(out: &mut String, value: i64) {
    let (sign, whole, part) = (if value < 0 { "-" } else { "" }, value.abs() / 10, value.abs() % 10);
    let _ = match (whole, part) {
        (whole, 0) => write!(out, "{sign}{whole}"),
        (0, part) => write!(out, "{sign}.{part}"),
        (whole, part) => write!(out, "{sign}{whole}.{part}"),
    };
}

/// Appends a pair of numbers; a minus sign separates them, so no space is needed before it.
fn push_pair(out: &mut String, command: char, x: i64, y: i64) {
    out.push(command);
    push_tenths(out, x);
    if y >= 0 {
        out.push(' ');
    }
    push_tenths(out, y);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let written: Vec<String> = [12.5, -0.3, 7.0, -0.04, 0.0].into_iter().map(num).collect();
        assert_eq!(written, ["12.5", "-.3", "7", "0", "0"]);
    }

    #[test]
    fn polyline_is_relative_without_drift() {
        assert_eq!(polyline([(1.0, 2.0), (2.04, 1.0), (3.08, 3.0)]), "M1 2l1-1l1.1 2");
        assert_eq!(polyline([(1.0, 2.0)]), "M1 2h0");
        assert_eq!(polyline([]), "");
    }

    #[test]
    fn hatch_stays_inside_its_rectangle() {
        let d = hatch(10.0, 20.0, 24.0, 27.0);
        let numbers: Vec<f64> =
            d.split(['M', 'L', ' ']).filter(|s| !s.is_empty()).map(|s| s.parse().expect("a number")).collect();
        assert!(!numbers.is_empty());
        for pair in numbers.chunks(2) {
            assert!((10.0..=24.0).contains(&pair[0]) && (20.0..=27.0).contains(&pair[1]), "{pair:?}");
        }
    }
}
