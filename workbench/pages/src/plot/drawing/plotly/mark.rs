//! How a trace looks: lines and markers, among them those of the palette's shapes.

use serde::Serialize;

use super::part;
use crate::page::palette;

/// How a line joins two points; straight if it is not set.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LineShape {
    /// First horizontal, then vertical.
    Hv,
    /// First vertical, then horizontal.
    Vh,
}

/// The dashes of a line; solid if it is not set.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DashType {
    Dash,
}

part! {
    /// A line, or the outline of a marker; its width is in pixels.
    Line {
        value width "width": f64,
        value shape "shape": LineShape,
        value dash "dash": DashType,
        text color "color": String,
    }
}

impl Line {
    pub fn new() -> Self {
        Self::default()
    }
}

/// The shape of a marker.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Symbol {
    Circle,
    CircleOpen,
    Square,
    SquareOpen,
    TriangleUp,
    TriangleUpOpen,
    Diamond,
    DiamondOpen,
    TriangleDown,
    TriangleDownOpen,
    Pentagon,
    PentagonOpen,
    StarDiamond,
    StarDiamondOpen,
    /// A cross of thin lines.
    XThinOpen,
    /// A vertical line.
    LineNsOpen,
}

part! {
    /// The marker of points, or the look of bars; its size is a diameter in pixels.
    Marker {
        value symbol "symbol": Symbol,
        value opacity "opacity": f64,
        value size "size": usize,
        value line "line": Line,
        text color "color": String,
    }
}

impl Marker {
    pub fn new() -> Self {
        Self::default()
    }
}

impl palette::Marker {
    /// The marker filled, of this diameter in pixels.
    pub(in crate::plot) fn filled(self, color: &str, size: usize) -> Marker {
        let [filled, _] = self.symbols();
        Marker::new().symbol(filled).color(color).size(size)
    }

    /// The outline of the marker.
    pub(in crate::plot) fn open(self, color: &str, size: usize) -> Marker {
        let [_, open] = self.symbols();
        Marker::new().symbol(open).color(color).size(size)
    }

    /// The shape filled, and its outline.
    fn symbols(self) -> [Symbol; 2] {
        match self {
            Self::Circle => [Symbol::Circle, Symbol::CircleOpen],
            Self::Square => [Symbol::Square, Symbol::SquareOpen],
            Self::TriangleUp => [Symbol::TriangleUp, Symbol::TriangleUpOpen],
            Self::Diamond => [Symbol::Diamond, Symbol::DiamondOpen],
            Self::TriangleDown => [Symbol::TriangleDown, Symbol::TriangleDownOpen],
            Self::Pentagon => [Symbol::Pentagon, Symbol::PentagonOpen],
            Self::Star => [Symbol::StarDiamond, Symbol::StarDiamondOpen],
        }
    }
}
