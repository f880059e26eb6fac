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
mod define;
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
    Kind, Layout, Load, MAX_CHANNELS, MAX_COVARIATES, MAX_DIRECTIONS, MAX_HARMONICS, MAX_OUTPUT_TERMS, Memory, Method,
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

pub use lengths::{Arranged, ClassifierLengths, RegressionLengths, ShaftLengths, SignalLengths};
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

    /// The value of a channel by its index; 0 beyond the last.
    fn value(&self, channel: usize) -> f32;

    /// The angle of the shaft; zero in a plan that tracks no bearing orders and has a channel of the velocity.
    fn angle(&self) -> Angle;
}

/// What a detector is made of. Implement it by [`plan!`](crate::plan!).
///
/// Each part of a detector says by a trait of its own which array lengths it has; the functions of the same names of
/// [`Layout`] compute them.
pub trait Plan: SignalLengths + RegressionLengths + ShaftLengths + ClassifierLengths {
    /// One sample: a struct with one field for each channel.
    type Sample: Signals;

    /// The plan of a layout; `None` if it is not that of this plan.
    fn of(layout: Layout) -> Option<Self>;

    /// Name and unit of each channel; `None` if the model brings them.
    fn channels() -> Option<&'static [(&'static str, &'static str)]>;
}
