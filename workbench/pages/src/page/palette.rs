//! Colour and marker shape of each class, by class index; the same in every plot.
//!
//! The colours are those of Okabe and Ito, which remain distinguishable under the common forms of colour blindness. The
//! order puts the pairs with the largest difference in lightness first; yellow comes last because thin yellow lines are
//! hardly visible on white paper, and black is replaced by a mid grey so that it is visible on a dark page too. Classes
//! also differ by marker shape, so that they can be distinguished in a plot printed in grey.

use std::fmt;

/// An opaque sRGB colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color {
    /// Red, 0–255.
    pub red: u8,
    /// Green, 0–255.
    pub green: u8,
    /// Blue, 0–255.
    pub blue: u8,
}

const OKABE_ITO: [Color; 8] = [
    Color::rgb(0x00, 0x72, 0xB2),
    Color::rgb(0xD5, 0x5E, 0x00),
    Color::rgb(0x00, 0x9E, 0x73),
    Color::rgb(0xCC, 0x79, 0xA7),
    Color::rgb(0xE6, 0x9F, 0x00),
    Color::rgb(0x56, 0xB4, 0xE9),
    Color::rgb(0x7A, 0x7A, 0x7A),
    Color::rgb(0xE0, 0xD2, 0x30),
];

impl Color {
    /// Creates a colour from its three components.
    #[must_use]
    pub const fn rgb(red: u8, green: u8, blue: u8) -> Self {
        Self { red, green, blue }
    }

    /// The colour of class or series `index`; repeats after eight.
    #[must_use]
    pub const fn of(index: usize) -> Self {
        OKABE_ITO[index % OKABE_ITO.len()]
    }

    /// The colour with this opacity, in CSS.
    pub(crate) fn tint(self, opacity: f64) -> String {
        format!("rgba({},{},{},{opacity})", self.red, self.green, self.blue)
    }
}

/// Writes the CSS form, `#0072B2`.
impl fmt::Display for Color {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02X}{:02X}{:02X}", self.red, self.green, self.blue)
    }
}

/// A closed marker outline; it can be drawn open or filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// ○
    Circle,
    /// □
    Square,
    /// △
    TriangleUp,
    /// ◇
    Diamond,
    /// ▽
    TriangleDown,
    /// ⬠
    Pentagon,
    /// A four-pointed star.
    Star,
}

const MARKERS: [Marker; 7] = [
    Marker::Circle,
    Marker::Square,
    Marker::TriangleUp,
    Marker::Diamond,
    Marker::TriangleDown,
    Marker::Pentagon,
    Marker::Star,
];

impl Marker {
    /// The marker of class or series `index`. There are seven shapes and eight colours: the pair repeats after 56.
    #[must_use]
    pub const fn of(index: usize) -> Self {
        MARKERS[index % MARKERS.len()]
    }
}

/// Name and appearance of one class, the same in every plot of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Class {
    /// Name as entered by the user; escaped when it is drawn.
    pub name: String,
    /// Colour of regions, areas and markers.
    pub color: Color,
    /// Shape of its points.
    pub marker: Marker,
}

impl Class {
    /// Class number `index` with the palette's colour and marker.
    #[must_use]
    pub fn new(index: usize, name: impl Into<String>) -> Self {
        Self { name: name.into(), color: Color::of(index), marker: Marker::of(index) }
    }

    /// The classes, and after them the findings without a class: novel, ambiguous and undetermined.
    #[must_use]
    pub fn findings<S: AsRef<str>>(names: &[S]) -> Vec<Self> {
        let others = [("novel", 0x8B_3F_C0), ("ambiguous", 0xB0_B0_B0), ("undetermined", 0x7A_7A_7A)];
        let other = |(name, rgb): (&str, u32)| {
            let [_, red, green, blue] = rgb.to_be_bytes();
            Self { name: name.into(), color: Color { red, green, blue }, marker: Marker::Circle }
        };
        Self::all(names).into_iter().chain(others.map(other)).collect()
    }

    /// One class per name, in order.
    #[must_use]
    pub fn all<S: AsRef<str>>(names: &[S]) -> Vec<Self> {
        names.iter().enumerate().map(|(index, name)| Self::new(index, name.as_ref())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_writes_as_css() {
        assert_eq!(Color::of(0).to_string(), "#0072B2");
        assert_eq!(Color::of(8), Color::of(0));
    }

    #[test]
    fn colour_and_marker_pairs_stay_apart() {
        let classes: Vec<Class> = (0..56).map(|index| Class::new(index, "same")).collect();
        for (i, a) in classes.iter().enumerate() {
            assert!(classes[i + 1..].iter().all(|b| a != b), "class {i} repeats");
        }
    }
}
