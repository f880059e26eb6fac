//! Mean and root mean square of a channel over a segment.
//!
//! Enters: the samples of the channels that the layout names ([`Layout::averaged`](crate::plan::Layout::averaged)).
//! Leaves: an [`Average`] for each, in the order of the channels.
//!
//! ```text
//! mean = Σ x/n,   rms = √(Σ x²/n)                                        (1)  over the n samples that are not refused
//! ```
//!
//! A channel of which more samples are refused than used has neither. The sums are compensated (Kahan 1965): a plain
//! sum of 10⁶ equal values in `f32` would be wrong by up to 3 %. Cost: 10 operations a channel and sample; nothing for
//! a plan without such channels.

use crate::plan::{Array, Cells, Plan, Signals};
use crate::reason::Reason;

/// A compensated sum: the sum, and what the last additions lost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Sum {
    value: f32,
    lost: f32,
}

impl Sum {
    #[inline(always)]
    fn add(&mut self, x: f32) {
        let corrected = x - self.lost;
        let next = self.value + corrected;
        self.lost = (next - self.value) - corrected;
        self.value = next;
    }
}

/// The sums of one channel over a segment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Average {
    values: Sum,
    squares: Sum,
    used: u32,
    refused: u32,
    channel: u8,
    stuck: bool,
}

impl Average {
    /// Index of the channel in the sample.
    #[must_use]
    pub const fn channel(&self) -> u8 {
        self.channel
    }

    /// Mean of (1).
    ///
    /// # Errors
    /// The sensor is stuck, or more samples are refused than used.
    pub fn mean(&self) -> Result<f32, Reason> {
        self.of(self.values)
    }

    /// Root mean square of (1).
    ///
    /// # Errors
    /// As [`Average::mean`].
    pub fn rms(&self) -> Result<f32, Reason> {
        self.of(self.squares).map(libm::sqrtf)
    }

    fn of(&self, sum: Sum) -> Result<f32, Reason> {
        if self.stuck {
            Err(Reason::Stuck { channel: self.channel })
        } else if self.used == 0 || self.used < self.refused {
            Err(Reason::LostSamples { channel: self.channel })
        } else {
            Ok(sum.value / self.used as f32)
        }
    }

    #[inline(always)]
    fn take(&mut self, x: f32, good: bool) {
        if good {
            self.values.add(x);
            self.squares.add(x * x);
            self.used = self.used.wrapping_add(1);
        } else {
            self.refused = self.refused.wrapping_add(1);
        }
    }
}

/// The averages of a plan.
pub(crate) type Averages<P> = Array<<P as Plan>::Averaged, Average>;

/// Empty sums.
pub(crate) fn empty<P: Plan>(plan: P) -> Averages<P> {
    let mut rest = plan.layout().averaged;
    Cells::from_fn(plan.layout().averages(), |_| {
        let channel = u8::try_from(rest.trailing_zeros()).unwrap_or(u8::MAX);
        rest &= rest.wrapping_sub(1);
        Average { channel, ..Average::default() }
    })
}

/// Takes a sample; `refused` is the mask of its refused channels.
#[inline(always)]
pub(crate) fn take<P: Plan>(plan: P, averages: &mut Averages<P>, sample: &P::Sample, refused: u16) {
    // The channels come from the layout, which a fixed plan knows at compile time.
    let mut rest = plan.layout().averaged;
    for average in averages.cells_mut() {
        let channel = rest.trailing_zeros();
        rest &= rest.wrapping_sub(1);
        average.take(sample.value(channel as usize), (refused >> (channel & 15)) & 1 == 0);
    }
}

/// Marks the channels that were stuck.
pub(crate) fn mark_stuck<P: Plan>(averages: &mut Averages<P>, stuck: crate::ChannelSet) {
    averages.cells_mut().iter_mut().for_each(|average| average.stuck = stuck.contains(average.channel as usize));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: impl Iterator<Item = (f32, bool)>) -> Average {
        let mut average = Average { channel: 2, ..Average::default() };
        values.for_each(|(x, good)| average.take(x, good));
        average
    }

    #[test]
    fn mean_and_rms_by_hand() {
        let average = of([(3.0, true), (-4.0, true), (f32::NAN, false)].into_iter());
        assert_eq!((average.mean(), average.rms()), (Ok(-0.5), Ok(libm::sqrtf(12.5))));
    }

    #[test]
    fn more_than_half_of_the_samples_must_be_there() {
        let part = |lost: u32| of((0..4 + lost).map(|k| (7.0, k < 4)));
        assert_eq!(part(4).mean(), Ok(7.0));
        let lost = Err(Reason::LostSamples { channel: 2 });
        assert_eq!((part(5).mean(), part(5).rms(), of(core::iter::empty()).mean()), (lost, lost, lost));
        let stuck = Average { stuck: true, ..part(0) };
        assert_eq!(stuck.mean(), Err(Reason::Stuck { channel: 2 }));
    }

    #[test]
    fn a_million_samples_keep_their_digits() {
        let average = of((0..1_000_000).map(|k| (if k % 2 == 0 { 0.1 } else { 123.4 }, true)));
        // A few roundings of the result; without compensation the error is 1 part in 400 here.
        let relative = |value: f32, exact: f64| (f64::from(value) / exact - 1.0).abs();
        let [low, high] = [f64::from(0.1_f32), f64::from(123.4_f32)];
        assert!(relative(average.mean().unwrap(), 0.5 * (low + high)) < 2e-7);
        assert!(relative(average.rms().unwrap(), (0.5 * (low * low + high * high)).sqrt()) < 2e-7);
        let plain = (0..1_000_000).fold(0.0_f32, |sum, k| sum + if k % 2 == 0 { 0.1 } else { 123.4 });
        assert!(relative(plain / 1e6, 0.5 * (low + high)) > 1e-4);
    }
}
