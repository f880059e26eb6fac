//! A healthy mean that follows slow changes of the surroundings, within a bound; off unless a program uses it.
//!
//! Enters: the results of a segment. Leaves: the decision at coordinates less the offset, and the next offset.
//!
//! ```text
//! z' = z − o                                                             (1)  decided by the classifier as it is
//! o_k ← o_k + g/(1 + v_k) (z'_k − m_k)                                   (2)  if z' is judged healthy with s < gate
//! |o| = √(oᵀ S⁻¹ o) ≤ bound,  else o ← o bound/|o|                       (3)
//! ```
//!
//! o: offset, g: gain, m and S: healthy mean and covariance, v: excess variance of a coordinate's error, s: surprise.
//! The time constant of (2) is 1/g segments. The offset follows a slow change with a lag of its rate times 1/g; it does
//! not follow a step whose surprise reaches the gate. It follows wear too, which is slow, up to (3): by the triangle
//! inequality the baseline lowers the distance of a segment by at most `bound`, in healthy standard deviations. When
//! (3) clips, [`Baseline::at_bound`] is set until [`Baseline::reset`]: report it as a separate alarm, since either the
//! surroundings or the bearing changed more than expected. If the bound is below the distance at the gate, the offset
//! also follows when a change that it had followed ends suddenly.
//!
//! Missing coordinates remain as they are. Cost: a second classification of the segment, at once.

use crate::decide::gates::density::Density;
use crate::decide::{Classification, Classifier, Decision, Estimates, MAX_SURPRISE, Novelty, UNMARKED, Verdict};
use crate::plan::{Array, Cells, Plan};
use crate::reason::Reason;
use crate::regression::factor::pairs;

/// Constants of a baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BaselineConstants {
    /// g of (2), above 0 and at most 1.
    pub gain: f32,
    /// Surprise from which on a segment is not followed, nats; above 0 and at most 40, the largest surprise.
    pub gate: f32,
    /// Largest length (3) of the offset, healthy standard deviations; above 0 and at most 100.
    pub bound: f32,
}

impl BaselineConstants {
    /// As far as any baseline can go.
    pub(crate) const WIDEST: Self = Self { gain: 1.0, gate: MAX_SURPRISE, bound: MOST_BOUND };

    /// A time constant in segments and a bound, with a gate of 3 nats: 95 % of healthy segments are followed.
    #[must_use]
    pub fn new(segments: f32, bound: f32) -> Self {
        Self { gain: 1.0 / segments, gate: 3.0, bound }
    }

    fn are_good(&self) -> bool {
        let Self { gain, gate, bound } = *self;
        // A gate beyond the largest surprise would have no end.
        gain > 0.0 && gain <= 1.0 && gate > 0.0 && gate <= MAX_SURPRISE && bound > 0.0 && bound <= MOST_BOUND
    }

    /// The constants as words.
    const fn words(&self) -> [u32; 3] {
        [self.gain.to_bits(), self.gate.to_bits(), self.bound.to_bits()]
    }
}

/// Largest bound: at a hundred deviations nothing of a distance is left.
const MOST_BOUND: f32 = 100.0;
/// An offset at its bound may exceed it by roundings of its length.
const ROUNDING: f32 = 1.0 + 1e-5;

/// Running state of the baseline, which is applied to each report before the evidence.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Baseline<P: Plan> {
    constants: BaselineConstants,
    /// S of (3) as D and R.
    factor: Array<P::Density, f32>,
    offset: Array<P::Coordinates, f32>,
    at_bound: bool,
    /// The mark of the model.
    model: u32,
}

/// What is wrong with a stored offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BaselineMismatch {
    /// A word is missing, or none that a baseline can have.
    Value,
    /// The baseline had other constants.
    Constants,
}

impl<P: Plan> Baseline<P> {
    /// Without any offset; `None` if a constant is out of range.
    pub(crate) fn without_offset(plan: P, novelty: &Novelty<P>, constants: BaselineConstants) -> Option<Self> {
        let (factor, offset) = (novelty.factor.clone(), Cells::filled(plan.layout().coordinates as usize, 0.0));
        constants.are_good().then_some(Self { constants, factor, offset, at_bound: false, model: UNMARKED })
    }

    /// Of the model with this mark.
    pub(crate) fn of_model(self, model: u32) -> Self {
        Self { model, ..self }
    }

    /// The mark of the model.
    pub(crate) const fn model(&self) -> u32 {
        self.model
    }

    /// The offset o in coordinates, to be stored.
    #[must_use]
    pub fn offset(&self) -> &[f32] {
        self.offset.cells()
    }

    /// Whether the bound was reached since the last reset.
    #[must_use]
    pub const fn at_bound(&self) -> bool {
        self.at_bound
    }

    /// Continues from a stored state. Returns `false`, and does nothing, if the offset does not fit or exceeds the
    /// bound.
    pub fn restore(&mut self, offset: &[f32], at_bound: bool) -> bool {
        let fits = offset.len() == self.offset().len() && self.is_within(offset);
        if fits {
            pairs(self.offset.cells_mut(), offset).for_each(|(cell, x)| *cell = *x);
            self.at_bound = at_bound;
        }
        fits
    }

    /// |o| of (3).
    fn length(&self, offset: &[f32]) -> f32 {
        let density = Density::<P>::of(self.factor.cells(), &[], offset.len());
        libm::sqrtf(density.squared_distance(&[], offset))
    }

    /// Whether an offset is within the bound; not if it has a value that is not finite.
    fn is_within(&self, offset: &[f32]) -> bool {
        self.length(offset) <= self.constants.bound * ROUNDING
    }

    /// Number of words of the constants.
    pub(crate) const LATER_WORDS: usize = 3;

    /// Number of words of the state for so many coordinates.
    pub(crate) const fn words(coordinates: u8) -> usize {
        (coordinates as usize).saturating_add(1)
    }

    /// Hands out the words in their order.
    pub(crate) fn save(&self, put: &mut impl FnMut(u32)) {
        put(self.at_bound.into());
        self.offset().iter().for_each(|x| put(x.to_bits()));
    }

    /// Hands out the words of the constants.
    pub(crate) fn save_constants(&self, put: &mut impl FnMut(u32)) {
        self.constants.words().into_iter().for_each(put);
    }

    /// Takes the words in their order; `None` if one is missing or out of range. The state is then of no use.
    pub(crate) fn restore_words(&mut self, take: &mut impl FnMut() -> Option<u32>) -> Option<()> {
        self.at_bound = match take()? {
            0 => false,
            1 => true,
            _ => return None,
        };
        for cell in self.offset.cells_mut() {
            *cell = f32::from_bits(take()?);
        }
        self.is_within(self.offset()).then_some(())
    }

    /// Takes the words of the constants, which must be those of this baseline.
    ///
    /// # Errors
    /// What does not fit.
    pub(crate) fn check_constants(&self, take: &mut impl FnMut() -> Option<u32>) -> Result<(), BaselineMismatch> {
        let [Some(gain), Some(gate), Some(bound)] = [take(), take(), take()] else {
            return Err(BaselineMismatch::Value);
        };
        let [gain, gate, bound] = [gain, gate, bound].map(f32::from_bits);
        let saved = BaselineConstants { gain, gate, bound };
        if !saved.are_good() {
            return Err(BaselineMismatch::Value);
        }
        if saved.words() == self.constants.words() { Ok(()) } else { Err(BaselineMismatch::Constants) }
    }

    /// Starts afresh, as after a repair.
    pub fn reset(&mut self) {
        self.offset.cells_mut().fill(0.0);
        self.at_bound = false;
    }

    /// Decides by (1), then follows.
    ///
    /// # Errors
    /// The segment has no verdict for this reason; the offset remains.
    pub(crate) fn decide(
        &mut self,
        plan: P,
        classifier: &Classifier<P>,
        estimates: Estimates<'_, P>,
        decision: &mut Decision<P>,
    ) -> Result<(), Reason> {
        let mut classification = Classification::new(plan);
        classification.run(plan, classifier, estimates, self.offset(), decision)?;
        let healthy = classifier.novelty.class.map(Verdict::Class);
        // Written so that NaN is not followed.
        if Some(classifier.verdict(decision)) == healthy && decision.surprise < self.constants.gate {
            let (z, variances) = classification.coordinates();
            self.move_to(classifier, z, variances);
        }
        Ok(())
    }

    /// (2) and (3).
    fn move_to(&mut self, classifier: &Classifier<P>, z: &[f32], variances: &[f32]) {
        let away = pairs(pairs(z, classifier.novelty.mean.cells()), variances);
        for (cell, ((z, mean), variance)) in pairs(self.offset.cells_mut(), away) {
            let step = self.constants.gain / (1.0 + variance) * (z - mean);
            if variance.is_finite() && step.is_finite() {
                *cell += step; // (2)
            }
        }
        let length = self.length(self.offset());
        if length > self.constants.bound {
            let shorter = self.constants.bound / length; // (3)
            self.offset.cells_mut().iter_mut().for_each(|cell| *cell *= shorter);
            self.at_bound = true;
        }
    }
}

#[cfg(test)]
mod tests;
