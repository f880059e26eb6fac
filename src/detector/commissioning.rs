//! Commissioning by the reports of a detector.

use crate::alarm::{Commissioning, CommissioningConstants, CommissioningError};
use crate::model::Model;
use crate::plan::Plan;
use crate::reason::Reason;
use crate::report::Report;

impl<P: Plan> Model<P> {
    /// A commissioning without any segment, with the healthy class of this model as its prior.
    ///
    /// # Errors
    /// [`CommissioningError::NoHealthyClass`], [`CommissioningError::Constants`].
    pub fn commissioning(&self, constants: CommissioningConstants) -> Result<Commissioning<P>, CommissioningError> {
        Commissioning::new(self.plan(), &self.constants().classifier, constants)
    }

    /// Takes the report of a segment of the healthy drive, made by this model, not moved by a baseline. A segment that
    /// is refused is not used.
    ///
    /// # Errors
    /// Why the segment is refused.
    pub fn gather(&self, commissioning: &mut Commissioning<P>, report: &Report<P>) -> Result<(), CommissioningError> {
        if let crate::Verdict::Undetermined(reason) = report.verdict {
            return Err(CommissioningError::NoVerdict(reason));
        }
        if report.model != self.mark() {
            return Err(CommissioningError::NoVerdict(Reason::OtherModel));
        }
        commissioning.take(self.plan(), &self.constants().classifier, report.estimates(self.constants().balance()))
    }

    /// This model with the healthy class of the drive. It has another [`Model::id`], so that evidence starts afresh.
    /// Needs room for several copies of a model on the stack.
    ///
    /// # Errors
    /// [`CommissioningError::TooFew`], [`CommissioningError::TooManyFar`], [`CommissioningError::TooWide`],
    /// [`CommissioningError::OutOfRange`].
    pub fn commissioned(&self, commissioning: &Commissioning<P>) -> Result<Self, CommissioningError> {
        let classifier = commissioning.finish(self.plan(), &self.constants().classifier)?;
        let mut constants = self.constants().clone();
        constants.classifier = classifier;
        constants.evidence = commissioning.evidence().unwrap_or(constants.evidence);
        Self::new(self.plan(), constants).map_err(|_| CommissioningError::OutOfRange)
    }
}
