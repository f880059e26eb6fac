//! Features of training traces as the core itself estimates them.
//!
//! The classifier is not trained yet, so the detector runs with a classifier of a single class. Each trace runs as a
//! whole, so that a segment starts from the state that its predecessor left, as it will in the drive. The features of a
//! part without a result are missing, and so are all features of a segment without a verdict.

use bearing_watch::model::{FeatureValue, Sampling};
use bearing_watch::{Average, Reason};
use nalgebra::DVector;
use rayon::prelude::*;

use crate::Error;
use crate::core::features::{self, Catalogue};
use crate::core::{Embedded, Parts, SegmentReport};
use crate::error::refused;
use crate::trace::labels::LabelledTrace;
use crate::train::FeatureTable;
use crate::train::model::core_form::samples;

/// The rows of all segments, with the trace of each row, and why it has no features.
pub(crate) type Rows = (FeatureTable, Vec<usize>, Vec<Option<String>>);

/// Returns the core that estimates and decides nothing, for segments of this length.
pub(crate) fn estimator(parts: &Parts, segment: usize) -> Result<Embedded, Error> {
    let sampling = Sampling { interval_s: 0.0, park: None, block_mean: 1, segment_samples: samples(segment)? };
    Embedded::new(parts.estimating(sampling).map_err(refused)?).map_err(refused)
}

/// Returns one row per segment, with errors beyond the usual ones.
pub(crate) fn run(
    traces: &[LabelledTrace],
    classes: &[String],
    (parts, catalogue): (&Parts, &Catalogue),
    segment: usize,
) -> Result<Rows, Error> {
    let (table, origins, reasons) = run_plain(traces, classes, (parts, catalogue), segment)?;
    Ok((table.with_usual_errors(), origins, reasons))
}

/// Returns one row per segment, with errors as they are.
pub(crate) fn run_plain(
    traces: &[LabelledTrace],
    classes: &[String],
    (parts, catalogue): (&Parts, &Catalogue),
    segment: usize,
) -> Result<Rows, Error> {
    let estimator = estimator(parts, segment)?;
    let of_trace: Vec<Vec<SegmentReport>> = traces.par_iter().map(|own| estimator.run(&own.trace)).collect();
    let mut table = FeatureTable::exact(vec![], vec![], classes.to_vec());
    let (mut origins, mut reasons) = (vec![], vec![]);
    for (trace, segments) in of_trace.iter().enumerate() {
        for segment in segments {
            let (value, variance) = row(segment, catalogue);
            table.rows.push(value);
            table.variances.push(variance);
            table.classes.push(traces[trace].class);
            origins.push(trace);
            let (from, to) = (segment.start, segment.start + segment.length);
            reasons.push(segment.verdict.as_ref().err().map(|reason| format!("samples {from} to {to}: {reason}")));
        }
    }
    table.usual = DVector::zeros(table.rows.first().map_or(0, DVector::len));
    Ok((table, origins, reasons))
}

/// Returns the features of a segment, in the order of [`Catalogue::names`], and the variances of their errors; a
/// missing one has the variance ∞.
#[must_use]
pub fn row(segment: &SegmentReport, catalogue: &Catalogue) -> (DVector<f64>, DVector<f64>) {
    let structure = catalogue.structure;
    let own = features::of_core(structure, &segment.delta, segment.variance);
    let (shaft, determined) = (catalogue.shaft().len(), segment.verdict.is_ok());
    let of_shaft = (0..shaft).map(|k| segment.shaft_features.get(k).copied().unwrap_or(FeatureValue::MISSING));
    let regression = if segment.estimated { 0.0 } else { f64::INFINITY };
    let of_regression = own.iter().map(|value| (*value, regression));
    let averages = |of: fn(&Average) -> Result<f32, Reason>| {
        let own = move |place: u8| segment.averages.iter().find(|own| own.channel() == place);
        let value = move |place: u8| own(place).and_then(|own| of(own).ok());
        let each = move |(_, place): &(String, u8)| {
            value(*place).map_or(FeatureValue::MISSING, |value| FeatureValue { value, variance: 0.0 })
        };
        catalogue.averaged.iter().map(each)
    };
    let further = of_shaft.chain(averages(Average::mean)).chain(averages(Average::rms));
    let all = of_regression.chain(further.map(|feature| (f64::from(feature.value), f64::from(feature.variance))));
    // A value that is not a number has no verdict in the drive; here it is missing.
    let there = |value: f64, variance: f64| determined && value.is_finite() && variance.is_finite();
    let (values, variances): (Vec<f64>, Vec<f64>) = all
        .map(|(value, variance)| if there(value, variance) { (value, variance) } else { (0.0, f64::INFINITY) })
        .unzip();
    (DVector::from_vec(values), DVector::from_vec(variances))
}
