//! What a detector is made of, as one type.
//!
//! A [`Plan`] fixes the channels of a sample, the structure and method of the regression, whether the shaft is watched,
//! and every array length. The macro [`plan!`](crate::plan!) implements it for a unit struct from a [`Layout`];
//! `bearing-watch train --rust` writes the call of that macro. All types of a detector then take this one parameter.
//!
//! `RunTime` (feature `alloc`) is the plan of host programs: it learns its layout when a model is read.
//!
#![doc = include_str!("static_model.md")]

#[cfg(any(test, feature = "bounded"))]
mod bounded;
mod fit;
mod layout;
mod lengths;
#[cfg(any(test, feature = "alloc"))]
mod run_time;
mod size;
mod structure;
#[cfg(any(test, feature = "alloc", feature = "bounded"))]
mod values;

#[cfg(any(test, feature = "bounded"))]
pub use bounded::Bounds;
pub use fit::LayoutError;
pub use layout::{
    Kind, Layout, MAX_CHANNELS, MAX_COVARIATES, MAX_DIRECTIONS, MAX_HARMONICS, MAX_OUTPUT_TERMS, Memory, Method,
    RegressionLayout, ShaftLayout, Signal,
};
#[cfg(any(test, feature = "alloc"))]
pub use run_time::{RunTime, RunTimeSample};
#[cfg(any(test, feature = "bounded"))]
pub use size::Bounded;
pub use size::{Array, Size};
// For the macro `plan!` and for this repository's programs.
#[doc(hidden)]
#[cfg(any(test, feature = "alloc"))]
pub use size::{AnyLength, Heap};
#[doc(hidden)]
pub use size::{Cells, Fixed, Item, Presence, Present};
pub use structure::Structure;
#[cfg(any(test, feature = "alloc", feature = "bounded"))]
pub use values::Values;

pub(crate) use lengths::{FILTERED_MOMENTS, MOMENTS, filter_cells};

#[cfg(test)]
pub mod testing;

#[doc(hidden)]
pub use crate::printable::Printable;
use crate::signal::Angle;

/// One sample of all channels of a plan.
pub trait Signals: Clone + PartialEq + Printable {
    /// The sample of these values of the channels, in their order; 0 where there is none.
    fn of(values: &[f32], angle: Angle) -> Self;

    /// The value of a channel by its place; 0 beyond the last.
    fn value(&self, channel: usize) -> f32;

    /// The angle of the shaft; zero in a plan that tracks no bearing orders and has a channel of the velocity.
    fn angle(&self) -> Angle;
}

/// What a detector is made of. Implement it by [`plan!`](crate::plan!).
///
/// The associated types are the lengths of the arrays that the functions of the same names of [`Layout`] compute.
pub trait Plan: Copy + PartialEq + Printable + 'static {
    /// One sample: a struct with one field for each channel.
    type Sample: Signals;
    /// Number of channels.
    type Channels: Size;
    /// 1 with a regression, else 0.
    type Regressed: Presence;
    /// 1 if the regression uses least squares.
    type Squares: Presence;
    /// 1 if the regression uses instrumental variables.
    type Instruments: Presence;
    /// M, the number of columns of a row.
    type Columns: Size;
    /// M (M − 1)/2.
    type Packed: Size;
    /// n, the number of parameters.
    type Parameters: Size;
    /// n (n + 1)/2.
    type Covariance: Size;
    /// Samples held to delay the inputs.
    type Delays: Size;
    /// Cells of the filters of instrumental variables.
    type Filters: Size;
    /// 1 if the shaft is watched.
    type Watched: Presence;
    /// Samples held to delay the signals of the shaft.
    type Moments: Size;
    /// K, the number of bearing orders.
    type Orders: Size;
    /// Number of channels that are averaged.
    type Averaged: Size;
    /// F, the number of features.
    type Features: Size;
    /// V, the number of covariates.
    type Covariates: Size;
    /// F V.
    type Explained: Size;
    /// Z, the number of coordinates.
    type Coordinates: Size;
    /// Z F.
    type Map: Size;
    /// Z (Z + 1)/2.
    type Density: Size;
    /// Z (Z + 1)/2 for each covariance.
    type Densities: Size;
    /// 1 + K for K > 0 rising coordinates, else 0.
    type Laws: Size;
    /// D, the number of directions that the alarm watches.
    type Directions: Size;
    /// C, the number of classes.
    type Classes: Size;
    /// C Z.
    type Means: Size;
    /// C².
    type Costs: Size;

    /// The layout; a constant but for `RunTime`.
    fn layout(self) -> Layout;

    /// The plan of a layout; `None` if it is not that of this plan.
    fn of(layout: Layout) -> Option<Self>;

    /// Name and unit of each channel; `None` if the model brings them.
    fn channels() -> Option<&'static [(&'static str, &'static str)]>;
}

/// Defines a [`Plan`] and its sample: a unit struct and a struct with one field for each channel.
///
/// The layout is an expression in which each channel stands for its [`Signal`]. A layout whose parts do not fit does
/// not compile. Channels are `f32` in the unit named; `with angle` adds the field `angle`, which a plan with bearing
/// orders, or with a shaft without a channel of its velocity, needs.
///
/// ```
/// use bearing_watch::plan::{Kind, Layout, Memory, Method, RegressionLayout, Structure};
/// bearing_watch::plan! {
///     /// The plan of one drive.
///     pub struct Drive;
///     /// One sample of that drive.
///     pub struct Sample { current_a: "A", velocity_ref_rad_s: "rad/s", velocity_rad_s: "rad/s", load_nm: "N·m" }
///     layout: Layout {
///         regression: Some(RegressionLayout {
///             structure: Structure::new(2, 1, 2, 1, 1),
///             method: Method::LeastSquares,
///             memory: Memory::Segment,
///             y: current_a,
///             u1: velocity_ref_rad_s.minus(velocity_rad_s),
///             u2: load_nm,
///         }),
///         features: 5,
///         coordinates: 2,
///         classes: 3,
///         discriminant: Kind::Linear,
///         ..Layout::EMPTY
///     }
/// }
/// let _sample = Sample { current_a: 1.5, velocity_ref_rad_s: 40.0, velocity_rad_s: 39.5, load_nm: 0.1 };
/// ```
///
/// A channel that the plan does not use is refused:
///
/// ```compile_fail,E0080
/// use bearing_watch::plan::{Layout, Memory, Method, RegressionLayout, Structure};
/// bearing_watch::plan! {
///     pub struct Drive;
///     pub struct Sample { current_a: "A", velocity_rad_s: "rad/s", load_nm: "N·m" }
///     layout: Layout {
///         regression: Some(RegressionLayout {
///             structure: Structure::new(2, 1, 0, 1, 1),
///             method: Method::LeastSquares,
///             memory: Memory::Segment,
///             y: current_a,
///             u1: velocity_rad_s,
///             u2: load_nm, // not used: nc is 0
///         }),
///         features: 3,
///         coordinates: 2,
///         classes: 2,
///         ..Layout::EMPTY
///     }
/// }
/// ```
#[macro_export]
macro_rules! plan {
    (
        $(#[$plan_doc:meta])* $plan_vis:vis struct $plan:ident;
        $(#[$sample_doc:meta])* $vis:vis struct $sample:ident $(with $angle:ident)? {
            $($channel:ident: $unit:literal),+ $(,)?
        }
        layout: $layout:expr
    ) => {
        $(#[$plan_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $plan_vis struct $plan;

        $(#[$sample_doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(non_snake_case, reason = "channels are named as the recordings name them")]
        $vis struct $sample {
            $(#[doc = concat!("Channel in ", $unit, ".")] pub $channel: f32,)+
            $(#[doc = "Mechanical angle of the shaft."] pub $angle: $crate::Angle,)?
        }

        const _: () = {
            const CHANNELS: &[(&str, &str)] = &[$((stringify!($channel), $unit)),+];

            #[allow(non_camel_case_types, non_snake_case, clippy::upper_case_acronyms)]
            enum Place { $($channel),+ }

            #[allow(non_upper_case_globals, unused, reason = "the layout names the channels that it uses")]
            const LAYOUT: $crate::plan::Layout = {
                $(const $channel: $crate::plan::Signal = $crate::plan::Signal::channel(Place::$channel as u8);)+
                $crate::plan::Layout { channels: CHANNELS.len() as u8, ..$layout }
            };

            const _: () = {
                if let Err(error) = LAYOUT.check() {
                    panic!("{}", error.message());
                }
                let angle: &[&str] = &[$(stringify!($angle))?];
                assert!(
                    LAYOUT.needs_angle() == (angle.len() == 1),
                    "a plan with bearing orders, or without a velocity, has a sample `with angle`; other plans have none"
                );
            };

            impl $crate::plan::Signals for $sample {
                #[inline(always)]
                #[allow(unused_variables, reason = "not every sample has an angle")]
                fn of(values: &[f32], angle: $crate::Angle) -> Self {
                    Self {
                        $($channel: values.get(Place::$channel as usize).copied().unwrap_or(0.0),)+
                        $($angle: angle,)?
                    }
                }

                #[inline(always)]
                fn value(&self, channel: usize) -> f32 {
                    $(if channel == Place::$channel as usize {
                        return self.$channel;
                    })+
                    0.0
                }

                #[inline(always)]
                #[allow(unreachable_code, reason = "not every sample has an angle")]
                fn angle(&self) -> $crate::Angle {
                    $(return self.$angle;)?
                    $crate::Angle::ZERO
                }
            }

            impl $crate::plan::Plan for $plan {
                type Sample = $sample;
                $crate::plan_types!(Fixed, Present, LAYOUT);

                #[inline(always)]
                fn layout(self) -> $crate::plan::Layout {
                    LAYOUT
                }

                fn of(layout: $crate::plan::Layout) -> Option<Self> {
                    (layout == LAYOUT).then_some(Self)
                }

                fn channels() -> Option<&'static [(&'static str, &'static str)]> {
                    Some(CHANNELS)
                }
            }

            $crate::checked_model!($plan, LAYOUT, CHANNELS);
            $crate::defmt_formats!($plan, $sample, $($channel)+);
        };
    };
}

/// The associated types of a plan whose array lengths are the results of these functions of a [`Layout`], or of what
/// has the same functions.
#[doc(hidden)]
#[macro_export]
macro_rules! plan_types {
    ($size:ident, $presence:ident, $lengths:expr) => {
        type Channels = $crate::plan::$size<{ $lengths.channels as usize }>;
        type Regressed = $crate::plan::$presence<{ $lengths.regressed() }>;
        type Squares = $crate::plan::$presence<{ $lengths.squares() }>;
        type Instruments = $crate::plan::$presence<{ $lengths.instruments() }>;
        type Columns = $crate::plan::$size<{ $lengths.columns() }>;
        type Packed = $crate::plan::$size<{ $lengths.packed() }>;
        type Parameters = $crate::plan::$size<{ $lengths.parameters() }>;
        type Covariance = $crate::plan::$size<{ $lengths.covariance() }>;
        type Delays = $crate::plan::$size<{ $lengths.delays() }>;
        type Filters = $crate::plan::$size<{ $lengths.filters() }>;
        type Watched = $crate::plan::$presence<{ $lengths.watched() }>;
        type Moments = $crate::plan::$size<{ $lengths.moments() }>;
        type Orders = $crate::plan::$size<{ $lengths.orders() }>;
        type Averaged = $crate::plan::$size<{ $lengths.averages() }>;
        type Features = $crate::plan::$size<{ $lengths.features as usize }>;
        type Covariates = $crate::plan::$size<{ $lengths.covariates as usize }>;
        type Explained = $crate::plan::$size<{ $lengths.explained() }>;
        type Coordinates = $crate::plan::$size<{ $lengths.coordinates as usize }>;
        type Map = $crate::plan::$size<{ $lengths.map() }>;
        type Density = $crate::plan::$size<{ $lengths.density() }>;
        type Densities = $crate::plan::$size<{ $lengths.densities() }>;
        type Laws = $crate::plan::$size<{ $lengths.laws() }>;
        type Directions = $crate::plan::$size<{ $lengths.directions as usize }>;
        type Classes = $crate::plan::$size<{ $lengths.classes as usize }>;
        type Means = $crate::plan::$size<{ $lengths.means() }>;
        type Costs = $crate::plan::$size<{ $lengths.costs() }>;
    };
}

/// Implements `defmt::Format` for a plan and its sample; nothing without the feature `defmt`.
#[cfg(feature = "defmt")]
#[doc(hidden)]
#[macro_export]
macro_rules! defmt_formats {
    ($plan:ident) => {
        impl $crate::defmt::Format for $plan {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                $crate::defmt::Format::format(stringify!($plan), formatter);
            }
        }
    };
    ($plan:ident, $sample:ident, $($channel:ident)+) => {
        $crate::defmt_formats!($plan);

        impl $crate::defmt::Format for $sample {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                $crate::defmt::Format::format(&[$(self.$channel),+], formatter);
            }
        }
    };
}

/// Implements `defmt::Format` for a plan and its sample; nothing without the feature `defmt`.
#[cfg(not(feature = "defmt"))]
#[doc(hidden)]
#[macro_export]
macro_rules! defmt_formats {
    ($plan:ident $(, $sample:ident, $($channel:ident)+)?) => {};
}
