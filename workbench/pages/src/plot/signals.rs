//! Series in stacked panels over one horizontal axis: signals over time with events, spectra, rates over a size.

use super::drawing::figure::Figure;
use super::drawing::numbers::{Range, usable};
use super::drawing::plotly::{Axis, AxisType};
use super::drawing::stack::{Across, Row, axis_name, stack_below, vertical};
use super::events::{Event, mark};
use super::series::{Drawing, Series, x_range, y_range};
use super::strip::Strip;
use crate::ReportError;

/// Heights in pixels: of a plot of lines, of a single panel of signals, of one of several.
const LINES: f64 = 320.0;
const SINGLE: f64 = 260.0;
const STACKED: f64 = 130.0;
/// Points of one figure, so that a page stays small; columns of one series.
const POINTS: f64 = 16_000.0;
const COLUMNS: [f64; 2] = [100.0, 1000.0];
/// A first view of all points.
const WHOLE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Signals that share a vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Title of the vertical axis with its unit, for example `phase current / A`.
    pub label: String,
    /// The signals, with points (time in seconds, value).
    pub series: Vec<Series>,
}

impl Panel {
    /// A panel of several signals.
    #[must_use]
    pub fn new(label: impl Into<String>, series: Vec<Series>) -> Self {
        Self { label: label.into(), series }
    }
}

/// A line plot with one vertical axis. The axis titles should contain the unit, for example `speed / rad·s⁻¹`.
///
/// # Errors
/// [`ReportError::Empty`] if no series has a finite point.
pub fn lines(title: &str, x_label: &str, y_label: &str, series: &[Series]) -> Result<String, ReportError> {
    stacked(title, &Axes::of_lines(x_label), &[Panel::new(y_label, series.to_vec())], &[], &[])
}

/// Same as [`lines`], whose first view ends at `view` where points lie outside it; they are counted.
///
/// # Errors
/// [`ReportError::Empty`] if no series has a finite point.
pub fn lines_within(
    view: [f64; 2],
    title: &str,
    x_label: &str,
    y_label: &str,
    series: &[Series],
) -> Result<String, ReportError> {
    let axes = Axes { view, ..Axes::of_lines(x_label) };
    stacked(title, &axes, &[Panel::new(y_label, series.to_vec())], &[], &[])
}

/// Stacked panels over one axis (`x_label`, usually the time in seconds), from the first to the last finite sample
/// of any signal.
///
/// A panel without finite samples is still drawn, with a note, because a dead channel is a relevant result.
///
/// # Errors
/// [`ReportError::Empty`] if no panel has a finite point.
pub fn signals(title: &str, x_label: &str, panels: &[Panel]) -> Result<String, ReportError> {
    timeline(title, x_label, panels, &[], &[])
}

/// Same as [`signals`], with strips of named intervals below and events marked in all panels.
///
/// # Errors
/// [`ReportError::Empty`] if no panel has a finite point.
pub fn timeline(
    title: &str,
    x_label: &str,
    panels: &[Panel],
    strips: &[Strip],
    events: &[Event],
) -> Result<String, ReportError> {
    stacked(title, &Axes::over_time(x_label, panels), panels, strips, events)
}

/// Same as [`signals`], one of so many figures of a page, which together have no more points than one.
///
/// # Errors
/// [`ReportError::Empty`] if no panel has a finite point.
pub fn signals_of_many(title: &str, x_label: &str, panels: &[Panel], figures: usize) -> Result<String, ReportError> {
    let axes = Axes::over_time(x_label, panels);
    stacked(title, &Axes { points: axes.points / figures.max(1) as f64, ..axes }, panels, &[], &[])
}

/// Same as [`signals`] over a logarithmic axis, for example the frequency of a Bode plot; points at x ≤ 0 are omitted.
///
/// # Errors
/// [`ReportError::Empty`] if no panel has a finite point.
pub fn sweeps(title: &str, x_label: &str, panels: &[Panel]) -> Result<String, ReportError> {
    let positive = |series: &Series| {
        let points = series.points.iter().filter(|p| p.0 > 0.0).copied().collect();
        let band = series.band.iter().filter(|p| p.0 > 0.0).copied().collect();
        Series { points, band, ..series.clone() }
    };
    let panel = |panel: &Panel| Panel::new(panel.label.clone(), panel.series.iter().map(positive).collect());
    let axes = Axes { logarithmic: true, padding: 0.0, height: 180.0, ..Axes::of_lines(x_label) };
    stacked(title, &axes, &panels.iter().map(panel).collect::<Vec<_>>(), &[], &[])
}

struct Axes<'a> {
    label: &'a str,
    logarithmic: bool,
    /// Share of the range on either side.
    padding: f64,
    /// Height of a panel.
    height: f64,
    /// Points of all series.
    points: f64,
    /// The lowest and the highest value of the first view.
    view: [f64; 2],
}

impl<'a> Axes<'a> {
    fn of_lines(label: &'a str) -> Self {
        Self { label, logarithmic: false, padding: 0.02, height: LINES, points: POINTS, view: WHOLE }
    }

    fn over_time(label: &'a str, panels: &[Panel]) -> Self {
        let height = if panels.len() == 1 { SINGLE } else { STACKED };
        Self { padding: 0.0, height, ..Self::of_lines(label) }
    }
}

fn stacked(
    title: &str,
    axes: &Axes,
    panels: &[Panel],
    strips: &[Strip],
    events: &[Event],
) -> Result<String, ReportError> {
    let all = || panels.iter().flat_map(|panel| &panel.series);
    let empty = || ReportError::Empty { title: title.to_owned() };
    let range = x_range(all()).ok_or_else(empty)?;
    let x = range.padded(axes.padding);
    // Columns of equal width do not suit a logarithmic axis, whose series are short.
    let each = (axes.points / (2.0 * all().count().max(1) as f64)).clamp(COLUMNS[0], COLUMNS[1]).round();
    let columns = (!axes.logarithmic).then_some(each);
    let mut figure = Figure::new(title, 0);
    let mut rows = Vec::new();
    let mut outside = 0;
    let mut named: Vec<&str> = Vec::new();
    for (k, panel) in panels.iter().enumerate() {
        let [low, high] = axes.view;
        let all = y_range(&panel.series);
        let own =
            all.map(|all| Range { lo: all.lo.max(low), hi: all.hi.min(high) }).filter(|own| own.lo < own.hi).or(all);
        let is_outside = |p: &&(f64, f64)| own.is_some_and(|own| usable(p.1) && !own.contains(p.1));
        outside += panel.series.iter().flat_map(|series| &series.points).filter(is_outside).count();
        let y = own.map_or(Range { lo: 0.0, hi: 1.0 }, |range| range.padded(0.06));
        for series in &panel.series {
            // One entry of the legend for the series of this name in all panels.
            let in_legend = !named.contains(&series.name.as_str());
            named.push(&series.name);
            for trace in series.traces(Drawing { axis: &axis_name(k), x, y, columns, in_legend }) {
                figure.add(trace);
            }
        }
        let label = if own.is_none() { format!("{}: no finite value", panel.label) } else { panel.label.clone() };
        rows.push(Row { label, height: axes.height, axis: vertical(y).show_tick_labels(own.is_some()) });
    }
    for strip in strips {
        rows.push(strip.draw(&mut figure, rows.len(), x));
    }
    let lanes = mark(&mut figure, events, (x, rows.len()));
    if all().any(|series| series.is_reduced(x, columns)) {
        figure
            .notes
            .push(format!("Drawn by the lowest and the highest sample in each of {each} columns of the width."));
    }
    figure.note_gaps(all().map(Series::missing).sum());
    figure.note_outside(outside);
    let axis = if axes.logarithmic { Axis::new().type_(AxisType::Log).dtick(1.0) } else { Axis::new().range(x.axis()) };
    stack_below(&mut figure, Across { label: axes.label, axis }, rows, (true, lanes));
    Ok(figure.html())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::page::palette::{Color, Marker};
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::{drawn, named};

    fn series(values: &[f64]) -> Series {
        Series::new("a", Color::of(0), (0u32..).map(|i| f64::from(i) * 1e-3).zip(values.iter().copied()))
    }

    #[test]
    fn long_series_stay_small_and_keep_their_extremes() {
        let mut values: Vec<f64> = (0..200_000).map(|i| (f64::from(i) * 0.7).sin() * 40.0).collect();
        values[123_456] = 99.5;
        let html = signals("t", "time / s", &[Panel::new("current / A", vec![series(&values)])]).expect("finite");
        assert!(html.len() < 80_000 && html.contains("99.5"), "{} bytes", html.len());
        assert!(html.contains("lowest and the highest") && check(&html) == Ok(()));
    }

    #[test]
    fn panels_share_one_axis_and_one_entry_of_the_legend() {
        let panels = [Panel::new("x", vec![series(&[1.0, 2.0])]), Panel::new("dead", vec![series(&[f64::NAN])])];
        let html = signals("t", "time / s", &panels).expect("one finite point");
        let traces = named(&html, "a");
        assert_eq!(
            (traces.len(), &traces[0]["showlegend"], &traces[1]["showlegend"]),
            (2, &json!(true), &json!(false))
        );
        assert_eq!(traces[1]["yaxis"], "y2");
        assert!(html.contains("dead: no finite value") && html.contains("1 point is not finite"));
        assert_eq!(drawn(&html)["layout"]["xaxis"]["anchor"], "y2");
    }

    #[test]
    fn band_marker_and_gap_are_drawn() {
        let points = [(0.0, 0.5), (1.0, f64::NAN), (2.0, 0.6)];
        let one = Series::new("rate", Color::of(1), points).marked(Marker::Square).dashed();
        let html = lines("t", "x & y", "y", &[one.with_band([(0.0, 0.1, 0.9), (2.0, 0.2, 0.95)])]).expect("finite");
        let [band, line] = &named(&html, "rate")[..] else { panic!("{html}") };
        assert_eq!((&band["fill"], &line["line"]["dash"]), (&json!("toself"), &json!("dash")));
        assert_eq!((&line["marker"]["symbol"], &line["y"][1]), (&json!("square"), &serde_json::Value::Null));
    }

    #[test]
    fn a_first_view_counts_what_it_leaves_out() {
        let values = series(&[-4000.0, -1.0, 80.0, 90.0]);
        let html = lines_within([0.0, 85.0], "t", "x", "y", std::slice::from_ref(&values)).expect("finite");
        let range = drawn(&html)["layout"]["yaxis"]["range"].clone();
        assert!(range[0].as_f64() > Some(-10.0) && range[1].as_f64() < Some(95.0), "{range}");
        assert!(html.contains("3 points lie outside the first view"), "{html}");
        // A view without any part of the range shows all.
        let whole = lines_within([1e6, 2e6], "t", "x", "y", &[values]).expect("finite");
        assert!(!whole.contains("outside the first view"));
    }

    #[test]
    fn nothing_finite_is_an_error() {
        let error = Err(ReportError::Empty { title: "t".into() });
        assert_eq!(signals("t", "time / s", &[]), error);
        assert_eq!(signals("t", "time / s", &[Panel::new("x", vec![series(&[f64::NAN; 5])])]), error);
        assert_eq!(lines("t", "x", "y", &[]), error);
    }
}
