//! A named series of points, drawn as a line.

use super::drawing::decimate::runs;
use super::drawing::figure::text;
use super::drawing::numbers::{Range, usable};
use super::drawing::plotly::{DashType, Fill, HoverInfo, Line, Mode, Scatter};
use crate::page::palette::{Color, Marker};

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
    /// Whether a line joins the points; else there are markers only.
    pub joined: bool,
    /// Shaded interval (x, low, high) around the line, for example a 95 % interval.
    pub band: Vec<(f64, f64, f64)>,
}

/// Where and how the series of a figure are drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawing<'a> {
    /// Name of the vertical axis, `y2`.
    pub(super) axis: &'a str,
    pub(super) x: Range,
    pub(super) y: Range,
    /// Columns to which a series is reduced; `None` draws all points.
    pub(super) columns: Option<f64>,
    /// Whether the legend has an entry for it.
    pub(super) in_legend: bool,
}

impl Series {
    /// A solid line without markers.
    #[must_use]
    pub fn new(name: impl Into<String>, color: Color, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points = points.into_iter().collect();
        Self { name: name.into(), color, points, dashed: false, marker: None, joined: true, band: Vec::new() }
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

    /// Points without a line between them, of values that have nothing in between.
    #[must_use]
    pub fn points(
        name: impl Into<String>,
        color: Color,
        marker: Marker,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self { joined: false, ..Self::new(name, color, points).marked(marker) }
    }

    /// An upright line for each of these intervals (x, low, high).
    #[must_use]
    pub fn intervals(
        name: impl Into<String>,
        color: Color,
        intervals: impl IntoIterator<Item = (f64, f64, f64)>,
    ) -> Self {
        let upright = |(x, low, high)| [(f64::NAN, f64::NAN), (x, low), (x, high)];
        // No gap before the first.
        Self::new(name, color, intervals.into_iter().flat_map(upright).skip(1))
    }

    /// The same series with a shaded interval (x, low, high).
    #[must_use]
    pub fn with_band(self, band: impl IntoIterator<Item = (f64, f64, f64)>) -> Self {
        Self { band: band.into_iter().collect(), ..self }
    }

    fn finite(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.points.iter().copied().filter(|&(x, y)| usable(x) && usable(y))
    }

    fn finite_band(&self) -> impl DoubleEndedIterator<Item = (f64, f64, f64)> + '_ {
        self.band.iter().copied().filter(|&(x, low, high)| usable(x) && usable(low) && usable(high))
    }

    /// Values that are not drawn. A point without a place is a gap on purpose.
    pub(super) fn missing(&self) -> usize {
        self.points.iter().filter(|&&(x, y)| !(x.is_nan() || usable(x) && usable(y))).count()
    }

    /// Band, then line and markers.
    pub(super) fn traces(&self, at: Drawing) -> Vec<Scatter> {
        let mut traces = Vec::new();
        let (name, color) = (text(&self.name), self.color.to_string());
        let Drawing { x, y, axis, in_legend, .. } = at;
        if !self.band.is_empty() {
            let lower = self.finite_band().map(|(at, low, _)| (at, low));
            let upper = self.finite_band().rev().map(|(at, _, high)| (at, high));
            let outline: Vec<(f64, f64)> = lower.chain(upper).collect();
            traces.push(
                Scatter::new(rounded(x, outline.iter().map(|p| p.0)), rounded(y, outline.iter().map(|p| p.1)))
                    .name(&name)
                    .legend_group(&name)
                    .show_legend(false)
                    .mode(Mode::None)
                    .fill(Fill::ToSelf)
                    .fill_color(self.color.tint(0.18))
                    .hover_info(HoverInfo::Skip)
                    .y_axis(axis),
            );
        }
        let drawn = self.reduced(x, at.columns);
        let line = Line::new().color(color.clone()).width(1.4);
        let line = if self.dashed { line.dash(DashType::Dash) } else { line };
        let trace = Scatter::new(rounded(x, drawn.iter().map(|p| p.0)), rounded(y, drawn.iter().map(|p| p.1)))
            .name(&name)
            .legend_group(&name)
            .show_legend(in_legend)
            .line(line)
            .y_axis(axis);
        traces.push(match self.marker {
            Some(marker) => {
                let mode = if self.joined { Mode::LinesMarkers } else { Mode::Markers };
                trace.mode(mode).marker(marker.filled(&color, 8))
            }
            None => trace.mode(Mode::Lines),
        });
        traces
    }

    /// The points as drawn: reduced, with a point without value in each gap.
    fn reduced(&self, x: Range, columns: Option<f64>) -> Vec<(f64, f64)> {
        let Some(columns) = columns else { return self.points.clone() };
        let runs = runs(&self.points, x.lo, x.hi, columns);
        let mut drawn: Vec<(f64, f64)> = Vec::new();
        for run in runs {
            if let (false, Some(first)) = (drawn.is_empty(), run.first()) {
                drawn.push((first.0, f64::NAN));
            }
            drawn.extend(run);
        }
        drawn
    }

    /// Whether the reduction leaves points out.
    pub(super) fn is_reduced(&self, x: Range, columns: Option<f64>) -> bool {
        self.reduced(x, columns).len() < self.points.len()
    }
}

pub(super) fn rounded(range: Range, values: impl Iterator<Item = f64>) -> Vec<f64> {
    values.map(|value| range.rounded(value)).collect()
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
