//! What one segment of a trace gave, free of capacities.

use bearing_watch::decide::Finding as CoreFinding;
use bearing_watch::{Counts, Friction, OrderStrength, Verdict};

/// One segment of a trace: verdict, estimates and counts.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentReport {
    /// What it was found to be, or why nothing can be said.
    pub verdict: Result<Finding, String>,
    /// Posterior of each class; empty where there is no verdict.
    pub posteriors: Vec<f32>,
    /// Log-likelihood of each class; empty where there is no verdict.
    pub log_likelihoods: Vec<f32>,
    /// Distance from the healthy class in its deviations; 0 where there is none or no verdict.
    pub distance: f32,
    /// −ln of the probability that a healthy segment lies so far, nats; 0 likewise.
    pub surprise: f32,
    /// δ-parameters.
    pub delta: Vec<f32>,
    /// a₁…, b₁…, c₁…, constant.
    pub raw: Vec<f32>,
    /// Residual variance.
    pub variance: f32,
    /// The torque balance, where the shaft is watched.
    pub friction: Option<Friction>,
    /// The bearing orders.
    pub orders: Vec<OrderStrength>,
    /// Features of the shaft ([`super::features::Catalogue::shaft`]); empty where it says nothing.
    pub shaft_features: Vec<f32>,
    /// Rows of the regression.
    pub rows: u32,
    /// What the segment was denied.
    pub counts: Counts,
    /// Samples before the segment, as fed to the detector.
    pub start: usize,
    /// Samples of the segment, as fed to the detector.
    pub length: usize,
}

impl SegmentReport {
    /// The same segment without a verdict, for this reason.
    pub(super) fn undetermined(self, reason: String) -> Self {
        let (posteriors, log_likelihoods) = (vec![], vec![]);
        Self { verdict: Err(reason), posteriors, log_likelihoods, distance: 0.0, surprise: 0.0, ..self }
    }
}

/// What a segment or trace was found to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// Index of a class.
    Class(usize),
    /// Nearest to healthy, but not healthy.
    Novel,
    /// No class worth naming.
    Ambiguous,
}

impl Finding {
    /// The class, where one is named.
    #[must_use]
    pub const fn class(self) -> Option<usize> {
        match self {
            Self::Class(class) => Some(class),
            Self::Novel | Self::Ambiguous => None,
        }
    }

    /// In a word.
    #[must_use]
    pub fn name(self, classes: &[String]) -> &str {
        match self {
            Self::Class(class) => classes.get(class).map_or("", String::as_str),
            Self::Novel => "novel",
            Self::Ambiguous => "ambiguous",
        }
    }

    /// Nothing where the verdict is undetermined.
    pub(super) const fn of(verdict: Verdict) -> Option<Self> {
        match verdict {
            Verdict::Class(class) => Some(Self::Class(class as usize)),
            Verdict::Novel => Some(Self::Novel),
            Verdict::Ambiguous => Some(Self::Ambiguous),
            Verdict::Undetermined(_) => None,
        }
    }
}

impl From<CoreFinding> for Finding {
    fn from(finding: CoreFinding) -> Self {
        match finding {
            CoreFinding::Class(class) => Self::Class(class as usize),
            CoreFinding::Novel => Self::Novel,
            CoreFinding::Ambiguous => Self::Ambiguous,
        }
    }
}
