//! A model whose constants fit its plan and each other.

use super::constants::Constants;
use super::error::ModelError;
use super::stored::identity;
use super::validate::check;
use crate::drive::RotorFrame;
use crate::plan::{Cells, Plan};
use crate::report::Verdict;
use crate::signal::Label;

/// A checked model. A detector borrows it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Model<P: Plan> {
    plan: P,
    constants: Constants<P>,
    /// By which decisions, segments and reports of this model are known.
    id: u32,
}

impl<P: Plan> Model<P> {
    /// Checks the constants. A plan defined by [`plan!`](crate::plan!) has a function `model`, which can do so at
    /// compile time.
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub fn new(plan: P, constants: Constants<P>) -> Result<Self, ModelError> {
        let parts = constants.parts(plan);
        check(&parts)?;
        let id = identity(&parts);
        Ok(Self { plan, constants, id })
    }

    /// For constants that were checked before, with their identity.
    #[doc(hidden)]
    #[must_use]
    pub const fn identified(plan: P, constants: Constants<P>, id: u32) -> Self {
        Self { plan, constants, id }
    }

    /// The number by which the model is known, and what is made with it: models with other numbers have other ones, but
    /// for one pair in 2³². `train --c` writes it into the header.
    #[must_use]
    pub const fn id(&self) -> u32 {
        self.id
    }

    /// The plan.
    #[inline(always)]
    #[must_use]
    pub const fn plan(&self) -> P {
        self.plan
    }

    /// The trained numbers.
    #[inline(always)]
    #[must_use]
    pub const fn constants(&self) -> &Constants<P> {
        &self.constants
    }

    /// Name of a class; empty if there is no such class.
    #[must_use]
    pub fn label(&self, class: u8) -> &str {
        self.constants.labels.cells().get(class as usize).map_or("", Label::as_str)
    }

    /// A verdict in a word: the name of its class, or `novel`, `ambiguous`, `undetermined`.
    #[must_use]
    pub fn verdict_name(&self, verdict: Verdict) -> &str {
        match verdict {
            Verdict::Class(class) => self.label(class),
            Verdict::Novel => "novel",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Undetermined(_) => "undetermined",
        }
    }

    /// Checks that a rotor frame transforms currents as the recordings were transformed on which the model was trained.
    ///
    /// # Errors
    /// [`ModelError::Park`] if the sign conventions differ.
    pub fn check_rotor_frame(&self, frame: &RotorFrame) -> Result<(), ModelError> {
        match self.constants.sampling.park {
            Some(trained) if trained != frame.park => Err(ModelError::Park { trained, given: frame.park }),
            _ => Ok(()),
        }
    }

    /// Checks the sampling interval.
    ///
    /// # Errors
    /// [`ModelError::Interval`] if both intervals are known and differ by more than 1 %.
    pub fn check_interval(&self, interval_s: f32) -> Result<(), ModelError> {
        let trained_s = self.constants.sampling.interval_s;
        let unknown = trained_s <= 0.0 || interval_s <= 0.0;
        let ratio = interval_s / trained_s;
        let same = unknown || (0.99..=1.01).contains(&ratio);
        if same { Ok(()) } else { Err(ModelError::Interval { trained_s, given_s: interval_s }) }
    }
}
