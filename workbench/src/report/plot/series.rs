//! A named series of points, drawn as a line.

use super::super::palette::{Color, Marker};
use super::axis::{Axis, Range, usable};
use super::decimate::runs;
use super::frame::{Area, Key};
use super::svg::{Svg, markers, polyline};

/// One line of a plot. Non-finite points leave a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Colour of the line.
    pub color: Color,
    /// Points (x, y) in the order they are joined.
    pub points: Vec<(f64, f64)>,
    /// If true, the line is dashed; for thresholds and references.
    pub dashed: bool,
    /// Marker at every point, if set.
    pub marker: Option<Marker>,
    /// Shaded interval (x, low, high) around the line, for example a 95 % interval.
    pub band: Vec<(f64, f64, f64)>,
}

impl Series {
    /// A solid line without markers.
    #[must_use]
    pub fn new(name: impl Into<String>, color: Color, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points = points.into_iter().collect();
        Self { name: name.into(), color, points, dashed: false, marker: None, band: Vec::new() }
    }

    /// The same series with a dashed line.
    #[must_use]
    pub fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }

    /// The same series with every point marked; for series of a few dozen points.
    #[must_use]
    pub fn marked(self, marker: Marker) -> Self {
        Self { marker: Some(marker), ..self }
    }

    /// The same series with a shaded interval (x, low, high).
    #[must_use]
    pub fn with_band(self, band: impl IntoIterator<Item = (f64, f64, f64)>) -> Self {
        Self { band: band.into_iter().collect(), ..self }
    }

    pub(super) fn key(&self) -> (Key, String) {
        (Key::Line { color: self.color, dashed: self.dashed, marker: self.marker }, self.name.clone())
    }

    fn finite(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.points.iter().copied().filter(|&(x, y)| usable(x) && usable(y))
    }

    fn finite_band(&self) -> impl DoubleEndedIterator<Item = (f64, f64, f64)> + '_ {
        self.band.iter().copied().filter(|&(x, low, high)| usable(x) && usable(low) && usable(high))
    }

    pub(super) fn missing(&self) -> usize {
        self.points.len() - self.finite().count()
    }

    /// Draws band, line and markers.
    pub(super) fn draw(&self, svg: &mut Svg, area: Area, x: &Axis, y: &Axis) {
        let Self { color, .. } = self;
        let place = |&(px, py): &(f64, f64)| (x.at(px), y.at(py));
        let lower = self.finite_band().map(|(at, low, _)| (at, low));
        let upper = self.finite_band().rev().map(|(at, _, high)| (at, high));
        let outline: Vec<(f64, f64)> = lower.chain(upper).collect();
        svg.path(&format!("class=\"band\" fill=\"{color}\""), &polyline(outline.iter().map(place)));

        let columns = area.right - area.left;
        let line: String = runs(&self.points, x.range.lo, x.range.hi, columns)
            .iter()
            .map(|run| polyline(run.iter().map(place)))
            .collect();
        let class = if self.dashed { "line dashed" } else { "line" };
        svg.path(&format!("class=\"{class}\" stroke=\"{color}\""), &line);
        if let Some(marker) = self.marker {
            let points = self.finite().map(|point| place(&point));
            svg.path(&format!("class=\"dot\" fill=\"{color}\""), &markers(marker, points));
        }
    }
}

/// The range of all series and their bands along x; `None` without a finite point.
pub(super) fn x_range<'a>(series: impl Iterator<Item = &'a Series> + Clone) -> Option<Range> {
    let bands = series.clone().flat_map(|s| s.finite_band().map(|b| b.0));
    Range::of(series.flat_map(|s| s.finite().map(|p| p.0)).chain(bands))
}

/// The range of all series and their bands along y; `None` without a finite point.
pub(super) fn y_range(series: &[Series]) -> Option<Range> {
    let bands = series.iter().flat_map(|s| s.finite_band().flat_map(|b| [b.1, b.2]));
    Range::of(series.iter().flat_map(|s| s.finite().map(|p| p.1)).chain(bands))
}
