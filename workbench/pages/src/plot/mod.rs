//! Plots: each function converts data to a `<figure>` that plotly draws when the page is open.
//!
//! ```text
//! data ──► signals, scatter_regions, posteriors … ──► drawing::figure::Figure (traces, layout) ──► <figure> with JSON
//!                                                     plotly: traces and axes as its script reads them
//!                                                     theme: colours by name, which the page's script replaces
//! ```
//!
//! Panels of one figure share their horizontal axis: they zoom together, and the cursor crosses all of them. Figures in
//! one [`crate::page::linked`] do the same. Long series are reduced to the lowest and highest value of each column.

mod classes;
mod correlations;
mod drawing;
mod events;
mod multiples;
mod pole_zero;
mod runs;
mod series;
mod signals;
mod strip;

pub use classes::densities::{Density, densities};
pub use classes::posteriors::{Segment, posteriors};
pub use classes::reliability::{ReliabilityBin, ReliabilityClass, reliability};
pub use classes::scatter::{ScatterClass, scatter, scatter_regions};
pub use correlations::{CorrelationPanel, Lag, correlations};
pub use events::Event;
pub use multiples::{SizeSeries, multiples};
pub use pole_zero::{MapGroup, MapPoint, pole_zero};
pub use runs::{RunPoint, features_over_runs};
pub use series::Series;
pub use signals::{Panel, lines, lines_within, signals, signals_of_many, sweeps, timeline};
pub use strip::{Span, Strip};
