//! Map of poles and zeros in the z-plane, with the outlines of their confidence regions and the unit circle.
//!
//! Both axes have the same scale, so that the circle is round. Poles are crosses, zeros are circles; a region is the
//! ellipse given by its outline, or a bar on the real axis. Very uncertain zeros would make the rest of the map too
//! small: the map is limited to 2.5 around the origin, and the points outside are counted.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::super::ReportError;
use super::super::palette::Color;
use super::axis::{Axis, Range, usable};
use super::frame::{Area, BOTTOM, Key, WIDTH, figure, gap_note, grid, panel_head, x_title};
use super::svg::{Svg, num, polyline};

/// Half width of the largest map.
const FARTHEST: f64 = 2.5;
/// Half size of a cross and radius of a circle, in drawing units.
const SIZE: f64 = 5.0;

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
    if points().filter(finite).count() == 0 {
        return Err(ReportError::Empty { title: title.to_owned() });
    }
    let range = |pick: fn(&(f64, f64)) -> f64| {
        let values = points().filter(finite).flat_map(|p| p.outline.iter().chain([&p.at]).map(pick));
        let seen = values.filter(|&v| usable(v)).map(|v| v.clamp(-FARTHEST, FARTHEST));
        Range::of(seen.chain([-1.0, 1.0])).map(|range| range.padded(0.04))
    };
    let (Some(across), Some(up)) = (range(|p| p.0), range(|p| p.1)) else {
        return Err(ReportError::Empty { title: title.to_owned() });
    };
    // The aspect ratio is fixed: the height follows from the width; if the height is limited, one range is widened.
    let area = Area::new(50.0, 100.0);
    let width = area.right - area.left;
    let height = (width * (up.hi - up.lo) / (across.hi - across.lo)).clamp(320.0, 520.0);
    let area = Area::new(50.0, height);
    let scale = (width / (across.hi - across.lo)).min(height / (up.hi - up.lo));
    let widened = |range: Range, length: f64| {
        let (middle, half) = (0.5 * (range.lo + range.hi), 0.5 * length / scale);
        Range { lo: middle - half, hi: middle + half }
    };
    let (across, up) = (widened(across, width), widened(up, height));
    let x = Axis::horizontal(across, area.left, area.right);
    let y = Axis::vertical(up, area.top, area.bottom);

    let mut svg = Svg::new();
    grid(&mut svg, area, &x, &y, true);
    let place = |&(re, im): &(f64, f64)| (x.at(re), y.at(im));
    let circle = (0..=180).map(|k| (TAU * f64::from(k) / 180.0).sin_cos()).map(|(s, c)| (c, s));
    outline(&mut svg, "class=\"unit\"", circle.map(|p| place(&p)).collect(), area);
    let mut outside = 0;
    for group in groups {
        outside += draw(&mut svg, group, area, place, |p| across.contains(p.0) && up.contains(p.1));
    }
    let keys: Vec<(Key, String)> = groups
        .iter()
        .map(|group| {
            let name = if group.points.is_empty() { format!("{}: none", group.name) } else { group.name.clone() };
            (if group.poles { Key::Cross(group.color) } else { Key::Zero(group.color) }, name)
        })
        .collect();
    let mut notes = gap_note(points().count() - points().filter(finite).count());
    match outside {
        0 => {}
        1 => notes.push("1 point lies outside the map.".to_owned()),
        n => notes.push(format!("{n} points lie outside the map.")),
    }
    let drawing = svg.finish(title, WIDTH, area.bottom + BOTTOM);
    Ok(figure(title, &format!("{}{drawing}{}", panel_head("imaginary part", &keys), x_title("real part")), &notes))
}

/// Draws one group; returns the number of its points outside the map.
fn draw(
    svg: &mut Svg,
    group: &MapGroup,
    area: Area,
    place: impl Fn(&(f64, f64)) -> (f64, f64),
    inside: impl Fn((f64, f64)) -> bool,
) -> usize {
    let (mut marks, mut outside) = (String::new(), 0);
    for point in group.points.iter().filter(|p| usable(p.at.0) && usable(p.at.1)) {
        let region: Vec<_> = point.outline.iter().filter(|p| usable(p.0) && usable(p.1)).map(&place).collect();
        if let [(x0, y0), (x1, _)] = region[..] {
            // A bar with end caps, because a region on the real axis has no height.
            let (x0, x1) = (x0.max(area.left), x1.min(area.right));
            if x0 < x1 && (area.top..=area.bottom).contains(&y0) {
                let (x0, x1, y0) = (num(x0), num(x1), num(y0));
                let d = format!("M{x0} {y0}H{x1}M{x0} {y0}m0 -4v8M{x1} {y0}m0 -4v8");
                svg.path(&format!("class=\"extent\" stroke=\"{}\"", group.color), &d);
            }
        } else {
            outline(svg, &format!("class=\"extent\" stroke=\"{0}\" fill=\"{0}\"", group.color), region, area);
        }
        if !inside(point.at) {
            outside += 1;
            continue;
        }
        let (x, y) = place(&point.at);
        // Writing to a String cannot fail.
        let _ = if group.poles {
            write!(marks, "M{} {}l{2} {2}m0-{2}l-{2} {2}", num(x - SIZE), num(y - SIZE), 2.0 * SIZE)
        } else {
            write!(
                marks,
                "M{} {}a{SIZE} {SIZE} 0 1 0 {2} 0a{SIZE} {SIZE} 0 1 0-{2} 0",
                num(x - SIZE),
                num(y),
                2.0 * SIZE
            )
        };
    }
    svg.path(&format!("class=\"mark\" stroke=\"{}\"", group.color), &marks);
    outside
}

/// A closed outline; parts outside the area are drawn along its edge.
fn outline(svg: &mut Svg, attributes: &str, points: Vec<(f64, f64)>, area: Area) {
    let clamp = |(x, y): (f64, f64)| (x.clamp(area.left, area.right), y.clamp(area.top, area.bottom));
    if points.len() > 2 {
        svg.path(attributes, &(polyline(points.into_iter().map(clamp)) + "z"));
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::well_formed::check;
    use super::*;

    fn group(poles: bool, points: &[(f64, f64)], half: f64) -> MapGroup {
        let point = |&(re, im): &(f64, f64)| MapPoint { at: (re, im), outline: vec![(re - half, im), (re + half, im)] };
        MapGroup { name: "<poles>".into(), color: Color::of(0), poles, points: points.iter().map(point).collect() }
    }

    #[test]
    fn the_circle_is_round() {
        let html = pole_zero("t", &[group(true, &[(0.5, 0.0)], 0.1)]).expect("a finite pole");
        assert_eq!(check(&html), Ok(()));
        let start = html.find("class=\"unit\" d=\"M").expect("the circle");
        let d = html[start..].split('"').nth(3).expect("its path");
        // The sum of relative steps is the extent; both extents must agree within 0.1, the rounding of the coordinates.
        let (mut at, mut low, mut high) = ([0.0_f64; 2], [f64::MAX; 2], [f64::MIN; 2]);
        for step in d.trim_start_matches('M').trim_end_matches('z').split('l') {
            let split = step[1..].find([' ', '-']).map_or(step.len(), |k| k + 1);
            let pair = [&step[..split], step[split..].trim()];
            for k in 0..2 {
                at[k] += pair[k].parse::<f64>().expect("a number");
                (low[k], high[k]) = (low[k].min(at[k]), high[k].max(at[k]));
            }
        }
        let size = [high[0] - low[0], high[1] - low[1]];
        assert!((size[0] - size[1]).abs() < 0.5 && size[0] > 200.0, "{size:?}");
    }

    #[test]
    fn far_and_missing_points_are_counted() {
        let groups = [group(true, &[(0.5, 0.0), (9.0, 0.0), (f64::NAN, 0.0)], 99.0), group(false, &[], 0.0)];
        let html = pole_zero("t", &groups).expect("a finite pole");
        assert_eq!(check(&html), Ok(()));
        assert!(html.contains("1 point lies outside") && html.contains("1 point is not finite"));
        assert!(html.contains("&lt;poles&gt;: none"));
        assert!(pole_zero("t", &groups[1..]).is_err());
    }
}
