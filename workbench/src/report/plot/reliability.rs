//! Reliability plot: observed shares of a class over its posteriors, in bins.
//!
//! ```text
//! above   share of the class in a bin with its 95 % interval, over the mean posterior; calibrated posteriors: y = x
//! below   number of rows in the bin, on a logarithmic scale
//! ```
//!
//! The classes are drawn side by side, because they would overlap near 0 and 1.

use std::fmt::Write as _;

use super::super::ReportError;
use super::super::palette::Class;
use super::axis::{Axis, Range, usable};
use super::frame::{Area, BOTTOM, Key, TOP, WIDTH, figure, gap_note, grid, panel_head, x_title};
use super::svg::{Anchor, Svg, block, markers, num};
use crate::evaluate::Rate;

const HEIGHT: f64 = 340.0;
const COUNTS_HEIGHT: f64 = 130.0;
/// Total width of the bars of one bin, and of the points at one position, in drawing units.
const BARS: f64 = 48.0;
const POINTS: f64 = 20.0;
/// Half the width of the end caps of an interval.
const CAP: f64 = 4.0;

/// Rows whose posterior of a class is in one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliabilityBin {
    /// Centre of the bin.
    pub middle: f64,
    /// Mean posterior.
    pub posterior: f64,
    /// Share of rows that belong to the class.
    pub observed: Rate,
    /// Number of rows.
    pub count: usize,
}

/// The bins of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct ReliabilityClass {
    /// Name, colour and marker.
    pub class: Class,
    /// Bins with rows, in ascending order.
    pub bins: Vec<ReliabilityBin>,
}

/// Observed shares with intervals over the posteriors, and numbers of rows below.
///
/// # Errors
/// [`ReportError::NoClasses`] without classes, [`ReportError::Empty`] without a bin.
pub fn reliability(title: &str, rows: &str, classes: &[ReliabilityClass]) -> Result<String, ReportError> {
    if classes.is_empty() {
        return Err(ReportError::NoClasses { title: title.to_owned() });
    }
    let drawn: Vec<Vec<ReliabilityBin>> =
        classes.iter().map(|class| class.bins.iter().copied().filter(finite).collect()).collect();
    let most = drawn.iter().flatten().map(|bin| bin.count).max();
    let most = most.ok_or_else(|| ReportError::Empty { title: title.to_owned() })?;

    let unit = Range { lo: 0.0, hi: 1.0 };
    let area = Area::new(0.0, HEIGHT);
    let y = Axis::vertical(unit.padded(0.03), area.top, area.bottom);
    let area = Area::new(y.label_width(), HEIGHT);
    let x = Axis::horizontal(unit.padded(0.05), area.left, area.right);
    let mut svg = Svg::new();
    grid(&mut svg, area, &x, &y, false);
    svg.path(
        "class=\"unit\"",
        &format!("M{} {}L{} {}", num(x.at(0.0)), num(y.at(0.0)), num(x.at(1.0)), num(y.at(1.0))),
    );
    for (place, (class, bins)) in classes.iter().zip(&drawn).enumerate() {
        let across = |bin: &ReliabilityBin| x.at(bin.posterior) + POINTS * beside(place, classes.len());
        intervals(&mut svg, class, bins, across, &y);
    }
    let keys: Vec<_> = classes.iter().map(|c| (key(&c.class), c.class.name.clone())).collect();
    let mut body = panel_head("share of the class, with its 95 % interval", &keys);
    body += &svg.finish(title, WIDTH, area.bottom + TOP);
    body += &panel_head(&format!("{rows} in the bin"), &[]);
    body += &counts(classes, &drawn, (most, rows), &x);
    body += &x_title("posterior of the class, mean of the bin");
    let missing = classes.iter().flat_map(|class| &class.bins).filter(|bin| !finite(bin)).count();
    Ok(figure(title, &body, &gap_note(missing)))
}

fn finite(bin: &ReliabilityBin) -> bool {
    let Rate { value, low, high } = bin.observed;
    [bin.posterior, value, low, high].into_iter().all(usable)
}

fn key(class: &Class) -> Key {
    Key::Line { color: class.color, dashed: false, marker: Some(class.marker) }
}

/// Position of a class beside the others of a bin, as a fraction of the total width.
fn beside(place: usize, classes: usize) -> f64 {
    (place as f64 + 0.5) / classes as f64 - 0.5
}

fn intervals(
    svg: &mut Svg,
    class: &ReliabilityClass,
    bins: &[ReliabilityBin],
    across: impl Fn(&ReliabilityBin) -> f64,
    y: &Axis,
) {
    let mut d = String::new();
    for bin in bins {
        let (at, low, high) = (across(bin), y.at(bin.observed.low), y.at(bin.observed.high));
        let (left, right) = (num(at - CAP), num(at + CAP));
        // Writing to a String cannot fail.
        let _ = write!(d, "M{0} {1}V{2}M{3} {1}H{4}M{3} {2}H{4}", num(at), num(low), num(high), left, right);
    }
    let color = class.class.color;
    svg.path(&format!("class=\"line\" stroke=\"{color}\""), &d);
    let points = bins.iter().map(|bin| (across(bin), y.at(bin.observed.value)));
    svg.path(&format!("class=\"dot\" fill=\"{color}\""), &markers(class.class.marker, points));
}

/// Bars with their numbers above.
fn counts(
    classes: &[ReliabilityClass],
    drawn: &[Vec<ReliabilityBin>],
    (most, rows): (usize, &str),
    x: &Axis,
) -> String {
    // A bar of one row must be visible above the axis, and the number above the highest bar must be inside the frame.
    let up = Range { lo: -0.25, hi: 1.25 * (most.max(2) as f64).log10() + 0.1 };
    let area = Area::new(0.0, COUNTS_HEIGHT);
    let y = Axis::vertical(up, area.top, area.bottom).without_ticks();
    let area = Area { left: x.at(x.range.lo), ..area };
    let mut svg = Svg::new();
    grid(&mut svg, area, x, &y, true);
    let half = 0.4 * BARS / classes.len() as f64;
    for (place, (class, bins)) in classes.iter().zip(drawn).enumerate() {
        let mut bars = String::new();
        for bin in bins {
            let (at, top) = (x.at(bin.middle) + BARS * beside(place, classes.len()), y.at((bin.count as f64).log10()));
            bars += &block(at - half, top, at + half, area.bottom);
            svg.text("class=\"roomy\"", Anchor::Middle, at, top - 8.0, &bin.count.to_string());
        }
        svg.path(&format!("class=\"area\" fill=\"{}\"", class.class.color), &bars);
    }
    svg.finish(&format!("{rows} in each bin"), WIDTH, area.bottom + BOTTOM)
}

#[cfg(test)]
mod tests {
    use super::super::super::well_formed::check;
    use super::*;

    fn class(bins: &[(f64, usize, usize)]) -> ReliabilityClass {
        let bin = |&(posterior, hits, count): &(f64, usize, usize)| ReliabilityBin {
            middle: posterior,
            posterior,
            observed: Rate::wilson(hits, count),
            count,
        };
        ReliabilityClass { class: Class::new(0, "<a>"), bins: bins.iter().map(bin).collect() }
    }

    #[test]
    fn every_bin_has_its_interval_and_its_count() {
        let html = reliability("t", "segments", &[class(&[(0.02, 1, 40), (0.97, 31, 32)])]).expect("bins");
        assert_eq!(check(&html), Ok(()));
        let intervals =
            html.split("class=\"line\"").nth(2).and_then(|rest| rest.split("/>").next()).expect("intervals");
        assert_eq!(intervals.matches('V').count(), 2, "{intervals}");
        assert!(html.contains(">40</text>") && html.contains(">32</text>") && html.contains("&lt;a&gt;"));
    }

    #[test]
    fn honest_posteriors_lie_on_the_diagonal() {
        let html = reliability("t", "segments", &[class(&[(0.25, 25, 100)])]).expect("bins");
        // The diagonal's ends and the marker's centre.
        let path = |class: &str| html.split(class).nth(1).and_then(|rest| rest.split('"').nth(1)).map(String::from);
        let line = path("class=\"unit\" d").expect("diagonal");
        let numbers: Vec<f64> = line.split(['M', 'L', ' ']).filter_map(|s| s.parse().ok()).collect();
        let dot = html.rsplit("class=\"dot\" fill=\"#0072B2\" d=\"M").next().expect("marker");
        let centre: Vec<f64> = dot.split(['m', ' ']).take(2).filter_map(|s| s.parse().ok()).collect();
        let along = |k: usize| (centre[k] - numbers[k]) / (numbers[k + 2] - numbers[k]);
        // Coordinates of a few hundred units are rounded to a tenth.
        assert!((along(0) - 0.25).abs() < 1e-3 && (along(1) - 0.25).abs() < 1e-3, "{line} {centre:?}");
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        assert!(matches!(reliability("t", "rows", &[]), Err(ReportError::NoClasses { .. })));
        assert!(matches!(reliability("t", "rows", &[class(&[])]), Err(ReportError::Empty { .. })));
        assert!(reliability("t", "rows", &[class(&[(f64::NAN, 1, 2)])]).is_err());
    }
}
