//! Models of the core whose layout is known only at run time.

use bearing_watch::model::{
    Channel, Classifier, Constants, Covariates, Discriminant, EvidenceConstants, Feature, Label, Novelty, Projection,
    Regression, Sampling, ShaftConstants,
};
use bearing_watch::plan::{Kind, Layout, Plan, RegressionLayout, RunTime, ShaftLayout};
use bearing_watch::{Model, ModelError};

/// The parts of a detector that estimate.
#[derive(Clone, Debug)]
pub struct Parts {
    /// The channels.
    pub channels: Vec<Channel>,
    /// The regression.
    pub regression: Option<(RegressionLayout, Regression<RunTime>)>,
    /// The shaft.
    pub shaft: Option<(ShaftLayout, ShaftConstants<RunTime>)>,
    /// The channels whose averages are features or covariates, as a bit mask.
    pub averaged: u16,
}

impl Parts {
    /// The layout with the given numbers of features, coordinates and classes.
    #[must_use]
    pub fn layout(&self, [features, coordinates, classes]: [u8; 3], discriminant: Kind) -> Layout {
        Layout {
            channels: self.channels.len() as u8,
            regression: self.regression.as_ref().map(|(layout, _)| *layout),
            shaft: self.shaft.as_ref().map(|(layout, _)| *layout),
            averaged: self.averaged,
            features,
            coordinates,
            classes,
            discriminant,
            ..Layout::EMPTY
        }
    }

    /// A model that estimates but does not decide: it has one class. It has one feature of each part, each a
    /// coordinate, so a segment has a verdict if a part has a result; so has the mean of each averaged channel.
    ///
    /// # Errors
    /// Errors of the core.
    pub fn estimating(&self, sampling: Sampling) -> Result<Model<RunTime>, ModelError> {
        let mut features = Vec::new();
        if self.regression.is_some() {
            features.push(Feature::Parameter(0));
        }
        if let Some((shaft, _)) = &self.shaft {
            features.push(Feature::LogFrictionVariance);
            features.extend((shaft.orders > 0).then_some(Feature::OrderScore(0)));
        }
        features.extend((0..16).filter(|place| (self.averaged >> place) & 1 == 1).map(Feature::ChannelMean));
        let n = features.len();
        let plan = plan(self.layout([n as u8, n as u8, 1], Kind::Linear))?;
        let identity = (0..n * n).map(|k| f32::from(u8::from(k / n == k % n)));
        let factor = (0..n).flat_map(|i| (i..n).map(move |j| f32::from(u8::from(i == j))));
        let classifier = Classifier {
            features,
            covariates: Covariates { list: vec![], map: vec![] },
            projection: Projection { matrix: identity.collect(), mean: vec![0.0; n], usual: vec![0.0; n] },
            discriminant: Discriminant {
                means: vec![0.0; n],
                factors: factor.collect(),
                log_prior: vec![0.0],
                costs: vec![0.0],
                reject_cost: f32::INFINITY,
            },
            novelty: Novelty::none(plan),
        };
        self.model(plan, sampling, classifier, EvidenceConstants::NONE, vec![Label::constant("all")])
    }

    /// The model with a classifier.
    ///
    /// # Errors
    /// Errors of the core.
    pub fn model(
        &self,
        plan: RunTime,
        sampling: Sampling,
        classifier: Classifier<RunTime>,
        evidence: EvidenceConstants,
        labels: Vec<Label>,
    ) -> Result<Model<RunTime>, ModelError> {
        let constants = Constants {
            sampling,
            channels: self.channels.clone(),
            regression: self.regression.iter().map(|(_, constants)| constants.clone()).collect(),
            shaft: self.shaft.iter().map(|(_, constants)| constants.clone()).collect(),
            classifier,
            evidence,
            labels,
        };
        Model::new(plan, constants)
    }
}

/// The plan of a layout.
///
/// # Errors
/// A layout whose parts are inconsistent.
pub fn plan(layout: Layout) -> Result<RunTime, ModelError> {
    layout.check().map_err(ModelError::Layout)?;
    RunTime::of(layout).ok_or(ModelError::OtherPlan)
}
