//! Stem plots of correlations over lags, stacked, with the bounds that hold for a correct model.

use serde_json::json;

use super::drawing::figure::{Figure, text};
use super::drawing::numbers::{Range, usable};
use super::drawing::plotly::{Axis, Bar, Fill, HoverInfo, Line, LineShape, Marker, Mode, Scatter};
use super::drawing::stack::{Across, Row, axis_name, stack, vertical};
use super::drawing::theme::SOFT;
use super::series::rounded;
use crate::ReportError;
use crate::page::palette::Color;

const HEIGHT: f64 = 150.0;
/// Width of a stem, in lags.
const STEM: f64 = 0.3;

/// Correlation at one lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// Lag in samples.
    pub lag: i64,
    /// Correlation.
    pub value: f64,
    /// Bound of the magnitude of the correlation.
    pub bound: f64,
}

/// The lags of one correlation.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrelationPanel {
    /// Title of the vertical axis.
    pub label: String,
    /// Lags in ascending order.
    pub lags: Vec<Lag>,
}

/// Stem plots over a common axis of lags; stems beyond their bound are highlighted.
///
/// # Errors
/// [`ReportError::Empty`] without a finite lag.
pub fn correlations(title: &str, band: &str, panels: &[CorrelationPanel]) -> Result<String, ReportError> {
    let all = panels.iter().flat_map(|panel| &panel.lags);
    let finite = |lag: &&Lag| usable(lag.value) && usable(lag.bound);
    let empty = || ReportError::Empty { title: title.to_owned() };
    let span = Range::of(all.clone().filter(finite).map(|lag| lag.lag as f64)).ok_or_else(empty)?;
    let span = Range { lo: span.lo - 0.7, hi: span.hi + 0.7 };
    // All panels have the same scale, so that their correlations can be compared.
    let most = all.clone().filter(finite).map(|lag| lag.value.abs().max(lag.bound)).fold(1e-6, f64::max);
    let scale = Range { lo: -most, hi: most }.padded(0.06);
    let mut figure = Figure::new(title, 0);
    let mut rows = Vec::new();
    for (k, panel) in panels.iter().enumerate() {
        let lags: Vec<Lag> = panel.lags.iter().copied().filter(|lag| finite(&lag)).collect();
        draw(&mut figure, &lags, (k, scale), band);
        rows.push(Row { label: panel.label.clone(), height: HEIGHT, axis: vertical(scale).zero_line(true) });
    }
    figure.note_gaps(all.clone().count() - all.filter(finite).count());
    figure.set("barmode", json!("overlay"));
    stack(&mut figure, Across { label: "lag / samples", axis: Axis::new().range(span.axis()) }, rows, true);
    Ok(figure.html())
}

fn draw(figure: &mut Figure, lags: &[Lag], (panel, scale): (usize, Range), band: &str) {
    let axis = axis_name(panel);
    // The bound is defined at each lag, so the band is a step function with one step around each lag.
    for sign in [1.0, -1.0] {
        let ends = lags.first().map(|lag| (lag.lag as f64 - 0.5, lag.bound)).into_iter();
        let ends = ends.chain(lags.iter().map(|lag| (lag.lag as f64 + 0.5, lag.bound)));
        let (x, y): (Vec<f64>, Vec<f64>) = ends.map(|(x, bound)| (x, scale.rounded(sign * bound))).unzip();
        figure.add(
            Scatter::new(x, y)
                .name(text(band))
                .legend_group(text(band))
                .show_legend(panel == 0 && sign > 0.0)
                .mode(Mode::Lines)
                .line(Line::new().shape(LineShape::Vh).color(SOFT).width(1.0))
                .fill(Fill::ToZeroY)
                .fill_color(Color::of(6).tint(0.2))
                .hover_info(HoverInfo::Skip)
                .y_axis(&axis),
        );
    }
    for (name, color, out) in [("within", Color::of(0), false), ("outside", Color::of(1), true)] {
        let own = || lags.iter().filter(|lag| (lag.value.abs() > lag.bound) == out);
        let bar = Bar::new(own().map(|lag| lag.lag as f64).collect(), rounded(scale, own().map(|lag| lag.value)))
            .name(name)
            .legend_group(name)
            .show_legend(panel == 0)
            .width(STEM)
            .marker(Marker::new().color(color.to_string()))
            .y_axis(&axis);
        figure.add(bar);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::named;

    fn panel(values: &[f64]) -> CorrelationPanel {
        let lags = (-1..).zip(values).map(|(lag, &value)| Lag { lag, value, bound: 0.1 }).collect();
        CorrelationPanel { label: "with <u1>".into(), lags }
    }

    #[test]
    fn lags_outside_stand_out() {
        let html = correlations("t", "99 %", &[panel(&[0.05, -0.3, 0.2]), panel(&[0.0, f64::NAN])]).expect("finite");
        assert_eq!(check(&html), Ok(()));
        let outside = named(&html, "outside");
        assert_eq!((&outside[0]["x"], &outside[1]["x"]), (&json!([0.0, 1.0]), &json!([])));
        assert!(html.contains("1 point is not finite"));
    }

    #[test]
    fn nothing_finite_is_an_error() {
        assert!(correlations("t", "99 %", &[]).is_err() && correlations("t", "99 %", &[panel(&[f64::NAN])]).is_err());
    }
}
