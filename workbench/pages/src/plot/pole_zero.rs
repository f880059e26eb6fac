//! Map of poles and zeros in the z-plane, with the outlines of their confidence regions and the unit circle.
//!
//! Both axes have the same scale, so that the circle is round. Poles are crosses, zeros are circles; a region is the
//! ellipse given by its outline, or a bar on the real axis. Very uncertain zeros would make the rest of the map too
//! small: the first view is limited to 2.5 around the origin, and the points outside are counted.

use std::f64::consts::TAU;

use serde_json::json;

use super::drawing::figure::{Figure, text};
use super::drawing::numbers::{Range, usable};
use super::drawing::plotly::{Axis, Fill, HoverInfo, Line, Marker, Mode, Scatter, Symbol};
use super::drawing::theme::SOFT;
use super::series::rounded;
use crate::ReportError;
use crate::page::palette::Color;

/// Half width of the largest first view; height of the figure.
const FARTHEST: f64 = 2.5;
const HEIGHT: u32 = 500;
const INNER: f64 = 400.0;

/// A pole or zero.
#[derive(Debug, Clone, PartialEq)]
pub struct MapPoint {
    /// Re and Im.
    pub at: (f64, f64),
    /// Confidence region: two ends of an interval, or a closed outline.
    pub outline: Vec<(f64, f64)>,
}

/// Poles, or the zeros of one input.
#[derive(Debug, Clone, PartialEq)]
pub struct MapGroup {
    /// Name in the legend.
    pub name: String,
    /// Colour of points and regions.
    pub color: Color,
    /// If true, the points are poles (crosses), else zeros (circles).
    pub poles: bool,
    /// Points.
    pub points: Vec<MapPoint>,
}

/// The map. Groups without points are listed in the legend as "none".
///
/// # Errors
/// [`ReportError::Empty`] without a finite point.
pub fn pole_zero(title: &str, groups: &[MapGroup]) -> Result<String, ReportError> {
    let points = || groups.iter().flat_map(|group| &group.points);
    let finite = |p: &&MapPoint| usable(p.at.0) && usable(p.at.1);
    let range = |pick: fn(&(f64, f64)) -> f64| {
        let values = points().filter(finite).flat_map(|p| p.outline.iter().chain([&p.at]).map(pick));
        let seen = values.filter(|&v| usable(v)).map(|v| v.clamp(-FARTHEST, FARTHEST));
        Range::of(seen.chain([-1.0, 1.0])).map(|range| range.padded(0.04))
    };
    let (Some(across), Some(up)) = (range(|p| p.0), range(|p| p.1)) else {
        return Err(ReportError::Empty { title: title.to_owned() });
    };
    if points().filter(finite).count() == 0 {
        return Err(ReportError::Empty { title: title.to_owned() });
    }
    let mut figure = Figure::new(title, HEIGHT);
    let circle: Vec<(f64, f64)> = (0..=180).map(|k| (TAU * f64::from(k) / 180.0).sin_cos()).collect();
    figure.add(
        Scatter::new(rounded(across, circle.iter().map(|p| p.1)), rounded(up, circle.iter().map(|p| p.0)))
            .name("unit circle")
            .mode(Mode::Lines)
            .line(Line::new().color(SOFT).width(1.0))
            .hover_info(HoverInfo::Skip),
    );
    for group in groups {
        draw(&mut figure, group, across, up);
    }
    figure.note_gaps(points().count() - points().filter(finite).count());
    let inside = |p: &&MapPoint| across.contains(p.at.0) && up.contains(p.at.1);
    figure.note_outside(points().filter(finite).filter(|p| !inside(p)).count());
    let title = |text: &str| json!({ "title": { "text": text } });
    figure.axis("xaxis", Axis::new().range(across.axis()).zero_line(true), &title("real part"));
    let y = Axis::new().range(up.axis()).zero_line(true).scale_anchor("x");
    figure.axis("yaxis", y, &title("imaginary part"));
    figure.legend(INNER, 8.0);
    Ok(figure.html())
}

fn draw(figure: &mut Figure, group: &MapGroup, across: Range, up: Range) {
    let name = text(&if group.points.is_empty() { format!("{}: none", group.name) } else { group.name.clone() });
    let color = group.color.to_string();
    let own: Vec<&MapPoint> = group.points.iter().filter(|p| usable(p.at.0) && usable(p.at.1)).collect();
    for point in &own {
        let region = point.outline.iter().filter(|p| usable(p.0) && usable(p.1));
        let (x, y): (Vec<f64>, Vec<f64>) = region.map(|p| (across.rounded(p.0), up.rounded(p.1))).unzip();
        let outline = Scatter::new(x, y)
            .name(&name)
            .legend_group(&name)
            .show_legend(false)
            .hover_info(HoverInfo::Skip)
            .line(Line::new().color(color.clone()).width(1.2));
        figure.add(if point.outline.len() > 2 {
            outline.mode(Mode::Lines).fill(Fill::ToSelf).fill_color(group.color.tint(0.14))
        } else {
            // A bar with end marks, because a region on the real axis has no height.
            let ends = Marker::new().symbol(Symbol::LineNsOpen).size(8).color(color.clone());
            outline.mode(Mode::LinesMarkers).marker(ends)
        });
    }
    let symbol = if group.poles { Symbol::XThinOpen } else { Symbol::CircleOpen };
    let at = |pick: fn(&MapPoint) -> f64| own.iter().map(move |p| pick(p));
    figure.add(
        Scatter::new(rounded(across, at(|p| p.at.0)), rounded(up, at(|p| p.at.1)))
            .name(&name)
            .legend_group(&name)
            .mode(Mode::Markers)
            .marker(
                Marker::new().symbol(symbol).size(10).color(color.clone()).line(Line::new().width(2.0).color(color)),
            )
            .hover_template("%{x} %{y:+}i"),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::{drawn, named};

    fn group(poles: bool, points: &[(f64, f64)], half: f64) -> MapGroup {
        let point = |&(re, im): &(f64, f64)| MapPoint { at: (re, im), outline: vec![(re - half, im), (re + half, im)] };
        MapGroup { name: "<poles>".into(), color: Color::of(0), poles, points: points.iter().map(point).collect() }
    }

    #[test]
    fn far_and_missing_points_are_counted_and_the_circle_is_round() {
        let groups = [group(true, &[(0.5, 0.0), (9.0, 0.0), (f64::NAN, 0.0)], 99.0), group(false, &[], 0.0)];
        let html = pole_zero("t", &groups).expect("a finite pole");
        assert_eq!(check(&html), Ok(()));
        assert!(html.contains("1 point lies outside") && html.contains("1 point is not finite"));
        let poles = named(&html, "&lt;poles&gt;");
        assert_eq!((&poles[0]["x"][1], &poles[2]["x"]), (&json!(99.5), &json!([0.5, 9.0])));
        assert_eq!(named(&html, "&lt;poles&gt;: none").len(), 1);
        assert_eq!(drawn(&html)["layout"]["yaxis"]["scaleanchor"], "x");
        assert!(pole_zero("t", &groups[1..]).is_err());
    }
}
