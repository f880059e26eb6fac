//! Stem plots of correlations over lags, stacked, with the bounds that hold for a correct model.

use std::fmt::Write as _;

use super::super::ReportError;
use super::axis::{Axis, Range, usable};
use super::frame::{Area, BOTTOM, Key, TOP, WIDTH, figure, gap_note, grid, panel_head, x_title};
use super::svg::{Svg, num, polyline};

const HEIGHT: f64 = 150.0;

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
    let area = Area::new(0.0, HEIGHT);
    let y = Axis::vertical(scale, area.top, area.bottom);
    let area = Area::new(y.label_width(), HEIGHT);
    let x = Axis::horizontal(span, area.left, area.right);
    let mut body = String::new();
    for (index, panel) in panels.iter().enumerate() {
        let last = index + 1 == panels.len();
        let mut svg = Svg::new();
        grid(&mut svg, area, &x, &y, last);
        draw(&mut svg, &panel.lags.iter().copied().filter(|lag| finite(&lag)).collect::<Vec<_>>(), area, &x, &y);
        let keys =
            if index == 0 { vec![(Key::Limits, band.to_owned()), (Key::Out, "outside".to_owned())] } else { vec![] };
        let below = if last { BOTTOM } else { TOP };
        body += &panel_head(&y.title(&panel.label), &keys);
        body += &svg.finish(&panel.label, WIDTH, area.bottom + below);
    }
    body += &x_title("lag / samples");
    Ok(figure(title, &body, &gap_note(all.clone().count() - all.filter(finite).count())))
}

fn draw(svg: &mut Svg, lags: &[Lag], area: Area, x: &Axis, y: &Axis) {
    // The bound is defined at each lag, so the band is a step function with one step around each lag.
    let edge = |lag: &Lag, side: f64, sign: f64| (x.at(lag.lag as f64 + side), y.at(sign * lag.bound));
    let upper = lags.iter().flat_map(|lag| [edge(lag, -0.5, 1.0), edge(lag, 0.5, 1.0)]);
    let lower = lags.iter().rev().flat_map(|lag| [edge(lag, 0.5, -1.0), edge(lag, -0.5, -1.0)]);
    svg.path("class=\"limits\"", &polyline(upper.chain(lower)));
    svg.path("class=\"zero-line\"", &format!("M{} {}H{}", num(area.left), num(y.at(0.0)), num(area.right)));
    let [mut within, mut outside] = [String::new(), String::new()];
    for lag in lags {
        let stems = if lag.value.abs() > lag.bound { &mut outside } else { &mut within };
        // Writing to a String cannot fail.
        let _ = write!(stems, "M{} {}V{}", num(x.at(lag.lag as f64)), num(y.at(0.0)), num(y.at(lag.value)));
    }
    svg.path("class=\"stem\"", &within);
    svg.path("class=\"stem out\"", &outside);
}

#[cfg(test)]
mod tests {
    use super::super::super::well_formed::check;
    use super::*;

    fn panel(values: &[f64]) -> CorrelationPanel {
        let lags = (-1..).zip(values).map(|(lag, &value)| Lag { lag, value, bound: 0.1 }).collect();
        CorrelationPanel { label: "with <u1>".into(), lags }
    }

    #[test]
    fn lags_outside_stand_out() {
        let html = correlations("t", "99 %", &[panel(&[0.05, -0.3, 0.2]), panel(&[0.0, f64::NAN])]).expect("finite");
        assert_eq!(check(&html), Ok(()));
        let out = html.split("stem out\" d=\"").nth(2).and_then(|rest| rest.split('"').next()).expect("stems outside");
        assert_eq!(out.matches('V').count(), 2, "{out}");
        assert!(html.contains("1 point is not finite") && html.contains("with &lt;u1&gt;"));
    }

    #[test]
    fn nothing_finite_is_an_error() {
        assert!(correlations("t", "99 %", &[]).is_err() && correlations("t", "99 %", &[panel(&[f64::NAN])]).is_err());
    }
}
