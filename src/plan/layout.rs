//! What a detector consists of: its channels, its regression, its shaft, and the sizes of its classifier.

use super::Structure;

/// Largest number of output terms of a regression by instrumental variables.
pub const MAX_OUTPUT_TERMS: usize = 4;
/// Largest number of channels in a sample.
pub const MAX_CHANNELS: usize = 16;
/// Largest number of covariates.
pub const MAX_COVARIATES: usize = 8;
/// Largest number of directions that the alarm watches.
pub const MAX_DIRECTIONS: u8 = 8;
/// Largest number of harmonics of a bearing order.
pub const MAX_HARMONICS: usize = 3;

/// How the parameters of a segment are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// Least squares: lowest cost. Its estimate is biased if the output is noisy; a classifier trained on such
    /// estimates allows for that bias.
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
    /// Index of the channel in the sample.
    pub channel: u8,
    /// Index of the channel that is subtracted.
    pub minus: Option<u8>,
}

impl Signal {
    /// A channel by its index.
    #[must_use]
    pub const fn channel(index: u8) -> Self {
        Self { channel: index, minus: None }
    }

    /// The difference of two channels.
    #[must_use]
    pub const fn minus(self, other: Self) -> Self {
        Self { channel: self.channel, minus: Some(other.channel) }
    }

    /// The channels of this signal as a bit mask, bit k for index k.
    #[inline(always)]
    #[must_use]
    pub const fn mask(self) -> u16 {
        let channel = bit(self.channel);
        match self.minus {
            Some(other) => channel | bit(other),
            None => channel,
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

/// What is known of the load of a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Load {
    /// Nothing.
    Unknown,
    /// Its torque against positive motion, N·m, is measured.
    Measured(Signal),
    /// It is a weight on an axis behind a gear or belt: a sine of the axis' angle, of unknown amplitude and phase.
    Weight {
        /// Turns of the axis a turn of the motor, 2⁻³² turns.
        axis_q32: u32,
        /// Whether its amplitude may change at each rest within a segment, as a payload does.
        changes: bool,
    },
}

impl Load {
    /// A measured load, or none.
    #[must_use]
    pub const fn of(signal: Option<Signal>) -> Self {
        match signal {
            Some(signal) => Self::Measured(signal),
            None => Self::Unknown,
        }
    }

    /// The signal of a measured load.
    #[inline(always)]
    #[must_use]
    pub const fn measured(self) -> Option<Signal> {
        match self {
            Self::Measured(signal) => Some(signal),
            Self::Unknown | Self::Weight { .. } => None,
        }
    }

    /// Whether the torque balance has terms for it.
    #[inline(always)]
    pub(crate) const fn has_terms(self) -> bool {
        !matches!(self, Self::Unknown)
    }
}

/// The shaft of a plan. Torque balance and bearing orders use the same channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftLayout {
    /// Quadrature or armature current, A; positive current accelerates forwards.
    pub current: Signal,
    /// Measured velocity, rad/s; `None` takes it from the differences of the angle.
    pub velocity: Option<Signal>,
    /// What is known of the load.
    pub load: Load,
    /// Number of bearing orders.
    pub orders: u8,
    /// Number of harmonics of each order, 1 … 3.
    pub harmonics: u8,
    /// Samples from step to step of balance and orders: 1, or 2 for each second sample behind a half-band filter.
    pub decimation: u8,
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
    /// The channels whose mean and root mean square over the segment are features or covariates, as a bit mask.
    pub averaged: u16,
    /// Number of features.
    pub features: u8,
    /// Number of covariates.
    pub covariates: u8,
    /// Number of projected coordinates.
    pub coordinates: u8,
    /// Number of the last coordinates, of which only larger values than usual show a defect.
    pub rising: u8,
    /// Number of directions in which the alarm watches the coordinates; 0 for an alarm by distances and classes.
    pub directions: u8,
    /// Number of classes.
    pub classes: u8,
    /// Linear or quadratic discriminant.
    pub discriminant: Kind,
}

impl RegressionLayout {
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
        self.current.mask() | mask(self.velocity) | mask(self.load.measured())
    }

    /// Whether balance and orders take each second sample.
    #[inline(always)]
    pub(crate) const fn is_halved(&self) -> bool {
        self.decimation == 2
    }

    /// Whether the shaft needs the angle: for bearing orders, for the velocity, or for the angle of an axis.
    #[inline(always)]
    pub(crate) const fn needs_angle(&self) -> bool {
        self.orders > 0 || self.velocity.is_none() || matches!(self.load, Load::Weight { .. })
    }
}

#[inline(always)]
const fn mask(signal: Option<Signal>) -> u16 {
    match signal {
        Some(signal) => signal.mask(),
        None => 0,
    }
}

#[inline(always)]
const fn bit(index: u8) -> u16 {
    if index < 16 { 1 << index } else { 0 }
}

impl Layout {
    /// No part at all: the base of struct literals.
    pub const EMPTY: Self = Self {
        channels: 0,
        regression: None,
        shaft: None,
        averaged: 0,
        features: 0,
        covariates: 0,
        coordinates: 0,
        rising: 0,
        directions: 0,
        classes: 0,
        discriminant: Kind::Linear,
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::LayoutError;

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
        assert_eq!((PLAIN.map(), PLAIN.density(), PLAIN.densities(), PLAIN.means()), (27, 6, 18, 9));
        assert_eq!((PLAIN.laws(), Layout { rising: 2, ..PLAIN }.laws()), (0, 3));
        assert_eq!((PLAIN.squares(), PLAIN.instruments(), refined.squares(), refined.instruments()), (1, 0, 0, 1));
    }

    #[test]
    fn a_shaft_of_each_second_sample_holds_more_of_them() {
        let shaft = |decimation| {
            let [current, load] = [0, 1].map(Signal::channel);
            ShaftLayout { current, velocity: None, load: Load::Measured(load), orders: 2, harmonics: 3, decimation }
        };
        let of = |decimation| Layout { channels: 2, regression: None, shaft: Some(shaft(decimation)), ..PLAIN };
        assert_eq!([PLAIN, of(1), of(2)].map(|layout| layout.moments()), [0, 8, 23]);
        let all = [0, 1, 2, 3].map(|decimation| of(decimation).check());
        assert_eq!(all, [Err(LayoutError::Orders), Ok(()), Ok(()), Err(LayoutError::Orders)]);
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
        assert_eq!(Layout { rising: 3, ..PLAIN }.check(), Ok(()));
        assert_eq!(Layout { rising: 4, ..PLAIN }.check(), Err(LayoutError::Rising));
        let minus = |channel, other| Signal::channel(channel).minus(Signal::channel(other));
        for (y, error) in [
            (Signal::channel(3), LayoutError::UnknownChannel),
            (Signal::channel(16), LayoutError::UnknownChannel),
            (Signal::channel(200), LayoutError::UnknownChannel),
            (minus(0, 16), LayoutError::UnknownChannel),
            (minus(255, 0), LayoutError::UnknownChannel),
            (minus(0, 0), LayoutError::NoDifference),
        ] {
            for regression in [RegressionLayout { y, ..SQUARES }, RegressionLayout { u2: y, ..SQUARES }] {
                assert_eq!(Layout { regression: Some(regression), ..PLAIN }.check(), Err(error), "{y:?}");
            }
        }
        assert_eq!(
            Layout { regression: Some(RegressionLayout { y: minus(0, 2), ..SQUARES }), ..PLAIN }.check(),
            Ok(())
        );
        let five =
            RegressionLayout { structure: Structure::new(5, 1, 1, 1, 1), method: Method::Instruments, ..SQUARES };
        assert_eq!(Layout { regression: Some(five), ..PLAIN }.check(), Err(LayoutError::OutputTerms));
        let without = RegressionLayout { structure: Structure::new(2, 1, 0, 1, 1), ..SQUARES };
        assert_eq!(Layout { regression: Some(without), ..PLAIN }.check(), Err(LayoutError::UnusedChannel));
        assert_eq!(Layout { channels: 2, regression: Some(without), ..PLAIN }.check(), Ok(()));
    }
}
