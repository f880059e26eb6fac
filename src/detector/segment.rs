//! What the interrupt hands to the main loop.

use super::sequence::Sequence;
use crate::plan::{Array, Plan};
use crate::reason::{Kernel, Reason};
use crate::regression::estimate::RegressionSums;
use crate::shaft::ShaftSums;
use crate::signal::Counts;
use crate::signal::average::Averages;

/// The sums of a closed segment, separate from the detector.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Segment<P: Plan> {
    pub(super) regression: Array<P::Regressed, RegressionSums<P>>,
    pub(super) shaft: Array<P::Watched, ShaftSums<P>>,
    pub(super) averages: Averages<P>,
    pub(super) counts: Counts,
    /// Rows of the regression, or usable samples in a plan without one.
    pub(super) rows: u32,
    /// Whether it is a whole segment, of which half must be usable.
    pub(super) whole: bool,
    /// What the processor did not compute as the host does when the segment closed.
    pub(super) failed: Option<Kernel>,
    /// The mark of the model.
    pub(super) model: u32,
    /// Its place among the segments of the detector.
    pub(super) sequence: Sequence,
}

impl<P: Plan> Segment<P> {
    /// Parts with a stuck channel have no result.
    pub(super) fn stuck(&self, mask: u16) -> Option<Reason> {
        self.counts.stuck.first_of(mask).map(|channel| Reason::Stuck { channel })
    }
}
