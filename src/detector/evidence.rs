//! The evidence of a model.

use crate::alarm::Evidence;
use crate::model::{Model, Sampling};
use crate::plan::Plan;

impl<P: Plan> Evidence<P> {
    /// Without any segment yet.
    #[must_use]
    pub fn new(model: &Model<P>) -> Self {
        let constants = model.constants();
        let Sampling { interval_s, block_mean, segment_samples, .. } = constants.sampling;
        let segment_s = interval_s * f32::from(block_mean) * segment_samples as f32;
        let novelty = &constants.classifier.novelty;
        Self::empty(model.plan(), constants.evidence, &novelty.directions, novelty.class)
            .of_model(model.mark(), segment_s)
    }
}
