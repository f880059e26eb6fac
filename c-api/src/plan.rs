//! The plan of the library: that of every model that fits into its arrays, or an exported one.
//!
//! An exported plan, which `BEARING_WATCH_PLAN` names when the library is built, fixes each length of a detector at
//! compile time. Without one, each array has places for the largest model, and the layout of the model says how many of
//! them are in use; a larger model is refused.

use bearing_watch::plan::{Bounds, Plan};

#[cfg(not(bearing_watch_plan))]
pub(crate) use self::AnyModel as Own;
#[cfg(bearing_watch_plan)]
pub(crate) use exported::Drive as Own;
#[cfg(bearing_watch_plan)]
pub(crate) use exported::MODEL;
#[cfg(bearing_watch_front_end)]
pub(crate) use exported::{DriveFrontEnd, FURTHER};

/// A sample of the plan.
pub(crate) type Sample = <Own as Plan>::Sample;

/// What `bearing-watch train --rust` wrote.
#[cfg(bearing_watch_plan)]
#[allow(
    dead_code,
    unreachable_pub,
    missing_docs,
    clippy::all,
    reason = "what `train` writes is for other programs, too"
)]
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
/// Largest number of directions that the alarm watches.
pub const BW_MAX_DIRECTIONS: usize = 8;
/// Largest number of classes.
pub const BW_MAX_CLASSES: usize = 6;
/// Largest number of elements of the projection: coordinates times features.
pub const BW_MAX_PROJECTION: usize = 144;
/// Largest number of elements of the covariances: Z (Z + 1)/2 for Z coordinates, of a quadratic discriminant for each
/// class.
pub const BW_MAX_DENSITIES: usize = 234;

bearing_watch::plan! {
    /// The plan of models up to the largest sizes above.
    pub struct AnyModel(Bounds {
        channels: BW_MAX_CHANNELS,
        columns: BW_MAX_COLUMNS,
        parameters: BW_MAX_PARAMETERS,
        delays: BW_MAX_DELAYS,
        filters: BW_MAX_FILTERS,
        orders: BW_MAX_ORDERS,
        averages: BW_MAX_AVERAGED,
        features: BW_MAX_FEATURES,
        covariates: BW_MAX_COVARIATES,
        coordinates: BW_MAX_COORDINATES,
        rising: BW_MAX_RISING,
        directions: BW_MAX_DIRECTIONS,
        classes: BW_MAX_CLASSES,
        map: BW_MAX_PROJECTION,
        densities: BW_MAX_DENSITIES,
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use bearing_watch::plan::{Kind, Layout, Memory, Method, RegressionLayout, Signal, Structure};

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
}
