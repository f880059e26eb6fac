//! Commissioning by the reports of a detector: a healthy class learned on the drive, and the model that has it.

use crate::alarm::{CommissioningConstants, CommissioningError, HealthyClass};
use crate::model::Model;
use crate::plan::Plan;
use crate::reason::Reason;
use crate::report::{Report, Verdict};

/// Learns the healthy class of a drive from the reports of its healthy segments.
///
/// ```
/// # use bearing_watch::{Commissioning, Model, Report, plan::Plan};
/// # use bearing_watch::{alarm::CommissioningError, model::CommissioningConstants};
/// # fn run<P: Plan>(model: &Model<P>, reports: &[Report<P>]) -> Result<Model<P>, CommissioningError> {
/// let mut commissioning = Commissioning::new(model, CommissioningConstants::new(30, 10.0))?;
/// for report in reports {
///     let _why_not_used = commissioning.take(report).err();
/// }
/// commissioning.model()
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Commissioning<'m, P: Plan> {
    model: &'m Model<P>,
    class: HealthyClass<P>,
}

impl<'m, P: Plan> Commissioning<'m, P> {
    /// Without any segment, with the healthy class of this model as its prior.
    ///
    /// # Errors
    /// [`CommissioningError::NoHealthyClass`], [`CommissioningError::Constants`].
    pub fn new(model: &'m Model<P>, constants: CommissioningConstants) -> Result<Self, CommissioningError> {
        let class = HealthyClass::new(model.plan(), &model.constants().classifier, constants)?;
        Ok(Self { model, class })
    }

    /// Takes the report of a segment of the healthy drive, made by the model, not moved by a baseline. A segment that
    /// is refused is not used.
    ///
    /// # Errors
    /// Why the segment is refused.
    pub fn take(&mut self, report: &Report<P>) -> Result<(), CommissioningError> {
        if let Verdict::Undetermined(reason) = report.verdict {
            return Err(CommissioningError::NoVerdict(reason));
        }
        if report.model != self.model.mark() {
            return Err(CommissioningError::NoVerdict(Reason::OtherModel));
        }
        let constants = self.model.constants();
        self.class.take(self.model.plan(), &constants.classifier, report.estimates(constants.balance()))
    }

    /// The model with the healthy class of the drive. It has another [`Model::id`], so that evidence starts afresh.
    /// Needs room for several copies of a model on the stack.
    ///
    /// # Errors
    /// [`CommissioningError::TooFew`], [`CommissioningError::TooManyFar`], [`CommissioningError::TooWide`],
    /// [`CommissioningError::OutOfRange`].
    pub fn model(&self) -> Result<Model<P>, CommissioningError> {
        let (plan, trained) = (self.model.plan(), self.model.constants());
        let classifier = self.class.finish(plan, &trained.classifier)?;
        let mut constants = trained.clone();
        constants.classifier = classifier;
        constants.evidence = self.class.evidence().unwrap_or(constants.evidence);
        Model::new(plan, constants).map_err(|_| CommissioningError::OutOfRange)
    }

    /// Number of segments gathered.
    #[must_use]
    pub const fn gathered(&self) -> u32 {
        self.class.gathered()
    }

    /// Number of segments that were too far from the trained mean.
    #[must_use]
    pub const fn far(&self) -> u32 {
        self.class.far()
    }

    /// The merged mean so far, in coordinates.
    #[must_use]
    pub fn mean(&self) -> &[f32] {
        self.class.mean()
    }
}
