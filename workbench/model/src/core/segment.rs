//! What the detector reported on one segment of a trace.

use bearing_watch::model::{Fall, Feature, FeatureValue, Most};
use bearing_watch::shaft::{Friction, OrderStrength};
use bearing_watch::{Average, Counts, Reason, Verdict};

/// One segment of a trace: verdict, estimates and counts.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentReport {
    /// The finding, or why there is none.
    pub verdict: Result<Finding, String>,
    /// Posterior of each class; empty if there is no verdict.
    pub posteriors: Vec<f32>,
    /// Log-likelihood of each class; empty if there is no verdict.
    pub log_likelihoods: Vec<f32>,
    /// Whether the segment is beyond the gate of each class; empty if there is no verdict.
    pub beyond: Vec<bool>,
    /// The value of each direction that the alarm watches; empty if there is no verdict.
    pub directed: Vec<FeatureValue>,
    /// Why there is no verdict, if the core says so.
    pub reason: Option<Reason>,
    /// Distance from the healthy class in its standard deviations; 0 if there is no healthy class or no verdict.
    pub distance: f32,
    /// −ln of the probability that a healthy segment has at least this distance, nats; 0 in the same cases.
    pub distance_surprise: f32,
    /// The same of the distance and of coordinates that rise with a defect, which the gate compares.
    pub surprise: f32,
    /// The coordinate that departs most from healthy.
    pub most: Option<Most>,
    /// The rarest fall of a coordinate that a defect raises.
    pub fall: Fall,
    /// The smallest defect that the segment would have shown, of each coordinate that rises with one: a part of the
    /// usual friction, or the amplitude at an order, A; infinite where it shows none.
    pub smallest: Vec<(u8, f32)>,
    /// δ-parameters.
    pub delta: Vec<f32>,
    /// a₁…, b₁…, c₁…, constant.
    pub raw: Vec<f32>,
    /// Residual variance.
    pub variance: f32,
    /// The torque balance, if the shaft is watched.
    pub friction: Option<Friction>,
    /// The bearing orders.
    pub orders: Vec<OrderStrength>,
    /// Whether the regression has a result.
    pub estimated: bool,
    /// Features of the shaft ([`super::features::Catalogue::shaft`]).
    pub shaft_features: Vec<FeatureValue>,
    /// Averages of channels.
    pub averages: Vec<Average>,
    /// Whether each covariate was missing or outside its range; of an undetermined segment only the first.
    pub outside: Vec<bool>,
    /// The model's features that were missing; empty if there is no verdict.
    pub missing: Vec<Feature>,
    /// Rows of the regression.
    pub rows: u32,
    /// Numbers of samples and rows that were rejected, and the stuck channels.
    pub counts: Counts,
    /// Number of samples before the segment, as passed to the detector.
    pub start: usize,
    /// Number of samples of the segment, as passed to the detector.
    pub length: usize,
}

impl SegmentReport {
    /// The segment with the verdict replaced by this reason.
    pub(super) fn undetermined(self, reason: String) -> Self {
        let (posteriors, log_likelihoods) = (vec![], vec![]);
        let (missing, outside) = (vec![], vec![]);
        Self {
            verdict: Err(reason),
            posteriors,
            log_likelihoods,
            beyond: vec![],
            missing,
            outside,
            distance: 0.0,
            distance_surprise: 0.0,
            surprise: 0.0,
            most: None,
            fall: Fall::default(),
            ..self
        }
    }
}

/// The finding on a segment or trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// Index of a class.
    Class(usize),
    /// Nearest to the healthy class, but not healthy; or far from every class.
    Novel,
    /// No class is plausible enough.
    Ambiguous,
}

impl Finding {
    /// The class, if there is one.
    #[must_use]
    pub const fn class(self) -> Option<usize> {
        match self {
            Self::Class(class) => Some(class),
            Self::Novel | Self::Ambiguous => None,
        }
    }

    /// Name of the finding.
    #[must_use]
    pub fn name(self, classes: &[String]) -> &str {
        match self {
            Self::Class(class) => classes.get(class).map_or("", String::as_str),
            Self::Novel => "novel",
            Self::Ambiguous => "ambiguous",
        }
    }

    /// Converts a verdict; `None` if it is undetermined.
    pub(super) const fn of(verdict: Verdict) -> Option<Self> {
        match verdict {
            Verdict::Class(class) => Some(Self::Class(class as usize)),
            Verdict::Novel => Some(Self::Novel),
            Verdict::Ambiguous => Some(Self::Ambiguous),
            Verdict::Undetermined(_) => None,
        }
    }
}
