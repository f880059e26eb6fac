//! What a detector consists of: its channels, its regression, its shaft, and the sizes of its classifier.
//!
//! Every array length of a detector follows from its layout:
//!
//! ```text
//! n = na + nb + nc (+ 1)                          parameters
//! M = n + 1 (+ na by instruments)                 columns of a row, target last
//! M (M − 1)/2,  n (n + 1)/2                       packed triangular factor, packed covariance
//! Z F,  Z (Z + 1)/2,  C Z,  C²                    projection, whitening matrix, class means, costs
//! ```

use super::Structure;

/// Largest number of output terms of a regression by instrumental variables.
pub const MAX_OUTPUT_TERMS: usize = 4;
/// Largest number of channels in a sample.
pub const MAX_CHANNELS: usize = 16;
/// Largest number of harmonics of a bearing order.
pub const MAX_HARMONICS: usize = 3;

/// How the parameters of a segment are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// Least squares: lowest cost. Its estimate is biased if the output is noisy; a classifier trained on such estimates
    /// allows for that bias.
    LeastSquares,
    /// Streaming simplified refined instrumental variables: consistent under output noise, also in closed loop.
    Instruments,
}

/// How long the rows of a regression count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Memory {
    /// Each segment starts empty and gives its rows equal weight; at most 1e5 rows.
    Segment,
    /// The same for segments of up to 1e6 rows, summed in two levels.
    LongSegment,
    /// The weight of a row decays exponentially; the estimate continues across segments.
    Fading,
}

/// Whether the classes share their covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kind {
    /// One covariance for all classes: linear boundaries.
    Linear,
    /// One covariance for each class: quadratic boundaries.
    Quadratic,
}

/// A channel of the sample, or the difference of two channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Signal {
    /// Place of the channel in the sample.
    pub channel: u8,
    /// Place of the channel that is subtracted.
    pub minus: Option<u8>,
}

impl Signal {
    /// A channel by its place.
    #[must_use]
    pub const fn channel(place: u8) -> Self {
        Self { channel: place, minus: None }
    }

    /// The difference of two channels.
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self { channel: self.channel, minus: Some(other.channel) }
    }

    /// The channels of this signal as a bit mask.
    #[inline(always)]
    const fn mask(self) -> u16 {
        let own = bit(self.channel);
        match self.minus {
            Some(other) => own | bit(other),
            None => own,
        }
    }
}

/// The regression of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RegressionLayout {
    /// Number of terms and delays.
    pub structure: Structure,
    /// Least squares or instrumental variables.
    pub method: Method,
    /// How long rows count.
    pub memory: Memory,
    /// The output y.
    pub y: Signal,
    /// The first input; not used if `nb` is 0.
    pub u1: Signal,
    /// The second input; not used if `nc` is 0.
    pub u2: Signal,
}

/// The shaft of a plan. Torque balance and bearing orders use the same channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftLayout {
    /// Quadrature or armature current, A; positive current accelerates forwards.
    pub current: Signal,
    /// Measured velocity, rad/s.
    pub velocity: Signal,
    /// Velocity reference, rad/s.
    pub reference: Signal,
    /// Load torque against positive motion, N·m; `None` if it is not measured.
    pub load: Option<Signal>,
    /// Number of bearing orders.
    pub orders: u8,
    /// Number of harmonics of each order, 1 … 3.
    pub harmonics: u8,
}

/// What a detector consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Layout {
    /// Number of channels in a sample.
    pub channels: u8,
    /// The regression, if there is one.
    pub regression: Option<RegressionLayout>,
    /// The shaft, if it is watched.
    pub shaft: Option<ShaftLayout>,
    /// Number of features.
    pub features: u8,
    /// Number of projected coordinates.
    pub coordinates: u8,
    /// Number of classes.
    pub classes: u8,
    /// Linear or quadratic discriminant.
    pub discriminant: Kind,
}

/// Why a layout is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LayoutError {
    /// Neither a regression nor a shaft.
    Empty,
    /// No channel, or more than [`MAX_CHANNELS`].
    Channels,
    /// A signal names a channel that the sample does not have.
    UnknownChannel,
    /// The sample has a channel that no part uses.
    UnusedChannel,
    /// The regression has no terms, or more than 254 columns.
    Terms,
    /// Instrumental variables need 1 … 4 output terms.
    OutputTerms,
    /// The shaft has more than 32 orders, or not 1 … 3 harmonics.
    Orders,
    /// No features, no coordinates or no classes.
    Classifier,
}

impl LayoutError {
    /// The error in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Empty => "the plan has neither a regression nor a shaft",
            Self::Channels => "the plan has no channel or more than 16 channels",
            Self::UnknownChannel => "a signal of the plan names a channel that its sample does not have",
            Self::UnusedChannel => "the sample of the plan has a channel that the plan does not use",
            Self::Terms => "the regression of the plan has no terms or more than 254 columns",
            Self::OutputTerms => "instrumental variables need 1 to 4 output terms",
            Self::Orders => "the plan has more than 32 bearing orders, or not 1 to 3 harmonics",
            Self::Classifier => "the plan has no features, no coordinates or no classes",
        }
    }
}

impl core::fmt::Display for LayoutError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for LayoutError {}

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

    /// The channels that the regression uses, as a bit mask.
    #[inline(always)]
    pub(crate) const fn mask(&self) -> u16 {
        let Structure { na: _, nb, nc, .. } = self.structure;
        let u1 = if nb > 0 { self.u1.mask() } else { 0 };
        let u2 = if nc > 0 { self.u2.mask() } else { 0 };
        self.y.mask() | u1 | u2
    }
}

impl ShaftLayout {
    /// The channels that the shaft uses, as a bit mask.
    #[inline(always)]
    pub(crate) const fn mask(&self) -> u16 {
        let load = match self.load {
            Some(load) => load.mask(),
            None => 0,
        };
        self.current.mask() | self.velocity.mask() | self.reference.mask() | load
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
const fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

#[inline(always)]
const fn bit(place: u8) -> u16 {
    if place < 16 { 1 << place } else { 0 }
}

impl Layout {
    /// No part at all: the base of struct literals.
    pub const EMPTY: Self = Self {
        channels: 0,
        regression: None,
        shaft: None,
        features: 0,
        coordinates: 0,
        classes: 0,
        discriminant: Kind::Linear,
    };

    /// Checks that the parts fit each other.
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub const fn check(&self) -> Result<(), LayoutError> {
        if self.regression.is_none() && self.shaft.is_none() {
            return Err(LayoutError::Empty);
        }
        let channels = self.channels as usize;
        if channels == 0 || channels > MAX_CHANNELS {
            return Err(LayoutError::Channels);
        }
        let mut used: u16 = 0;
        if let Some(regression) = &self.regression {
            used |= regression.mask();
            if regression.structure.terms() == 0 || regression.columns() > 254 {
                return Err(LayoutError::Terms);
            }
            let na = regression.structure.na as usize;
            if matches!(regression.method, Method::Instruments) && (na == 0 || na > MAX_OUTPUT_TERMS) {
                return Err(LayoutError::OutputTerms);
            }
        }
        if let Some(shaft) = &self.shaft {
            used |= shaft.mask();
            if shaft.orders > 32 || shaft.harmonics == 0 || shaft.harmonics as usize > MAX_HARMONICS {
                return Err(LayoutError::Orders);
            }
        }
        let there = if channels == MAX_CHANNELS { u16::MAX } else { (1 << channels) - 1 };
        if used & !there != 0 {
            return Err(LayoutError::UnknownChannel);
        }
        if used != there {
            return Err(LayoutError::UnusedChannel);
        }
        if self.features == 0 || self.coordinates == 0 || self.classes == 0 {
            return Err(LayoutError::Classifier);
        }
        Ok(())
    }

    /// Whether a sample needs the angle of the shaft.
    #[inline]
    #[must_use]
    pub const fn needs_angle(&self) -> bool {
        matches!(self.shaft, Some(shaft) if shaft.orders > 0)
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

    /// 1 if rows are summed in two levels.
    #[inline]
    #[must_use]
    pub const fn two_level(&self) -> usize {
        matches!(self.regression, Some(regression) if matches!(regression.memory, Memory::LongSegment)) as usize
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

    /// Z F.
    #[must_use]
    pub const fn map(&self) -> usize {
        self.coordinates as usize * self.features as usize
    }

    /// Z (Z + 1)/2.
    #[must_use]
    pub const fn whitening(&self) -> usize {
        triangle(self.coordinates as usize)
    }

    /// Elements of the whitening matrices of all densities: one of a linear discriminant, C of a quadratic one.
    #[must_use]
    pub const fn densities(&self) -> usize {
        match self.discriminant {
            Kind::Linear => self.whitening(),
            Kind::Quadratic => self.whitening() * self.classes as usize,
        }
    }

    /// C Z.
    #[must_use]
    pub const fn means(&self) -> usize {
        self.classes as usize * self.coordinates as usize
    }

    /// C².
    #[must_use]
    pub const fn costs(&self) -> usize {
        self.classes as usize * self.classes as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARES: RegressionLayout = RegressionLayout {
        structure: Structure::new(2, 3, 3, 1, 1),
        method: Method::LeastSquares,
        memory: Memory::Segment,
        y: Signal::channel(0),
        u1: Signal::channel(1),
        u2: Signal::channel(2),
    };
    const PLAIN: Layout = Layout {
        channels: 3,
        regression: Some(SQUARES),
        features: 9,
        coordinates: 3,
        classes: 3,
        discriminant: Kind::Quadratic,
        ..Layout::EMPTY
    };

    #[test]
    fn sizes_of_eight_parameters() {
        assert_eq!((PLAIN.columns(), PLAIN.packed(), PLAIN.parameters(), PLAIN.covariance()), (9, 36, 8, 36));
        let instruments = RegressionLayout { method: Method::Instruments, ..SQUARES };
        let refined = Layout { regression: Some(instruments), ..PLAIN };
        assert_eq!((refined.columns(), refined.packed(), refined.covariance(), refined.filters()), (11, 55, 36, 8));
        assert_eq!((PLAIN.map(), PLAIN.whitening(), PLAIN.densities(), PLAIN.means()), (27, 6, 18, 9));
        assert_eq!((PLAIN.squares(), PLAIN.instruments(), refined.squares(), refined.instruments()), (1, 0, 0, 1));
    }

    #[test]
    fn filters_need_as_many_cells_as_the_output_has_terms() {
        let filters = |na, nb, nc| {
            let structure = Structure::new(na, nb, nc, 1, 1);
            RegressionLayout { structure, method: Method::Instruments, ..SQUARES }.filters()
        };
        assert_eq!((filters(4, 1, 1), filters(2, 1, 0), filters(1, 3, 2)), (12, 4, 6));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert_eq!(PLAIN.check(), Ok(()));
        assert_eq!(Layout { regression: None, ..PLAIN }.check(), Err(LayoutError::Empty));
        assert_eq!(Layout { channels: 4, ..PLAIN }.check(), Err(LayoutError::UnusedChannel));
        assert_eq!(Layout { channels: 2, ..PLAIN }.check(), Err(LayoutError::UnknownChannel));
        assert_eq!(Layout { classes: 0, ..PLAIN }.check(), Err(LayoutError::Classifier));
        let five =
            RegressionLayout { structure: Structure::new(5, 1, 1, 1, 1), method: Method::Instruments, ..SQUARES };
        assert_eq!(Layout { regression: Some(five), ..PLAIN }.check(), Err(LayoutError::OutputTerms));
        let without = RegressionLayout { structure: Structure::new(2, 1, 0, 1, 1), ..SQUARES };
        assert_eq!(Layout { regression: Some(without), ..PLAIN }.check(), Err(LayoutError::UnusedChannel));
        assert_eq!(Layout { channels: 2, regression: Some(without), ..PLAIN }.check(), Ok(()));
    }
}
