//! Everything that was trained, as plain numbers.

use super::parts::{Parts, RegressionParts, RunParts, ShaftParts};
use super::sampling::Sampling;
use crate::alarm::EvidenceConstants;
use crate::decide::Classifier;
use crate::plan::{Array, Cells, Plan};
use crate::regression::Regression;
use crate::shaft::Balance;
use crate::shaft::state::ShaftConstants;
use crate::signal::{Channel, Label};

/// Everything that was trained, as plain numbers. [`Model::new`](super::Model::new) checks them.
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

impl<P: Plan> Constants<P> {
    pub(super) fn parts(&self, plan: P) -> Parts<'_> {
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
            directions: novelty.directions.list.cells(),
            runs: RunParts {
                usual_segments: novelty.directions.usual_segments,
                margin: novelty.directions.margin,
                most_runs: novelty.directions.most_runs,
            },
            evidence: self.evidence,
            labels: self.labels.cells(),
        }
    }
}
