//! The state of the alarm as words, and back.

use super::super::runs;
use super::{Alarm, Cause, Contribution, Evidence, EvidenceConstants, Score};
use crate::plan::{Cells, Layout, Plan};
use crate::regression::factor::pairs;

/// Words beside those of classes and directions: 5 of the counts and the alarm, 2 of the novelty, 3 of the silence,
/// 4 of what raised the alarm, the coordinate that fell, and how many runs are learned.
const COMMON: usize = 16;
/// Words a class.
const EACH: usize = 3;
/// The cause of an alarm is a number: none, unknown, and from here on the class.
const FIRST_CLASS: u32 = 2;
/// Or a coordinate with this bit, and with this one if it has fallen.
const COORDINATE: u32 = 1 << 16;
const FALLEN: u32 = 1 << 17;

impl<P: Plan> Evidence<P> {
    /// Number of words of a state of this layout.
    pub(crate) const fn words(layout: &Layout) -> usize {
        let classes = EACH.saturating_mul(layout.classes as usize);
        COMMON.saturating_add(classes).saturating_add(runs::WORDS.saturating_mul(layout.directions as usize))
    }

    /// Hands out the words in their order.
    pub(crate) fn save_words(&self, put: &mut impl FnMut(u32)) {
        let (cause, segment) = match self.alarm {
            None => (0, 0),
            Some(Alarm { segment, cause: Cause::Unknown }) => (1, segment),
            Some(Alarm { segment, cause: Cause::Class(class) }) => (FIRST_CLASS.saturating_add(class.into()), segment),
            Some(Alarm { segment, cause: Cause::Coordinate(index) }) => (u32::from(index) | COORDINATE, segment),
            Some(Alarm { segment, cause: Cause::Fallen(index) }) => (u32::from(index) | FALLEN, segment),
        };
        [self.segments, self.undetermined, self.run, cause, segment].into_iter().for_each(&mut *put);
        for Score { sum, run } in core::iter::once(&self.novelty).chain(self.defects.cells()) {
            put(sum.to_bits());
            put(run.to_bits());
        }
        self.support.cells().iter().for_each(|support| put(support.to_bits()));
        self.silent.words().into_iter().for_each(&mut *put);
        let Contribution { direction, deviations, score, since } = self.main.unwrap_or_default();
        let direction = if self.main.is_some() { u32::from(direction).saturating_add(1) } else { 0 };
        [direction, deviations.to_bits(), score.to_bits(), since].into_iter().for_each(&mut *put);
        put(self.fallen.map_or(0, |index| u32::from(index).saturating_add(1)));
        self.runs.save(put);
    }

    /// Takes the words in their order; `None` if one is missing or none that segments can leave. The state is then of
    /// no use.
    pub(crate) fn restore_words(&mut self, take: &mut impl FnMut() -> Option<u32>) -> Option<()> {
        (self.segments, self.undetermined, self.run) = (take()?, take()?, take()?);
        let (cause, segment) = (take()?, take()?);
        self.alarm = match cause {
            0 => None,
            1 => Some(Alarm { segment, cause: Cause::Unknown }),
            index if index >= FALLEN => {
                Some(Alarm { segment, cause: Cause::Fallen(u8::try_from(index ^ FALLEN).ok()?) })
            }
            index if index >= COORDINATE => {
                Some(Alarm { segment, cause: Cause::Coordinate(u8::try_from(index ^ COORDINATE).ok()?) })
            }
            class => Some(Alarm { segment, cause: Cause::Class(u8::try_from(class.wrapping_sub(FIRST_CLASS)).ok()?) }),
        };
        let scores = core::iter::once(&mut self.novelty).chain(self.defects.cells_mut());
        for score in scores {
            *score = Score { sum: f32::from_bits(take()?), run: f32::from_bits(take()?) };
        }
        for support in self.support.cells_mut() {
            *support = f32::from_bits(take()?);
        }
        self.silent.restore([take()?, take()?, take()?], self.undetermined)?;
        self.main = self.main_of([take()?, take()?, take()?, take()?])?;
        self.fallen = match take()? {
            0 => None,
            index if self.runs.are_used() => Some(u8::try_from(index.wrapping_sub(1)).ok()?),
            _ => return None,
        };
        self.runs.restore(take, self.segments)?;
        self.is_plausible().then_some(())
    }

    /// What raised the alarm, of these words; the outer `None` if no alarm leaves them.
    fn main_of(&self, words: [u32; 4]) -> Option<Option<Contribution>> {
        if words == [0; 4] {
            return Some(None);
        }
        let [index, deviations, score, since] = words;
        let (deviations, score) = (f32::from_bits(deviations), f32::from_bits(score));
        let direction = u8::try_from(index.checked_sub(1)?).ok()?;
        self.runs.contribution(direction)?;
        let good = deviations.is_finite() && score.is_finite() && since <= self.segments;
        good.then_some(Some(Contribution { direction, deviations, score, since }))
    }

    /// Whether counts, alarm and scores are such as segments can leave.
    fn is_plausible(&self) -> bool {
        let Self { segments, undetermined, run, .. } = *self;
        let decided = segments.saturating_sub(undetermined);
        let counted = undetermined <= segments && run <= decided;
        let directed = matches!(self.alarm, Some(Alarm { cause: Cause::Coordinate(_), .. }));
        counted && self.main.is_some() == directed && self.raised() && self.scored(decided)
    }

    /// Whether the alarm is one that the scores leave, or left.
    fn raised(&self) -> bool {
        let defect = |class: u8| (class as usize) < self.support.cells().len() && Some(class) != self.healthy;
        match self.alarm {
            // A score at the limit raises it.
            None => self.score() < self.constants.limit,
            Some(Alarm { segment, cause }) => {
                let known = match cause {
                    Cause::Unknown => true,
                    Cause::Class(class) => defect(class),
                    Cause::Coordinate(index) => self.runs.watch(index),
                    Cause::Fallen(_) => self.runs.are_used() && self.fallen.is_some(),
                };
                known && self.healthy.is_some() && segment > 0 && segment <= self.segments
            }
        }
    }

    /// Whether so many decided segments can leave these scores.
    fn scored(&self, decided: u32) -> bool {
        let EvidenceConstants { cap, segments_a_run, log_mean, defect_log_mean, .. } = self.constants;
        // Without a healthy class nothing is summed.
        // With directions only the novelty has a sum of the run, of falls.
        let (open, directed) = (self.run > 0, self.runs.are_used());
        let runs = if self.healthy.is_some() { decided } else { 0 };
        // A run adds its cap, its length and a mean; the margin is for roundings.
        let a_run = cap + log_mean.abs().max(defect_log_mean.abs()) + 1.0;
        let most = a_run * runs as f32 * 1.01;
        let good = |score: &Score, open: bool| {
            let begun = if open { score.run < f32::INFINITY } else { score.run == f32::NEG_INFINITY };
            score.sum >= 0.0 && score.sum <= most && begun
        };
        // A range beside the pairs would need a check of overflow.
        let mut class = 0_u8;
        let defects_good = pairs(self.defects.cells(), self.support.cells()).all(|(score, support)| {
            let healthy = Some(class) == self.healthy;
            class = class.wrapping_add(1);
            let lowest = -1.01 * cap * runs as f32;
            let weighed = good(score, open && !directed) && *support <= 0.0 && *support >= lowest;
            weighed && (!healthy || (*score == Score::ZERO && *support >= 0.0))
        });
        let novelty = good(&self.novelty, open) && (!open || directed || self.novelty.run.is_finite());
        novelty && defects_good && (self.run < segments_a_run || self.run == 0) && (runs > 0 || !open)
    }
}
