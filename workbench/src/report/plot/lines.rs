//! Several series in one plot with a legend: rates over severity, learning curves, spectra.

use super::super::ReportError;
use super::axis::Axis;
use super::frame::{Area, BOTTOM, WIDTH, figure, gap_note, grid, panel_head, x_title};
use super::series::{Series, x_range, y_range};
use super::svg::Svg;

const HEIGHT: f64 = 320.0;

/// A line plot with one vertical axis. The axis titles should contain the unit, for example `speed / rad·s⁻¹`.
///
/// # Errors
/// [`ReportError::Empty`] if no series has a finite point.
pub fn lines(title: &str, x_label: &str, y_label: &str, series: &[Series]) -> Result<String, ReportError> {
    let empty = || ReportError::Empty { title: title.to_owned() };
    let x_range = x_range(series.iter()).ok_or_else(empty)?.padded(0.02);
    let y_range = y_range(series).ok_or_else(empty)?.padded(0.05);
    let area = Area::new(0.0, HEIGHT);
    let y = Axis::vertical(y_range, area.top, area.bottom);
    let area = Area::new(y.label_width(), HEIGHT);
    let x = Axis::horizontal(x_range, area.left, area.right);

    let mut svg = Svg::new();
    grid(&mut svg, area, &x, &y, true);
    for one in series {
        one.draw(&mut svg, area, &x, &y);
    }
    let keys: Vec<_> = series.iter().map(Series::key).collect();
    let head = panel_head(&y.title(y_label), &keys);
    let drawing = svg.finish(title, WIDTH, area.bottom + BOTTOM);
    let notes = gap_note(series.iter().map(Series::missing).sum());
    Ok(figure(title, &format!("{head}{drawing}{}", x_title(&x.title(x_label))), &notes))
}

#[cfg(test)]
mod tests {
    use super::super::super::palette::{Color, Marker};
    use super::super::super::well_formed::check;
    use super::*;

    fn plot(points: &[(f64, f64)]) -> Result<String, ReportError> {
        lines("a < b", "x & y", "rate", &[Series::new("<one>", Color::of(0), points.iter().copied())])
    }

    #[test]
    fn degenerate_data_gives_a_valid_plot() {
        for points in [
            vec![(1.0, 2.0)],
            vec![(0.0, 5.0), (1.0, 5.0), (2.0, 5.0)],
            vec![(0.0, 0.0), (f64::NAN, 1.0), (1.0, f64::INFINITY), (2.0, 1e140)],
            vec![(3.0, 1.0), (3.0, 2.0)],
            vec![(0.0, f64::MAX), (1.0, f64::MIN), (2.0, 0.0)],
        ] {
            let html = plot(&points).expect("has a finite point");
            assert_eq!(check(&html), Ok(()), "{points:?}");
        }
    }

    #[test]
    fn no_finite_point_is_an_error() {
        let error = Err(ReportError::Empty { title: "a < b".into() });
        assert_eq!(plot(&[]), error);
        assert_eq!(plot(&[(f64::NAN, 1.0), (1.0, f64::NEG_INFINITY)]), error);
        assert!(lines("a", "x", "y", &[]).is_err());
    }

    #[test]
    fn names_are_escaped_and_gaps_counted() {
        let html = plot(&[(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0)]).expect("has finite points");
        assert!(html.contains("&lt;one&gt;") && html.contains("x &amp; y") && !html.contains("<one>"));
        assert!(html.contains("1 point is not finite"));
    }

    #[test]
    fn band_and_markers_are_drawn_and_widen_the_axis() {
        let series = Series::new("rate", Color::of(1), [(0.0, 0.5), (1.0, 0.6)])
            .marked(Marker::Square)
            .dashed()
            .with_band([(0.0, 0.1, 0.9), (1.0, 0.2, 0.95), (2.0, f64::NAN, 1.0)]);
        let html = lines("t", "x", "y", &[series]).expect("has finite points");
        assert_eq!(check(&html), Ok(()));
        assert!(html.contains("class=\"band\"") && html.contains("line dashed") && html.contains(">0.8</text>"));
    }
}
