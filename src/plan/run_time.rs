//! The plan of programs that read models of any layout: every array is a vector.

use alloc::vec::Vec;

use super::{Layout, Plan, Values};

/// A plan whose layout the model brings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RunTime(Layout);

/// A sample for [`RunTime`].
pub type RunTimeSample = Values<Vec<f32>>;

crate::plan!(@lengths RunTime, AnyLength, AnyLength, Layout::EMPTY, |plan| plan.0);

impl Plan for RunTime {
    type Sample = RunTimeSample;

    fn of(layout: Layout) -> Option<Self> {
        layout.check().is_ok().then_some(Self(layout))
    }

    fn channels() -> Option<&'static [(&'static str, &'static str)]> {
        None
    }
}
