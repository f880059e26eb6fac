//! The state of the alarm as words, and back.

use super::{Alarm, Cause, Drift, Evidence, Score};
use crate::plan::{Cells, Plan};

/// Words beside those of the classes.
const COMMON: usize = 11;
/// Words a class.
const EACH: usize = 3;
/// The cause of an alarm is a number: none, unknown, and from here on the class.
const FIRST_CLASS: u32 = 2;

impl<P: Plan> Evidence<P> {
    /// Number of words for so many classes.
    pub(crate) const fn words(classes: u8) -> usize {
        COMMON.saturating_add(EACH.saturating_mul(classes as usize))
    }

    /// Hands out the words in their order.
    pub(crate) fn save(&self, put: &mut impl FnMut(u32)) {
        let (cause, segment) = match self.alarm {
            None => (0, 0),
            Some(Alarm { segment, cause: Cause::Unknown }) => (1, segment),
            Some(Alarm { segment, cause: Cause::Class(class) }) => (FIRST_CLASS.saturating_add(class.into()), segment),
        };
        [self.segments, self.undetermined, self.run, cause, segment].into_iter().for_each(&mut *put);
        for Score { sum, run } in core::iter::once(&self.novelty).chain(self.defects.cells()) {
            put(sum.to_bits());
            put(run.to_bits());
        }
        self.support.cells().iter().for_each(|support| put(support.to_bits()));
        self.drift.words().into_iter().for_each(put);
    }

    /// Takes the words in their order; `None` if one is missing or none that an alarm can have. The state is then of no
    /// use.
    pub(crate) fn restore(&mut self, take: &mut impl FnMut() -> Option<u32>) -> Option<()> {
        (self.segments, self.undetermined, self.run) = (take()?, take()?, take()?);
        let (cause, segment) = (take()?, take()?);
        self.alarm = match cause {
            0 => None,
            1 => Some(Alarm { segment, cause: Cause::Unknown }),
            class => Some(Alarm { segment, cause: Cause::Class(u8::try_from(class.wrapping_sub(FIRST_CLASS)).ok()?) }),
        };
        let scores = core::iter::once(&mut self.novelty).chain(self.defects.cells_mut());
        for score in scores {
            *score = Score { sum: f32::from_bits(take()?), run: f32::from_bits(take()?) };
        }
        for support in self.support.cells_mut() {
            *support = f32::from_bits(take()?);
        }
        self.drift = Drift::from_words([take()?, take()?, take()?, take()?])?;
        self.is_plausible().then_some(())
    }

    /// Whether counts, alarm and scores are such as segments can leave.
    fn is_plausible(&self) -> bool {
        let counted = self.undetermined.max(self.run) <= self.segments;
        let defect = |class: u8| (class as usize) < self.support.cells().len() && Some(class) != self.healthy;
        let raised = self.alarm.is_none_or(|Alarm { segment, cause }| {
            let known = match cause {
                Cause::Unknown => true,
                Cause::Class(class) => defect(class),
            };
            known && segment > 0 && segment <= self.segments
        });
        let scored = core::iter::once(&self.novelty).chain(self.defects.cells()).all(|score| {
            score.sum.is_finite() && score.sum >= 0.0 && (score.run.is_finite() || score.run == f32::NEG_INFINITY)
        });
        counted && raised && scored && self.support.cells().iter().all(|support| support.is_finite())
    }
}
