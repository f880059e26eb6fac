//! The plan of the library: that of every model that fits into its arrays, or an exported one.
//!
//! An exported plan, which `BEARING_WATCH_PLAN` names when the library is built, fixes each length of a detector at
//! compile time. Without one, each array has places for the largest model, and the layout of the model says how many of
//! them are in use; a larger model is refused.

use bearing_watch::Angle;
use bearing_watch::plan::{Bounded, Layout, Plan, Signals};

#[cfg(not(bearing_watch_plan))]
pub(crate) use self::AnyModel as Own;
#[cfg(bearing_watch_plan)]
pub(crate) use exported::Drive as Own;
#[cfg(bearing_watch_front_end)]
pub(crate) use exported::{DriveFrontEnd, FURTHER};

/// What `bearing-watch train --rust` wrote.
#[cfg(bearing_watch_plan)]
#[allow(dead_code, unreachable_pub, missing_docs, clippy::all, reason = "the model itself comes as bytes")]
mod exported {
    include!(env!("BEARING_WATCH_PLAN_FILE"));
}

/// Largest number of channels of a sample.
pub const BW_MAX_CHANNELS: usize = 8;
/// Largest number of further channels: as many as the largest model of `BW_MAX_CHANNELS` has besides current and
/// velocity.
pub const BW_MAX_FURTHER: usize = 6;
/// Largest number n of parameters of the regression.
pub const BW_MAX_PARAMETERS: usize = 12;
/// Largest number of columns of its rows: n + 1, and by instrumental variables na more.
pub const BW_MAX_COLUMNS: usize = 16;
/// Largest sum of the delays nkb + nkc.
pub const BW_MAX_DELAYS: usize = 16;
/// Largest number of filter cells of instrumental variables: na + max(na, nb) + max(na, nc).
pub const BW_MAX_FILTERS: usize = 16;
/// Largest number of bearing orders.
pub const BW_MAX_ORDERS: usize = 6;
/// Largest number of channels that are averaged.
pub const BW_MAX_AVERAGED: usize = 4;
/// Largest number of features.
pub const BW_MAX_FEATURES: usize = 16;
/// Largest number of covariates.
pub const BW_MAX_COVARIATES: usize = 4;
/// Largest number of coordinates after the projection.
pub const BW_MAX_COORDINATES: usize = 12;
/// Largest number of coordinates that only rise with a defect.
pub const BW_MAX_RISING: usize = 8;
/// Largest number of classes.
pub const BW_MAX_CLASSES: usize = 6;
/// Largest number of elements of the projection: coordinates times features.
pub const BW_MAX_PROJECTION: usize = 144;
/// Largest number of elements of the covariances: Z (Z + 1)/2 for Z coordinates, of a quadratic discriminant for each
/// class.
pub const BW_MAX_DENSITIES: usize = 234;

const PACKED: usize = BW_MAX_COLUMNS * (BW_MAX_COLUMNS - 1) / 2;
const COVARIANCE: usize = BW_MAX_PARAMETERS * (BW_MAX_PARAMETERS + 1) / 2;
const EXPLAINED: usize = BW_MAX_FEATURES * BW_MAX_COVARIATES;
const DENSITY: usize = BW_MAX_COORDINATES * (BW_MAX_COORDINATES + 1) / 2;
const LAWS: usize = BW_MAX_RISING + 1;
const MEANS: usize = BW_MAX_CLASSES * BW_MAX_COORDINATES;
const COSTS: usize = BW_MAX_CLASSES * BW_MAX_CLASSES;

/// The plan of models up to the largest sizes above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AnyModel(Layout);

/// A sample: the channels in the order of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    values: [f32; BW_MAX_CHANNELS],
    angle: Angle,
}

impl Signals for Values {
    #[inline(always)]
    fn of(values: &[f32], angle: Angle) -> Self {
        let mut all = [0.0; BW_MAX_CHANNELS];
        all.iter_mut().zip(values).for_each(|(cell, value)| *cell = *value);
        Self { values: all, angle }
    }

    #[inline(always)]
    fn value(&self, channel: usize) -> f32 {
        self.values.get(channel).copied().unwrap_or(0.0)
    }

    #[inline(always)]
    fn angle(&self) -> Angle {
        self.angle
    }
}

impl Plan for AnyModel {
    type Sample = Values;
    type Channels = Bounded<BW_MAX_CHANNELS>;
    type Regressed = Bounded<1>;
    type Squares = Bounded<1>;
    type Instruments = Bounded<1>;
    type TwoLevel = Bounded<1>;
    type Columns = Bounded<BW_MAX_COLUMNS>;
    type Packed = Bounded<PACKED>;
    type Parameters = Bounded<BW_MAX_PARAMETERS>;
    type Covariance = Bounded<COVARIANCE>;
    type Delays = Bounded<BW_MAX_DELAYS>;
    type Filters = Bounded<BW_MAX_FILTERS>;
    type Watched = Bounded<1>;
    type Orders = Bounded<BW_MAX_ORDERS>;
    type Averaged = Bounded<BW_MAX_AVERAGED>;
    type Features = Bounded<BW_MAX_FEATURES>;
    type Covariates = Bounded<BW_MAX_COVARIATES>;
    type Explained = Bounded<EXPLAINED>;
    type Coordinates = Bounded<BW_MAX_COORDINATES>;
    type Map = Bounded<BW_MAX_PROJECTION>;
    type Density = Bounded<DENSITY>;
    type Densities = Bounded<BW_MAX_DENSITIES>;
    type Laws = Bounded<LAWS>;
    type Classes = Bounded<BW_MAX_CLASSES>;
    type Means = Bounded<MEANS>;
    type Costs = Bounded<COSTS>;

    #[inline(always)]
    fn layout(self) -> Layout {
        self.0
    }

    fn of(layout: Layout) -> Option<Self> {
        fits(&layout).then_some(Self(layout))
    }

    fn channels() -> Option<&'static [(&'static str, &'static str)]> {
        None
    }
}

bearing_watch::defmt_formats!(AnyModel, Values, values);

/// Whether every array of a model of this layout has its places here.
fn fits(layout: &Layout) -> bool {
    let lengths = [
        (layout.channels as usize, BW_MAX_CHANNELS),
        (layout.parameters(), BW_MAX_PARAMETERS),
        (layout.columns(), BW_MAX_COLUMNS),
        (layout.delays(), BW_MAX_DELAYS),
        (layout.filters(), BW_MAX_FILTERS),
        (layout.orders(), BW_MAX_ORDERS),
        (layout.averages(), BW_MAX_AVERAGED),
        (layout.features as usize, BW_MAX_FEATURES),
        (layout.covariates as usize, BW_MAX_COVARIATES),
        (layout.coordinates as usize, BW_MAX_COORDINATES),
        (layout.rising as usize, BW_MAX_RISING),
        (layout.classes as usize, BW_MAX_CLASSES),
        (layout.map(), BW_MAX_PROJECTION),
        (layout.densities(), BW_MAX_DENSITIES),
    ];
    layout.check().is_ok() && lengths.iter().all(|(length, most)| length <= most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bearing_watch::plan::{Kind, Memory, Method, RegressionLayout, Signal, Structure};

    const REGRESSION: RegressionLayout = RegressionLayout {
        structure: Structure::new(4, 4, 3, 7, 3).with_offset(),
        method: Method::LeastSquares,
        memory: Memory::Segment,
        y: Signal::channel(0),
        u1: Signal::channel(1),
        u2: Signal::channel(2),
    };
    const LARGEST: Layout = Layout {
        channels: 3,
        regression: Some(REGRESSION),
        features: 12,
        coordinates: 12,
        classes: 3,
        discriminant: Kind::Quadratic,
        ..Layout::EMPTY
    };

    #[test]
    fn what_fits_is_taken_and_one_more_is_refused() {
        assert_eq!(AnyModel::of(LARGEST).map(AnyModel::layout), Some(LARGEST));
        let refused = [
            Layout { coordinates: 13, ..LARGEST },
            Layout { features: 13, ..LARGEST }, // 156 elements of the projection
            Layout { features: 17, coordinates: 5, ..LARGEST },
            Layout { classes: 4, ..LARGEST }, // four covariances of twelve coordinates
            Layout { classes: 7, discriminant: Kind::Linear, ..LARGEST },
            Layout { covariates: 5, ..LARGEST },
            Layout { rising: 9, ..LARGEST },
            Layout { channels: 2, ..LARGEST },
            // Four columns more by instrumental variables are 17.
            Layout { regression: Some(RegressionLayout { method: Method::Instruments, ..REGRESSION }), ..LARGEST },
        ];
        refused.iter().for_each(|layout| assert_eq!(AnyModel::of(*layout), None, "{layout:?}"));
    }

    #[test]
    fn values_beyond_the_last_channel_are_zero() {
        let sample = Values::of(&[1.0, 2.0], Angle::from_bits(7));
        assert_eq!(
            [0, 1, 2, 100].map(|channel| sample.value(channel).to_bits()),
            [1.0_f32, 2.0, 0.0, 0.0].map(f32::to_bits)
        );
        assert_eq!(sample.angle(), Angle::from_bits(7));
    }
}
