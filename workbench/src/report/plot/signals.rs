//! Recorded signals in stacked panels over one time axis.

use super::super::ReportError;
use super::axis::{Axis, Range};
use super::frame::{Area, BOTTOM, TOP, WIDTH, figure, gap_note, grid, panel_head, x_title};
use super::series::{Series, x_range, y_range};
use super::svg::{Anchor, Svg};

/// Height of a single panel, and of one of several panels.
const HEIGHT_SINGLE: f64 = 260.0;
const HEIGHT_STACKED: f64 = 125.0;

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

/// Stacked panels over one axis (`x_label`, usually the time in seconds), from the first to the last finite sample
/// of any signal.
///
/// A panel without finite samples is still drawn, with a note, because a dead channel is a relevant result.
///
/// # Errors
/// [`ReportError::Empty`] if no panel has a finite point.
pub fn signals(title: &str, x_label: &str, panels: &[Panel]) -> Result<String, ReportError> {
    stacked(title, x_label, panels, Axis::horizontal)
}

/// Same as [`signals`] over a logarithmic axis, for example the frequency of a Bode plot; points at x ≤ 0 are omitted.
///
/// # Errors
/// [`ReportError::Empty`] if no panel has a finite point.
pub fn sweeps(title: &str, x_label: &str, panels: &[Panel]) -> Result<String, ReportError> {
    let logarithmic = |series: &Series| {
        let points = series.points.iter().filter(|p| p.0 > 0.0).map(|&(x, y)| (x.log10(), y)).collect();
        let band = series.band.iter().filter(|p| p.0 > 0.0).map(|&(x, low, high)| (x.log10(), low, high)).collect();
        Series { points, band, ..series.clone() }
    };
    let panel = |panel: &Panel| Panel::new(panel.label.clone(), panel.series.iter().map(logarithmic).collect());
    stacked(title, x_label, &panels.iter().map(panel).collect::<Vec<_>>(), Axis::decades)
}

fn stacked(
    title: &str,
    x_label: &str,
    panels: &[Panel],
    horizontal: fn(Range, f64, f64) -> Axis,
) -> Result<String, ReportError> {
    let empty = || ReportError::Empty { title: title.to_owned() };
    let all = panels.iter().flat_map(|panel| &panel.series);
    let time = x_range(all.clone()).ok_or_else(empty)?.padded(0.0);
    let height = if panels.len() == 1 { HEIGHT_SINGLE } else { HEIGHT_STACKED };
    let area = Area::new(0.0, height);
    let vertical = |panel: &Panel| {
        let axis = |range: Range| Axis::vertical(range.padded(0.06), area.top, area.bottom);
        y_range(&panel.series).map_or_else(|| axis(Range { lo: 0.0, hi: 0.0 }).without_ticks(), axis)
    };
    let axes: Vec<Axis> = panels.iter().map(vertical).collect();
    // All panels have the same left margin, so that their time axes are aligned.
    let area = Area::new(axes.iter().map(Axis::label_width).fold(0.0, f64::max), height);
    let x = horizontal(time, area.left, area.right);

    let mut body = String::new();
    for (index, (panel, y)) in panels.iter().zip(&axes).enumerate() {
        let last = index + 1 == panels.len();
        body.push_str(&draw_panel(panel, area, &x, y, last));
    }
    body.push_str(&x_title(&x.title(x_label)));
    Ok(figure(title, &body, &gap_note(all.map(Series::missing).sum())))
}

fn draw_panel(panel: &Panel, area: Area, x: &Axis, y: &Axis, last: bool) -> String {
    let mut svg = Svg::new();
    grid(&mut svg, area, x, y, last);
    for series in &panel.series {
        series.draw(&mut svg, area, x, y);
    }
    if y.ticks.is_empty() {
        let (x, y) = (0.5 * (area.left + area.right), 0.5 * (area.top + area.bottom));
        svg.text("class=\"tick\"", Anchor::Middle, x, y, "no finite value");
    }
    let keys: Vec<_> = panel.series.iter().map(Series::key).collect();
    let below = if last { BOTTOM } else { TOP };
    panel_head(&y.title(&panel.label), &keys) + &svg.finish(&panel.label, WIDTH, area.bottom + below)
}

#[cfg(test)]
mod tests {
    use super::super::super::palette::Color;
    use super::super::super::well_formed::check;
    use super::*;

    fn series(values: &[f64]) -> Series {
        Series::new("a", Color::of(0), (0u32..).map(|i| f64::from(i) * 1e-3).zip(values.iter().copied()))
    }

    #[test]
    fn long_series_stay_small() {
        let values: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.7).sin() * 40.0).collect();
        let html = signals("t", "time / s", &[Panel::new("current / A", vec![series(&values)])]).expect("finite");
        assert!(html.len() < 20_000, "{} bytes", html.len());
        assert_eq!(check(&html), Ok(()));
    }

    #[test]
    fn degenerate_signals_give_a_valid_plot() {
        for values in [&[1.0][..], &[2.0; 9], &[f64::NAN, 1.0, f64::NAN, 3.0]] {
            let panels = [Panel::new("x", vec![series(values)]), Panel::new("dead", vec![series(&[f64::NAN])])];
            let html = signals("t", "time / s", &panels).expect("one finite point");
            assert_eq!(check(&html), Ok(()));
            assert!(html.contains("no finite value"));
        }
    }

    #[test]
    fn nothing_finite_is_an_error() {
        assert!(signals("t", "time / s", &[]).is_err());
        assert!(signals("t", "time / s", &[Panel::new("x", vec![])]).is_err());
        assert!(signals("t", "time / s", &[Panel::new("x", vec![series(&[f64::NAN; 5])])]).is_err());
    }
}
