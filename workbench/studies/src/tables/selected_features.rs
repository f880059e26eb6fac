//! Selected features of a training and a validation set, and the source's classifiers on them.

use bearing_watch::plan::Kind;

use crate::literal::{Judged, Rule, principal};
use model::Error;
use model::train::{FeatureTable, ProjectionKind};

/// Selected features of both sets.
pub(super) struct Chosen {
    pub(super) names: Vec<String>,
    pub(super) training: FeatureTable,
    pub(super) validation: FeatureTable,
}

impl Chosen {
    /// The first two features, as the source takes without PCA (§3.3).
    pub(super) fn first_two(&self) -> Self {
        let select = |table: &FeatureTable| table.select(&[0, 1]);
        Self { names: self.names[..2].to_vec(), training: select(&self.training), validation: select(&self.validation) }
    }

    /// The source's projection of these features.
    pub(super) fn to_two(&self) -> ProjectionKind {
        principal(self.names.len())
    }

    pub(super) fn rule(&self, projection: ProjectionKind, kind: Kind) -> Result<Rule, Error> {
        Rule::train(&self.training, &self.names, projection, kind)
    }

    /// Decisions on the training and on the validation set.
    pub(super) fn judge(&self, rule: &Rule) -> [Judged; 2] {
        [rule.judge(&self.training), rule.judge(&self.validation)]
    }
}
