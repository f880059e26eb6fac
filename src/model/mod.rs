//! The trained constants: a `const` in flash, or read from a checked binary form.

mod bytes;
mod error;
mod mark;
mod parts;
mod ranges;
mod reader;
mod validate;
mod writer;

pub use crate::decide::{
    BaselineConstants, Classifier, CommissioningConstants, Covariate, Covariates, Departure, Discriminant, Estimates,
    EvidenceConstants, Feature, FeatureValue, KNOTS, Law, Novelty, Projection,
};
pub use crate::factor::{Forgetting, MAX_LAMBDA, MAX_LONG_SEGMENT_ROWS, MAX_SEGMENT_ROWS};
pub use crate::regression::Regression;
pub use crate::sample::{Channel, Label, Name};
pub use crate::shaft::{
    Balance, Blocks, CONTROLS, Lags, MAX_LAG, ShaftConstants, StateVariable, TERMS, TrackedOrder, Tracking, q16,
};
pub use bytes::{MAX_BYTES, layout, notes, stored_len};
pub use error::{Field, ModelError};
#[doc(hidden)]
pub use parts::{Parts, RegressionParts, ShaftParts};
#[doc(hidden)]
pub use {mark::mark, validate::check};
#[cfg(feature = "telemetry")]
pub(crate) use {
    reader::Reader,
    writer::{Buffer, Writer},
};

use crate::decide::{Baseline, Evidence, UNMARKED};
use crate::drive::{Park, RotorFrame};
use crate::plan::{Array, Cells, Plan};

/// Longest block mean: plain sums of more samples lose digits.
pub const MAX_BLOCK_MEAN: u16 = 1000;

/// When samples are taken and how many make a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sampling {
    /// Sampling interval, s; 0 if it is unknown.
    pub interval_s: f32,
    /// Sign convention of the quadrature current; `None` if the current is not from a Park transform.
    pub park: Option<Park>,
    /// Number of samples averaged into one before the regression; 1 for none, at most [`MAX_BLOCK_MEAN`].
    pub block_mean: u16,
    /// Number of samples in a segment, after averaging.
    pub segment_samples: u32,
}

/// Everything that was trained, as plain numbers. [`Model::new`] checks them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Constants<P: Plan> {
    /// Rate and segment length.
    pub sampling: Sampling,
    /// The channels, in the order of the sample.
    pub channels: Array<P::Channels, Channel>,
    /// The regression: one element, or none.
    pub regression: Array<P::Regressed, Regression<P>>,
    /// The shaft: one element, or none.
    pub shaft: Array<P::Watched, ShaftConstants<P>>,
    /// Features, projection, discriminant and novelty.
    pub classifier: Classifier<P>,
    /// Constants of the alarm over many segments.
    pub evidence: EvidenceConstants,
    /// Class names, none of them empty.
    pub labels: Array<P::Classes, Label>,
}

impl<P: Plan> Constants<P> {
    /// The torque balance of the shaft, if there is one.
    pub(crate) fn balance(&self) -> Option<&Balance> {
        self.shaft.part().map(|shaft| &shaft.balance)
    }
}

/// A checked model. A detector borrows it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Model<P: Plan> {
    plan: P,
    constants: Constants<P>,
    /// By which decisions, segments and reports of this model are known.
    mark: u32,
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
        let mark = mark(&parts);
        Ok(Self { plan, constants, mark })
    }

    /// For constants that were not checked, in tests.
    #[doc(hidden)]
    #[must_use]
    pub const fn checked(plan: P, constants: Constants<P>) -> Self {
        Self::marked(plan, constants, UNMARKED)
    }

    /// For constants that were checked before.
    #[doc(hidden)]
    #[must_use]
    pub const fn marked(plan: P, constants: Constants<P>, mark: u32) -> Self {
        Self { plan, constants, mark }
    }

    /// The mark of what is made with this model.
    pub(crate) const fn mark(&self) -> u32 {
        self.mark
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

    /// A baseline that follows slow changes, without any offset yet; `None` if a constant is out of range, or the model
    /// has no healthy class.
    #[must_use]
    pub fn baseline(&self, constants: BaselineConstants) -> Option<Baseline<P>> {
        let novelty = &self.constants.classifier.novelty;
        novelty
            .class
            .and_then(|_| Baseline::new(self.plan, novelty, constants))
            .map(|baseline| baseline.of_model(self.mark))
    }

    /// Evidence without any segment yet.
    #[must_use]
    pub fn evidence(&self) -> Evidence<P> {
        let Sampling { interval_s, block_mean, segment_samples, .. } = self.constants.sampling;
        let segment_s = interval_s * f32::from(block_mean) * segment_samples as f32;
        let healthy = self.constants.classifier.novelty.class;
        Evidence::new(self.plan, self.constants.evidence, healthy).of_model(self.mark, segment_s)
    }
}

impl<P: Plan> Constants<P> {
    fn parts(&self, plan: P) -> Parts<'_> {
        let Classifier { features, covariates, projection, discriminant, novelty } = &self.classifier;
        Parts {
            layout: plan.layout(),
            names: P::channels().unwrap_or(&[]),
            sampling: &self.sampling,
            channels: self.channels.cells(),
            regression: self.regression.part().map(|regression| RegressionParts {
                scale: regression.scale.cells(),
                nominal: regression.nominal.cells(),
                deviation: regression.deviation,
                forgetting: regression.forgetting,
                huber: regression.huber,
                rest: regression.rest,
                settle: regression.settle,
                handover: regression.handover,
            }),
            shaft: self.shaft.part().map(|shaft| ShaftParts {
                lags: shaft.lags,
                balance: &shaft.balance,
                orders: shaft.tracking.orders.cells(),
                blocks: shaft.tracking.blocks,
            }),
            features: features.cells(),
            covariates: covariates.list.cells(),
            explained: covariates.map.cells(),
            map: projection.matrix.cells(),
            feature_means: projection.mean.cells(),
            usual: projection.usual.cells(),
            means: discriminant.means.cells(),
            factors: discriminant.factors.cells(),
            log_prior: discriminant.log_prior.cells(),
            costs: discriminant.costs.cells(),
            reject_cost: discriminant.reject_cost,
            healthy: novelty.class,
            novelty_mean: novelty.mean.cells(),
            novelty_factor: novelty.factor.cells(),
            knots: &novelty.knots,
            laws: novelty.laws.cells(),
            freedom: novelty.freedom,
            limit: novelty.limit,
            evidence: self.evidence,
            labels: self.labels.cells(),
        }
    }
}

/// Gives a plan the function `model`, which can check constants at compile time.
///
/// Inside the expansion every length is known, so that the slices of the view can be made in a constant.
#[doc(hidden)]
#[macro_export]
macro_rules! checked_model {
    ($plan:ident, $layout:expr, $channels:expr) => {
        impl $plan {
            /// The model of these constants. A `const` or `static` that matches the result and panics on the error
            /// does not compile if they do not fit.
            ///
            /// # Errors
            /// The first thing that does not fit.
            #[allow(dead_code, reason = "a plan may read its models from bytes only")]
            pub const fn model(
                constants: $crate::model::Constants<Self>,
            ) -> Result<$crate::Model<Self>, $crate::ModelError> {
                let mark = {
                    let $crate::model::Constants { sampling, channels, regression, shaft, classifier, .. } = &constants;
                    let regression: &[$crate::model::Regression<Self>] = regression;
                    let shaft: &[$crate::model::ShaftConstants<Self>] = shaft;
                    let parts = $crate::model::Parts {
                        layout: $layout,
                        names: $channels,
                        sampling,
                        channels,
                        regression: match regression {
                            [first, ..] => Some($crate::model::RegressionParts {
                                scale: &first.scale,
                                nominal: &first.nominal,
                                deviation: first.deviation,
                                forgetting: first.forgetting,
                                huber: first.huber,
                                rest: first.rest,
                                settle: first.settle,
                                handover: first.handover,
                            }),
                            [] => None,
                        },
                        shaft: match shaft {
                            [first, ..] => Some($crate::model::ShaftParts {
                                lags: first.lags,
                                balance: &first.balance,
                                orders: &first.tracking.orders,
                                blocks: first.tracking.blocks,
                            }),
                            [] => None,
                        },
                        features: &classifier.features,
                        covariates: &classifier.covariates.list,
                        explained: &classifier.covariates.map,
                        map: &classifier.projection.matrix,
                        feature_means: &classifier.projection.mean,
                        usual: &classifier.projection.usual,
                        means: &classifier.discriminant.means,
                        factors: &classifier.discriminant.factors,
                        log_prior: &classifier.discriminant.log_prior,
                        costs: &classifier.discriminant.costs,
                        reject_cost: classifier.discriminant.reject_cost,
                        healthy: classifier.novelty.class,
                        novelty_mean: &classifier.novelty.mean,
                        novelty_factor: &classifier.novelty.factor,
                        knots: &classifier.novelty.knots,
                        laws: &classifier.novelty.laws,
                        freedom: classifier.novelty.freedom,
                        limit: classifier.novelty.limit,
                        evidence: constants.evidence,
                        labels: &constants.labels,
                    };
                    if let Err(error) = $crate::model::check(&parts) {
                        return Err(error);
                    }
                    $crate::model::mark(&parts)
                };
                Ok($crate::Model::marked(Self, constants, mark))
            }
        }
    };
}
