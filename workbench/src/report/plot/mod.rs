//! Plots: each function converts data to a `<figure>` with a title, a legend and inline SVG.
//!
//! Titles, axis titles and legends are HTML, so that they wrap and keep their size on a phone; the SVG contains only
//! elements with a position. The SVG is written here and not by a plotting crate, because the figures need style-sheet
//! classes (dark page, print, larger text on a phone), fractions of a unit, hatching and whole series in one path.

mod axis;
mod correlations;
mod decimate;
mod densities;
mod frame;
mod lines;
mod multiples;
mod picture;
mod pole_zero;
mod posteriors;
mod regions;
mod reliability;
mod scatter;
mod series;
mod signals;
mod svg;

pub use correlations::{CorrelationPanel, Lag, correlations};
pub use densities::{Density, densities};
pub use lines::lines;
pub use multiples::{SizeSeries, multiples};
pub use picture::picture;
pub use pole_zero::{MapGroup, MapPoint, pole_zero};
pub use posteriors::{Segment, posteriors};
pub use reliability::{ReliabilityBin, ReliabilityClass, reliability};
pub use scatter::{ScatterClass, scatter_regions};
pub use series::Series;
pub use signals::{Panel, signals, sweeps};
