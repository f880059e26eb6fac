//! What the interrupt fills and hands to the main loop.

use super::sequence::Sequence;
use crate::model::{Model, ShaftConstants};
use crate::plan::{Array, Cells, Plan, Presence};
use crate::reason::{ArithmeticFault, Reason};
use crate::regression::estimate::RegressionSums;
use crate::shaft::ShaftSums;
use crate::signal::Counts;
use crate::signal::average::{self, Averages};

/// The sums of a segment: open in the detector, closed elsewhere.
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Segment<P: Plan> {
    pub(super) regression: Array<P::Regressed, RegressionSums<P>>,
    pub(super) shaft: Array<P::Watched, ShaftSums<P>>,
    pub(super) averages: Averages<P>,
    /// Samples of which the shaft could use every channel.
    pub(super) usable: u32,
    pub(super) counts: Counts,
    /// Rows of the regression, or usable samples in a plan without one.
    pub(super) rows: u32,
    /// Whether it is a whole segment, of which half must be usable.
    pub(super) whole: bool,
    /// Whether nothing is summed in it.
    pub(super) clear: bool,
    /// What the processor did not compute as the host does when the segment closed.
    pub(super) failed: Option<ArithmeticFault>,
    /// The id of the model.
    pub(super) model: u32,
    /// Its place among the segments of the detector.
    pub(super) sequence: Sequence,
}

// Not derived: the clone of an array moves its elements once more.
impl<P: Plan> Clone for Segment<P> {
    #[inline(always)]
    fn clone(&self) -> Self {
        Self {
            regression: P::Regressed::map_part(&self.regression, Clone::clone),
            shaft: P::Watched::map_part(&self.shaft, Clone::clone),
            averages: self.averages.clone(),
            ..*self
        }
    }
}

impl<P: Plan> Segment<P> {
    /// A clear place, for [`Detector::exchange`](super::Detector::exchange).
    // Out of line, so that it is built in the place of the caller's.
    #[inline(never)]
    #[must_use]
    pub fn new(model: &Model<P>) -> Self {
        let (plan, constants) = (model.plan(), model.constants());
        Self {
            regression: P::Regressed::map_part(&constants.regression, |_| RegressionSums::new(plan)),
            shaft: P::Watched::map_part(&constants.shaft, |shaft| ShaftSums::new(plan, shaft)),
            averages: average::empty(plan),
            usable: 0,
            counts: Counts::default(),
            rows: 0,
            whole: false,
            clear: true,
            failed: None,
            model: model.id(),
            sequence: Sequence::default(),
        }
    }

    /// Starts a segment in this place.
    #[inline(always)]
    pub(super) fn next(&mut self, model: &Model<P>) {
        let (plan, constants) = (model.plan(), model.constants());
        if let Some(sums) = self.regression.part_mut() {
            sums.next_segment(plan);
        }
        self.clear_others(plan, constants.shaft.part());
    }

    /// Clears the place for this model.
    pub(super) fn clear(&mut self, model: &Model<P>) {
        if self.model == model.id() {
            self.empty(model);
        } else {
            self.renew(model);
        }
    }

    /// The lengths of another model may differ.
    #[cold]
    #[inline(never)]
    fn renew(&mut self, model: &Model<P>) {
        *self = Self::new(model);
    }

    /// Clears the place of a detector of the same model, part by part: a new one would be moved.
    pub(super) fn empty(&mut self, model: &Model<P>) {
        if let Some(sums) = self.regression.part_mut() {
            sums.clear();
        }
        self.clear_others(model.plan(), model.constants().shaft.part());
        self.clear = true;
    }

    /// Clears what never goes on in another segment.
    #[inline(never)]
    fn clear_others(&mut self, plan: P, shaft: Option<&ShaftConstants<P>>) {
        if let (Some(sums), Some(shaft)) = (self.shaft.part_mut(), shaft) {
            sums.clear(plan, shaft);
        }
        (self.averages, self.usable) = (average::empty(plan), 0);
    }

    /// Parts with a stuck channel have no result.
    pub(super) fn stuck(&self, mask: u16) -> Option<Reason> {
        self.counts.stuck.first_of(mask).map(|channel| Reason::Stuck { channel })
    }
}
