//! The evidence of a model.

use crate::alarm::Evidence;
use crate::model::Model;
use crate::plan::Plan;

impl<P: Plan> Evidence<P> {
    /// Without any segment yet.
    #[must_use]
    pub fn new(model: &Model<P>) -> Self {
        let constants = model.constants();
        let novelty = &constants.classifier.novelty;
        Self::empty(model.plan(), constants.evidence, &novelty.directions, novelty.class)
            .of_model(model.id(), constants.sampling.segment_s())
    }
}
