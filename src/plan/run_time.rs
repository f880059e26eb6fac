//! The plan of programs that read models of any layout: every array is a vector.

use alloc::vec::Vec;

use super::{Layout, Plan, Signals};
use crate::signal::Angle;

/// A plan whose layout the model brings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RunTime(Layout);

/// A sample for [`RunTime`]: the channels in the order of the model.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RunTimeSample {
    /// Values of the channels.
    pub values: Vec<f32>,
    /// Mechanical angle of the shaft.
    pub angle: Angle,
}

impl Signals for RunTimeSample {
    fn of(values: &[f32], angle: Angle) -> Self {
        Self { values: values.to_vec(), angle }
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

impl Plan for RunTime {
    type Sample = RunTimeSample;
    crate::plan_types!(AnyLength, AnyLength, Layout::EMPTY);

    #[inline(always)]
    fn layout(self) -> Layout {
        self.0
    }

    fn of(layout: Layout) -> Option<Self> {
        layout.check().is_ok().then_some(Self(layout))
    }

    fn channels() -> Option<&'static [(&'static str, &'static str)]> {
        None
    }
}
