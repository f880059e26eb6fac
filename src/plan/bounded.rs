//! Plans of firmware that reads models of many layouts, without an allocator: every array has places for the largest.

use super::Layout;
use super::lengths::{FILTERED_MOMENTS, triangle};

/// Most elements of each array of a plan of all models up to these bounds, by the names of [`Layout`].
///
/// ```
/// use bearing_watch::plan::{Bounds, Layout, Plan};
/// const LARGEST: Bounds = Bounds {
///     channels: 3, columns: 8, parameters: 7, delays: 4, filters: 0, orders: 0, averages: 2, features: 8,
///     covariates: 1, coordinates: 4, rising: 0, directions: 0, classes: 3, map: 32, densities: 10,
/// };
/// bearing_watch::plan! {
///     /// The plan of small models.
///     pub struct Small(LARGEST);
/// }
/// assert!(Small::of(Layout { channels: 4, ..Layout::EMPTY }).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bounds {
    /// Channels of a sample.
    pub channels: usize,
    /// Columns of a row of the regression.
    pub columns: usize,
    /// Parameters of the regression.
    pub parameters: usize,
    /// Samples held to delay the inputs.
    pub delays: usize,
    /// Filter cells of instrumental variables.
    pub filters: usize,
    /// Bearing orders.
    pub orders: usize,
    /// Averaged channels.
    pub averages: usize,
    /// Features.
    pub features: usize,
    /// Covariates.
    pub covariates: usize,
    /// Coordinates.
    pub coordinates: usize,
    /// Coordinates that only rise with a defect.
    pub rising: usize,
    /// Directions that the alarm watches.
    pub directions: usize,
    /// Classes.
    pub classes: usize,
    /// Elements of the projection.
    pub map: usize,
    /// Elements of the factors of all covariances.
    pub densities: usize,
}

#[doc(hidden)]
#[allow(missing_docs, reason = "they are those of a layout")]
#[allow(clippy::must_use_candidate, reason = "for the macro")]
impl Bounds {
    /// Whether every array of a model of this layout has its places.
    #[inline]
    pub fn hold(&self, layout: &Layout) -> bool {
        let lengths = [
            (layout.channels as usize, self.channels),
            (layout.columns(), self.columns),
            (layout.parameters(), self.parameters),
            (layout.delays(), self.delays),
            (layout.filters(), self.filters),
            (layout.orders(), self.orders),
            (layout.averages(), self.averages),
            (layout.features as usize, self.features),
            (layout.covariates as usize, self.covariates),
            (layout.coordinates as usize, self.coordinates),
            (layout.rising as usize, self.rising),
            (layout.directions as usize, self.directions),
            (layout.classes as usize, self.classes),
            (layout.map(), self.map),
            (layout.densities(), self.densities),
        ];
        layout.check().is_ok() && lengths.iter().all(|(length, most)| length <= most)
    }

    pub const fn regressed(&self) -> usize {
        1
    }

    pub const fn squares(&self) -> usize {
        1
    }

    pub const fn instruments(&self) -> usize {
        1
    }

    pub const fn columns(&self) -> usize {
        self.columns
    }

    pub const fn packed(&self) -> usize {
        triangle(self.columns.saturating_sub(1))
    }

    pub const fn parameters(&self) -> usize {
        self.parameters
    }

    pub const fn covariance(&self) -> usize {
        triangle(self.parameters)
    }

    pub const fn delays(&self) -> usize {
        self.delays
    }

    pub const fn filters(&self) -> usize {
        self.filters
    }

    pub const fn moments(&self) -> usize {
        FILTERED_MOMENTS
    }

    pub const fn watched(&self) -> usize {
        1
    }

    pub const fn orders(&self) -> usize {
        self.orders
    }

    pub const fn averages(&self) -> usize {
        self.averages
    }

    pub const fn covariate_map_len(&self) -> usize {
        self.features * self.covariates
    }

    pub const fn map(&self) -> usize {
        self.map
    }

    pub const fn density(&self) -> usize {
        triangle(self.coordinates)
    }

    pub const fn densities(&self) -> usize {
        self.densities
    }

    pub const fn laws(&self) -> usize {
        if self.rising == 0 { 0 } else { self.rising + 1 }
    }

    pub const fn means(&self) -> usize {
        self.classes * self.coordinates
    }

    pub const fn costs(&self) -> usize {
        self.classes * self.classes
    }
}
