//! The report room: results enter, one self-contained HTML page leaves.
//!
//! ```text
//! points, posteriors, counts ──► plot::{signals, lines, scatter_regions, posteriors} ──┐
//!                                table::{table, confusion_table}, page::paragraph   ──┼─► page::Page ──► String
//! ```
//!
//! Every function is pure: data in, a fragment of HTML with inline SVG out. Fragments carry CSS classes
//! only; colours for light, dark and print, and the text sizes for desktop and phone, live in one style
//! sheet that [`page::Page::render`] places in the page. Nothing is loaded from elsewhere and no script runs.
//!
//! All names (classes, files, axis labels) are user input and pass through [`escape::escape`].

pub mod escape;
pub mod page;
pub mod pages;
pub mod palette;
pub mod plot;
pub mod table;
#[cfg(test)]
mod well_formed;

pub use page::Page;
pub use palette::{Class, Color, Marker};

/// Why a plot or table could not be drawn. Values that are not finite are no error: they are left out and counted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// There is no finite point, no segment or no panel.
    #[error("“{title}” has no finite data to draw")]
    Empty {
        /// Title of the plot.
        title: String,
    },
    /// A classification plot or table without a class.
    #[error("“{title}” has no classes")]
    NoClasses {
        /// Title of the plot or table.
        title: String,
    },
    /// A row or segment does not have one value per class.
    #[error("“{title}”, row {row}: {found} values for {expected} classes")]
    Length {
        /// Title of the plot or table.
        title: String,
        /// Index of the row or segment, counted from 0.
        row: usize,
        /// Values found.
        found: usize,
        /// Values expected.
        expected: usize,
    },
    /// A class index that no class has.
    #[error("“{title}”, row {row}: class index {class} of {classes} classes")]
    ClassIndex {
        /// Title of the plot.
        title: String,
        /// Index of the segment, counted from 0.
        row: usize,
        /// The offending index.
        class: usize,
        /// Number of classes.
        classes: usize,
    },
    /// A segment whose end is not after its start.
    #[error("“{title}”, segment {row} does not end after it starts")]
    Interval {
        /// Title of the plot.
        title: String,
        /// Index of the segment, counted from 0.
        row: usize,
    },
}
