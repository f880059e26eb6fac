//! Features of training traces as the core itself estimates them.
//!
//! The classifier is not trained yet, so the detector runs with a classifier of a single class: every estimate is
//! assigned to it. Each trace runs as a whole, so that a segment starts from the state that its predecessor left, as it
//! will in the drive.

use bearing_watch::model::Sampling;
use nalgebra::DVector;
use rayon::prelude::*;

use super::FeatureTable;
use super::core_form::{refused, samples};
use crate::Error;
use crate::core::{Embedded, Parts, SegmentReport, features};
use crate::identify::Structure;
use crate::trace::labels::LabelledTrace;

const REMEDY: &str = "; choose other channels or a lower order, or leave the trace out";

/// Returns one row per segment, and the trace of each row.
pub(super) fn run(
    traces: &[LabelledTrace],
    classes: &[String],
    (parts, structure): (&Parts, Structure),
    segment: usize,
) -> Result<(FeatureTable, Vec<usize>), Error> {
    let sampling = Sampling { interval_s: 0.0, park: None, block_mean: 1, segment_samples: samples(segment)? };
    let model = parts.estimating(sampling).map_err(refused)?;
    let estimator = Embedded::new(model).map_err(refused)?;
    let each = |labelled: &LabelledTrace| -> Result<Vec<DVector<f64>>, Error> {
        let segments = estimator.run(&labelled.trace);
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
    // Collects all results first, so that every run reports the error of the first bad trace.
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
