//! Features of training traces as the core itself estimates them.
//!
//! The classifier is still to be trained, so the detector runs with one of a single class: whatever it estimates is
//! that class. Traces run whole, so that a segment starts from what its predecessor left, as it will in the drive.

use bearing_watch::decide::{
    Classifier, Discriminant, EvidencePlan, Features, Kind, Novelty, Projection, SHAFT_FEATURES,
};
use bearing_watch::{Label, Model, Regression, Sampling, ShaftModel};
use nalgebra::DVector;
use rayon::prelude::*;

use super::FeatureTable;
use super::core_form::{bytes, refused, samples};
use crate::Error;
use crate::core::features;
use crate::core::{Embedded, MAX_COLUMNS, MAX_ORDERS, SegmentReport};
use crate::trace::labels::LabelledTrace;

const REMEDY: &str = "; choose other channels or a lower order, or leave the trace out";

/// A row a segment, and the trace of each.
pub(super) fn run(
    traces: &[LabelledTrace],
    classes: &[String],
    (regression, shaft): (&Regression<MAX_COLUMNS>, Option<&ShaftModel<MAX_ORDERS>>),
    segment: usize,
) -> Result<(FeatureTable, Vec<usize>), Error> {
    let estimator = estimator(regression, shaft, segment)?;
    let structure = estimator.structure();
    let each = |labelled: &LabelledTrace| -> Result<Vec<DVector<f64>>, Error> {
        let segments = estimator.run(&labelled.trace).map_err(refused)?;
        let row = |segment: &SegmentReport| match &segment.verdict {
            Ok(_) => {
                let own = features::of_core(structure, &segment.delta, segment.variance);
                let all = own.iter().copied().chain(segment.shaft_features.iter().map(|x| f64::from(*x)));
                Ok(DVector::from_vec(all.collect()))
            }
            Err(reason) => {
                let (from, to) = (segment.start, segment.start + segment.length);
                Err(Error::trace(&labelled.trace.id, format!("samples {from} to {to}: {reason}{REMEDY}")))
            }
        };
        segments.iter().map(row).collect()
    };
    // Collected first, so that the error reported is that of the first bad trace in every run.
    let rows: Vec<_> = traces.par_iter().map(each).collect();
    let mut table = FeatureTable { rows: vec![], classes: vec![], names: classes.to_vec() };
    let mut origins = vec![];
    for (trace, (labelled, rows)) in traces.iter().zip(rows).enumerate() {
        let rows = rows?;
        origins.extend(rows.iter().map(|_| trace));
        table.classes.extend(rows.iter().map(|_| labelled.class));
        table.rows.extend(rows);
    }
    Ok((table, origins))
}

/// A detector that estimates and does not decide.
fn estimator(
    regression: &Regression<MAX_COLUMNS>,
    shaft: Option<&ShaftModel<MAX_ORDERS>>,
    segment: usize,
) -> Result<Embedded, Error> {
    let model = Box::new(Model {
        sampling: Sampling { interval_s: 0.0, block_mean: 1, segment_samples: samples(segment)? },
        regression: *regression,
        shaft: shaft.copied(),
        classifier: Classifier {
            // A feature of the shaft, so that one that says nothing is told.
            features: Features { index: [if shaft.is_some() { SHAFT_FEATURES } else { 0 }], count: 1 },
            projection: Projection { matrix: [[0.0]], mean: [0.0], count: 1 },
            discriminant: Discriminant {
                kind: Kind::Linear,
                classes: 1,
                mean: [[0.0]],
                whitening: [[[1.0]]],
                log_normaliser: [0.0],
                log_prior: [0.0],
                cost: [[0.0]],
                reject_cost: f32::INFINITY,
            },
            novelty: Novelty::NONE,
        },
        evidence: EvidencePlan::NONE,
        labels: [Label::EMPTY],
    });
    model.validate().map_err(refused)?;
    Embedded::from_bytes(&bytes(&model, "")?).map_err(refused)
}
