//! Every array length of a detector follows from its layout.
//!
//! ```text
//! n = na + nb + nc (+ 1)                          parameters
//! M = n + 1 (+ na by instruments)                 columns of a row, target last
//! M (M − 1)/2,  n (n + 1)/2                       packed triangular factor, packed covariance
//! F V                                             covariates' coefficients
//! Z F,  Z (Z + 1)/2,  C Z,  C²                    projection, factor of a covariance, class means, costs
//! 1 + K                                           laws of the others' distance and of K rising coordinates
//! ```

use super::Structure;
use super::layout::{Kind, Layout, Method, RegressionLayout};

/// Samples held to delay signals, and behind a filter; see [`delays`](crate::shaft::delays).
pub(crate) const MOMENTS: usize = 8;
pub(crate) const FILTERED_MOMENTS: usize = 23;

impl RegressionLayout {
    /// Number of parameters whose own column serves as instrument, and of those with a separate instrument.
    #[inline(always)]
    pub(crate) const fn split(&self) -> (usize, usize) {
        let outputs = match self.method {
            Method::LeastSquares => 0,
            Method::Instruments => self.structure.na as usize,
        };
        (self.structure.parameters().saturating_sub(outputs), outputs)
    }

    /// Number of columns M of a row.
    #[inline(always)]
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.structure.parameters() + self.split().1 + 1
    }

    /// Number of level and difference cells of the simulated output and both filtered inputs; 0 by least squares.
    #[inline(always)]
    pub(crate) const fn filters(&self) -> usize {
        let Structure { na, nb, nc, .. } = self.structure;
        match self.method {
            Method::LeastSquares => 0,
            Method::Instruments => na as usize + filter_cells(nb, na) + filter_cells(nc, na),
        }
    }
}

impl Layout {
    /// Whether a sample needs the angle of the shaft.
    #[inline]
    #[must_use]
    pub const fn needs_angle(&self) -> bool {
        matches!(self.shaft, Some(shaft) if shaft.needs_angle())
    }

    /// 1 with a regression, else 0; likewise the sizes below.
    #[inline]
    #[must_use]
    pub const fn regressed(&self) -> usize {
        self.regression.is_some() as usize
    }

    /// 1 if the regression uses least squares.
    #[inline]
    #[must_use]
    pub const fn squares(&self) -> usize {
        matches!(self.regression, Some(regression) if matches!(regression.method, Method::LeastSquares)) as usize
    }

    /// 1 if the regression uses instrumental variables.
    #[inline]
    #[must_use]
    pub const fn instruments(&self) -> usize {
        matches!(self.regression, Some(regression) if matches!(regression.method, Method::Instruments)) as usize
    }

    /// M.
    #[inline]
    #[must_use]
    pub const fn columns(&self) -> usize {
        match &self.regression {
            Some(regression) => regression.columns(),
            None => 0,
        }
    }

    /// M (M − 1)/2.
    #[inline]
    #[must_use]
    pub const fn packed(&self) -> usize {
        triangle(self.columns().saturating_sub(1))
    }

    /// n.
    #[inline]
    #[must_use]
    pub const fn parameters(&self) -> usize {
        match &self.regression {
            Some(regression) => regression.structure.parameters(),
            None => 0,
        }
    }

    /// n (n + 1)/2.
    #[inline]
    #[must_use]
    pub const fn covariance(&self) -> usize {
        triangle(self.parameters())
    }

    /// nkb + nkc.
    #[inline]
    #[must_use]
    pub const fn delays(&self) -> usize {
        match &self.regression {
            Some(regression) => regression.structure.nkb as usize + regression.structure.nkc as usize,
            None => 0,
        }
    }

    /// Cells of the filters of instrumental variables.
    #[inline]
    #[must_use]
    pub const fn filters(&self) -> usize {
        match &self.regression {
            Some(regression) => regression.filters(),
            None => 0,
        }
    }

    /// Samples held to delay the signals of the shaft, without or with a filter before each second one.
    #[inline]
    #[must_use]
    pub const fn moments(&self) -> usize {
        match &self.shaft {
            Some(shaft) if shaft.is_halved() => FILTERED_MOMENTS,
            Some(_) => MOMENTS,
            None => 0,
        }
    }

    /// 1 if the shaft is watched.
    #[inline]
    #[must_use]
    pub const fn watched(&self) -> usize {
        self.shaft.is_some() as usize
    }

    /// K, the number of bearing orders.
    #[inline]
    #[must_use]
    pub const fn orders(&self) -> usize {
        match &self.shaft {
            Some(shaft) => shaft.orders as usize,
            None => 0,
        }
    }

    /// Number of channels that are averaged.
    #[inline]
    #[must_use]
    pub const fn averages(&self) -> usize {
        self.averaged.count_ones() as usize
    }

    /// F V.
    #[inline]
    #[must_use]
    pub const fn covariate_map_len(&self) -> usize {
        self.features as usize * self.covariates as usize
    }

    /// Z F.
    #[inline]
    #[must_use]
    pub const fn map(&self) -> usize {
        self.coordinates as usize * self.features as usize
    }

    /// Z (Z + 1)/2.
    #[inline]
    #[must_use]
    pub const fn density(&self) -> usize {
        triangle(self.coordinates as usize)
    }

    /// Elements of the covariance factors of all densities: one of a linear discriminant, C of a quadratic one.
    #[inline]
    #[must_use]
    pub const fn densities(&self) -> usize {
        match self.discriminant {
            Kind::Linear => self.density(),
            Kind::Quadratic => self.density() * self.classes as usize,
        }
    }

    /// 1 + K for K > 0 rising coordinates, else 0.
    #[inline]
    #[must_use]
    pub const fn laws(&self) -> usize {
        if self.rising == 0 { 0 } else { self.rising as usize + 1 }
    }

    /// C Z.
    #[inline]
    #[must_use]
    pub const fn means(&self) -> usize {
        self.classes as usize * self.coordinates as usize
    }

    /// C².
    #[inline]
    #[must_use]
    pub const fn costs(&self) -> usize {
        self.classes as usize * self.classes as usize
    }
}

/// Level and difference cells of a filtered input: for its terms in the row and for the memory of the filter.
#[inline(always)]
pub(crate) const fn filter_cells(terms: u8, na: u8) -> usize {
    if terms == 0 {
        0
    } else if terms > na {
        terms as usize
    } else {
        na as usize
    }
}

/// Number of elements on and below the diagonal.
#[inline]
pub(super) const fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}
