//! A model of the standard rig that raises alarms.

use bearing_watch::Model;
use bearing_watch::model::{EvidenceConstants, KNOTS, Novelty};

use crate::standard_rig::model::{Drive, MODEL};

/// The model of the rig with a gate about its healthy class, whose surprise is half of the squared distance, and an
/// alarm after two segments of defects or more.
pub fn model() -> Model<Drive> {
    let mut constants = MODEL.constants().clone();
    let mut knots = [[0.0; 2]; KNOTS];
    for (k, knot) in (0_u8..).zip(&mut knots) {
        *knot = [2.0 * f32::from(k), f32::from(k)];
    }
    let healthy = &constants.classifier.discriminant;
    constants.classifier.novelty = Novelty {
        class: Some(0),
        mean: healthy.means[..5].try_into().unwrap(),
        factor: healthy.factors,
        knots,
        limit: 7.0,
        ..constants.classifier.novelty
    };
    constants.evidence = EvidenceConstants { bet: 0.2, limit: 8.0, cap: 5.0, ..EvidenceConstants::NONE };
    Drive::model(constants).expect("a model that fits")
}
