//! The sample of a plan whose layout a model brings.

use super::{Cells, Signals};
use crate::signal::Angle;

/// The channels in the order of the model, in an array or a vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Values<A> {
    /// Values of the channels.
    pub values: A,
    /// Mechanical angle of the shaft.
    pub angle: Angle,
}

impl<A: Cells<f32>> Signals for Values<A> {
    #[inline(always)]
    fn of(values: &[f32], angle: Angle) -> Self {
        Self { values: A::from_fn(values.len(), |channel| at(values, channel)), angle }
    }

    #[inline(always)]
    fn value(&self, channel: usize) -> f32 {
        at(self.values.cells(), channel)
    }

    #[inline(always)]
    fn angle(&self) -> Angle {
        self.angle
    }
}

#[inline(always)]
fn at(values: &[f32], channel: usize) -> f32 {
    values.get(channel).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_beyond_the_last_channel_are_zero() {
        let sample = Values::<[f32; 8]>::of(&[1.0, 2.0], Angle::from_bits(7));
        assert_eq!(
            [0, 1, 2, 100].map(|channel| sample.value(channel).to_bits()),
            [1.0_f32, 2.0, 0.0, 0.0].map(f32::to_bits)
        );
        assert_eq!(sample.angle(), Angle::from_bits(7));
    }
}
