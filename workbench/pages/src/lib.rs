//! Reports as HTML: results of training and evaluation enter, one self-contained page leaves.
//!
//! ```text
//! points, posteriors, counts ──► plot::{signals, lines, scatter_regions, posteriors} ──┐
//!                                table::{table, confusion_table}, page::paragraph   ──┴─► page::Page ──► String
//! ```
//!
//! Every function is pure: it converts data to a fragment of HTML. A figure is a fragment with its data, which plotly's
//! script draws when the page is open: zoom, cursor, legend and download work without a network, because
//! [`page::Page::render`] writes the script into the page. Colours for light, dark and print are defined in one style
//! sheet; figures name them.
//!
//! All names (classes, files, axis labels) are user input and are escaped by [`escape::escape`].
//!
//! | module | content |
//! |---|---|
//! | [`page`] | a page of titled sections, in one file |
//! | [`plot`], [`table`] | one figure or table from its data |
//! | [`palette`] | colour and marker of each class |
//! | [`conclusion`] | the sentences with which a page begins |
//! | [`training`], [`worth`] | a trained model, and how good it is |
//! | [`evaluation`], [`segments`] | verdicts on labelled traces, and on their segments |
//! | [`audit`] | what recordings are worth |
//! | [`structure`], [`validation`] | models of the signals |
//! | [`cogging`] | what turns with the rotor |
//! | [`replay`], [`live`] | traces and a drive that the detector judges one segment after another |
//! | [`escape`] | text inside HTML |

pub mod audit;
pub mod conclusion;
mod drive;
mod identification;
pub mod page;
pub mod plot;
pub mod segments;
pub mod training;

pub use drive::{life, live, replay};
pub use identification::{cogging, structure, validation};
pub use page::{Page, escape, palette, table};
pub use palette::{Class, Color, Marker};
pub use training::{evaluation, worth};

/// Reason why a plot or table could not be drawn. Non-finite values are not an error: they are omitted and counted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// There is no finite point, no segment or no panel.
    #[error("“{title}” has no finite data to draw")]
    Empty {
        /// Title of the plot.
        title: String,
    },
    /// A classification plot or table has no class.
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
    /// A class index is not below the number of classes.
    #[error("“{title}”, row {row}: class index {class} of {classes} classes")]
    ClassIndex {
        /// Title of the plot.
        title: String,
        /// Index of the segment, counted from 0.
        row: usize,
        /// The invalid index.
        class: usize,
        /// Number of classes.
        classes: usize,
    },
    /// A segment does not end after its start.
    #[error("“{title}”, segment {row} does not end after it starts")]
    Interval {
        /// Title of the plot.
        title: String,
        /// Index of the segment, counted from 0.
        row: usize,
    },
}
