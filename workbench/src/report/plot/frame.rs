//! Common parts of all plots: the figure around the drawing, its legend, and the grid with tick labels.

use std::fmt::Write as _;

use super::super::escape::escape;
use super::super::palette::{Color, Marker};
use super::axis::{Axis, LABEL_HEIGHT};
use super::svg::{Anchor, Svg, hatch, markers, num};

/// Width of every drawing, in drawing units.
pub(super) const WIDTH: f64 = 760.0;
/// Space above a drawing for the upper half of the topmost tick label.
pub(super) const TOP: f64 = 0.5 * LABEL_HEIGHT;
/// Space below a drawing for the tick labels of the horizontal axis.
pub(super) const BOTTOM: f64 = LABEL_HEIGHT + 11.0;
/// Space to the right for half of the last tick label.
pub(super) const RIGHT: f64 = 26.0;

/// The plot's inner rectangle, in drawing units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Area {
    /// A rectangle of the given height at the top, with space for tick labels of the given width to its left.
    pub(super) fn new(label_width: f64, height: f64) -> Self {
        Self { left: (label_width + 12.0).max(56.0), top: TOP, right: WIDTH - RIGHT, bottom: TOP + height }
    }
}

/// Draws grid lines and tick labels; the labels of the horizontal axis only if `x_labels` is true.
pub(super) fn grid(svg: &mut Svg, area: Area, x: &Axis, y: &Axis, x_labels: bool) {
    let Area { left, top, right, bottom } = area;
    let mut d = String::new();
    for &tick in &y.ticks {
        let at = y.at(tick);
        let _ = write!(d, "M{} {}H{}", num(left), num(at), num(right));
        svg.text("class=\"tick\"", Anchor::End, left - 8.0, at, &y.label(tick));
    }
    for &tick in &x.ticks {
        let _ = write!(d, "M{} {}V{}", num(x.at(tick)), num(top), num(bottom));
    }
    svg.path("class=\"grid\"", &d);
    if x_labels {
        x_ticks(svg, x, bottom);
    }
    frame(svg, area);
}

/// The tick labels below the horizontal axis.
pub(super) fn x_ticks(svg: &mut Svg, x: &Axis, bottom: f64) {
    for &tick in &x.ticks {
        svg.text("class=\"tick\"", Anchor::Middle, x.at(tick), bottom + 0.5 * LABEL_HEIGHT + 8.0, &x.label(tick));
    }
}

/// The line around the plot's inner rectangle.
pub(super) fn frame(svg: &mut Svg, area: Area) {
    let Area { left, top, right, bottom } = area;
    svg.rect("class=\"frame\"", left, top, right - left, bottom - top);
}

/// Symbol of a legend entry.
#[derive(Debug, Clone, Copy)]
pub(super) enum Key {
    Line {
        color: Color,
        dashed: bool,
        marker: Option<Marker>,
    },
    /// A filled marker on the tint of its region.
    Region(Color, Marker),
    Area(Color),
    /// Limits of a correlation.
    Limits,
    /// A lag outside the limits.
    Out,
    /// A pole.
    Cross(Color),
    /// A zero.
    Zero(Color),
    Open,
    Filled,
    Ring {
        dashed: bool,
    },
    Hatch,
}

impl Key {
    fn draw(self) -> String {
        const AT: [(f64, f64); 1] = [(13.0, 8.0)];
        let mut svg = Svg::new();
        match self {
            Self::Line { color, dashed, marker } => {
                let class = if dashed { "line dashed" } else { "line" };
                svg.path(&format!("class=\"{class}\" stroke=\"{color}\""), "M1 8H25");
                if let Some(marker) = marker {
                    svg.path(&format!("class=\"dot\" fill=\"{color}\""), &markers(marker, AT));
                }
            }
            Self::Region(color, marker) => {
                svg.rect(&format!("class=\"region\" fill=\"{color}\""), 0.0, 0.0, 26.0, 16.0);
                svg.path(&format!("class=\"dot\" fill=\"{color}\""), &markers(marker, AT));
            }
            Self::Area(color) => svg.rect(&format!("class=\"area\" fill=\"{color}\""), 0.0, 1.0, 26.0, 14.0),
            Self::Limits => svg.rect("class=\"limits\"", 0.0, 1.0, 26.0, 14.0),
            Self::Out => svg.path("class=\"stem out\"", "M13 1V15"),
            Self::Cross(color) => svg.path(&format!("class=\"mark\" stroke=\"{color}\""), "M8 3l10 10m0-10l-10 10"),
            Self::Zero(color) => {
                svg.path(&format!("class=\"mark\" stroke=\"{color}\""), "M8 8a5 5 0 1 0 10 0a5 5 0 1 0-10 0");
            }
            Self::Open => svg.path("class=\"open key-ink\"", &markers(Marker::Circle, AT)),
            Self::Filled => svg.path("class=\"dot key-fill\"", &markers(Marker::Circle, AT)),
            Self::Ring { dashed } => svg.path(ring_class(dashed), RING_AT_KEY),
            Self::Hatch => {
                svg.path("class=\"hatch\"", &hatch(1.0, 1.0, 25.0, 15.0));
                svg.rect("class=\"frame\"", 0.5, 0.5, 25.0, 15.0);
            }
        }
        svg.finish("", 26.0, 16.0).replace("role=\"img\" aria-label=\"\"", "class=\"key\" aria-hidden=\"true\"")
    }
}

/// Path of the ring around a misclassified point, relative to its centre.
pub(super) const RING: &str = "m-7.5 0a7.5 7.5 0 1 0 15 0a7.5 7.5 0 1 0-15 0z";
const RING_AT_KEY: &str = "M13 8m-7 0a7 7 0 1 0 14 0a7 7 0 1 0-14 0z";

pub(super) const fn ring_class(dashed: bool) -> &'static str {
    if dashed { "class=\"ring dashed\"" } else { "class=\"ring\"" }
}

/// A list of legend entries; an empty string without entries.
pub(super) fn legend(entries: &[(Key, String)]) -> String {
    if entries.is_empty() {
        return String::new();
    }
    let mut out = String::from("<ul class=\"legend\">");
    for (key, name) in entries {
        let _ = write!(out, "<li>{}{}</li>", key.draw(), escape(name));
    }
    out.push_str("</ul>");
    out
}

/// The title of a vertical axis and the legend beside it, above the drawing.
pub(super) fn panel_head(label: &str, entries: &[(Key, String)]) -> String {
    format!("<div class=\"panel\"><span class=\"axis\">{}</span>{}</div>", escape(label), legend(entries))
}

/// The title of the horizontal axis, below the drawing.
pub(super) fn x_title(label: &str) -> String {
    format!("<div class=\"axis x\">{}</div>", escape(label))
}

/// The complete figure. The notes describe data that are not drawn.
pub(super) fn figure(title: &str, body: &str, notes: &[String]) -> String {
    let mut out = format!("<figure><figcaption>{}</figcaption>{body}", escape(title));
    for note in notes {
        let _ = write!(out, "<p class=\"note\">{}</p>", escape(note));
    }
    out.push_str("</figure>");
    out
}

/// A note with the number of non-finite values, if there are any.
pub(super) fn gap_note(missing: usize) -> Vec<String> {
    match missing {
        0 => Vec::new(),
        1 => vec!["1 point is not finite and is left out.".to_owned()],
        n => vec![format!("{n} points are not finite and are left out.")],
    }
}
