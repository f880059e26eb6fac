//! Small multiples: rates with intervals over the size of a defect, one panel for each condition, as one SVG file.

use std::fmt::Write as _;

use super::super::palette::{Color, Marker};
use super::frame::WIDTH;
use super::svg::{Anchor, Svg, markers, num, polyline};
use crate::evaluate::Rate;

const COLUMNS: usize = 5;
const PANEL_WIDTH: f64 = 112.0;
const PANEL_HEIGHT: f64 = 80.0;
const LEFT: f64 = 36.0;
const ACROSS: f64 = 148.0;
const DOWN: f64 = 124.0;
/// Below the heading and the legend.
const TOP: f64 = 52.0;
const STYLE: &str = "text{font:11px sans-serif;fill:#222}.head{font-weight:bold}.name{font-size:10px}.grid{stroke:#ddd;fill:none}\
                     .frame{stroke:#888;fill:none}.line{fill:none;stroke-width:1.5}.paper{fill:#fff}";

/// One kind of defect: its name, and its rates over the size (1 is full size).
#[derive(Debug, Clone, PartialEq)]
pub struct SizeSeries {
    /// Name in the legend.
    pub name: String,
    /// Size and rate.
    pub rates: Vec<(f64, Rate)>,
}

/// A standalone picture; `panels` are titles with their series, which all have the same names.
#[must_use]
pub fn multiples(title: &str, panels: &[(String, Vec<SizeSeries>)]) -> String {
    let height = TOP + DOWN * panels.len().div_ceil(COLUMNS) as f64;
    let mut svg = Svg::new();
    svg.rect("class=\"paper\"", 0.0, 0.0, WIDTH, height);
    svg.text("class=\"head\"", Anchor::Middle, 0.5 * WIDTH, 12.0, title);
    let names = panels.first().map(|(_, series)| series.as_slice()).unwrap_or_default();
    for (k, series) in names.iter().enumerate() {
        let at = 0.5 * WIDTH + 130.0 * (k as f64 - 0.5 * names.len() as f64);
        svg.path(&format!("fill=\"{}\"", Color::of(k)), &markers(Marker::of(k), [(at, 32.0)]));
        svg.text("", Anchor::Middle, at + 40.0, 32.0, &series.name);
    }
    let least = panels.iter().flat_map(|(_, all)| all).flat_map(|own| &own.rates).map(|(size, _)| *size);
    let octaves = -least.fold(0.5, f64::min).log2();
    for (place, (name, all)) in panels.iter().enumerate() {
        let (left, top) = (LEFT + ACROSS * (place % COLUMNS) as f64, TOP + 16.0 + DOWN * (place / COLUMNS) as f64);
        panel(&mut svg, (left, top), octaves, (name, all));
    }
    svg.standalone(title, (WIDTH, height), STYLE)
}

fn panel(svg: &mut Svg, (left, top): (f64, f64), octaves: f64, (name, all): (&str, &[SizeSeries])) {
    let bottom = top + PANEL_HEIGHT;
    // Half an octave of space on both sides.
    let x = |size: f64| left + PANEL_WIDTH * (size.log2() + octaves + 0.5) / (octaves + 1.0);
    let y = |rate: f64| bottom - PANEL_HEIGHT * (0.04 + 0.92 * rate);
    svg.text("class=\"name\"", Anchor::Middle, left + 0.5 * PANEL_WIDTH, top - 9.0, name);
    let mut grid = String::new();
    for rate in [0.0, 0.5, 1.0] {
        // Writing to a String cannot fail.
        let _ = write!(grid, "M{} {}h{}", num(left), num(y(rate)), num(PANEL_WIDTH));
        svg.text("", Anchor::End, left - 4.0, y(rate), &format!("{:.0}", 100.0 * rate));
    }
    svg.path("class=\"grid\"", &grid);
    svg.rect("class=\"frame\"", left, top, PANEL_WIDTH, PANEL_HEIGHT);
    let mut size = 1.0_f64;
    while size.log2() >= -octaves - 1e-9 {
        let label = if size < 1.0 { format!("1/{:.0}", 1.0 / size) } else { "1".into() };
        svg.text("", Anchor::Middle, x(size), bottom + 9.0, &label);
        size /= if size < 0.9 { 4.0 } else { 2.0 };
    }
    for (k, series) in all.iter().enumerate() {
        let color = Color::of(k);
        // Beside each other, so that intervals do not overlap.
        let points: Vec<(f64, f64, Rate)> =
            series.rates.iter().map(|(size, rate)| (x(*size) + 3.0 * k as f64, y(rate.value), *rate)).collect();
        let mut bars = String::new();
        for (at, _, rate) in &points {
            let _ = write!(bars, "M{} {}V{}", num(*at), num(y(rate.low)), num(y(rate.high)));
        }
        let line = polyline(points.iter().map(|(at, value, _)| (*at, *value)));
        svg.path(&format!("class=\"line\" stroke=\"{color}\""), &(line + &bars));
        let places = points.iter().map(|(at, value, _)| (*at, *value));
        svg.path(&format!("fill=\"{color}\""), &markers(Marker::of(k), places));
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::well_formed::check;
    use super::*;

    #[test]
    fn a_picture_is_well_formed_and_has_every_panel() {
        let series = |name: &str| SizeSeries {
            name: name.into(),
            rates: [1.0, 0.25].map(|size| (size, Rate::wilson((20.0 * size) as usize, 60))).to_vec(),
        };
        let panels: Vec<_> =
            ["a<b", "c", "d", "e", "f", "g"].map(|n| (n.into(), vec![series("x"), series("y")])).into();
        let text = multiples("t", &panels);
        assert_eq!(check(&text), Ok(()), "{text}");
        assert!(text.starts_with("<svg xmlns=") && text.contains(">a&lt;b</text>") && text.contains(">1/2</text>"));
        assert_eq!(text.matches("class=\"frame\"").count(), 6);
        assert_eq!(check(&multiples("none", &[])), Ok(()));
    }
}
