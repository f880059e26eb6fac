//! What segments show of each bearing order: the score that a defect needs, and the sizes with which a segment may
//! still be called healthy.
//!
//! ```text
//! n = m + r √D                                                             (1)  the needed score of an order
//! most = max(k · median, 98 % quantile)   of the smallest defects of the healthy training segments       (2)
//! ```
//!
//! m and D are mean and variance of the order's score given the coordinates before it, r the reach of the gate, k the
//! acceptable multiple ([`crate::train::Alarms::acceptable`]). (2) holds for the amplitude, which grows with the noise,
//! and for the amplitude over the deviation of the noise, which the motion alone determines. By the quantile a set
//! whose motions differ much leaves no more than one in fifty of its own segments without a verdict.

use bearing_watch::model::Feature;
use bearing_watch::shaft::OrderStrength;
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::Error;
use crate::trace::labels::LabelledTrace;
use crate::train::estimates::Estimates;
use crate::train::rows::core_features;
use crate::train::{OrderSight, Sight, Trained};

/// Healthy traces by which the sizes are known.
const MOST_TRACES: usize = 200;
/// The quantile of (2).
const QUANTILE: f64 = 0.98;

impl Trained {
    /// Returns (1) of each order whose score the gate judges, without limits of their sizes.
    #[must_use]
    pub fn needed_scores(&self) -> Vec<OrderSight> {
        let Some((gate, rising)) = self.watch.gate.as_ref().and_then(|gate| Some((gate, gate.rising.as_ref()?))) else {
            return vec![];
        };
        let (rises, all) = (rising.rises(gate.limit), gate.mean.len());
        let Some(factor) = gate.covariance.clone().cholesky().map(|factor| factor.l()) else { return vec![] };
        let first = all - rising.laws.len();
        let of = |(place, feature): (usize, &Feature)| {
            let Feature::OrderScore(order) = feature else { return None };
            let weights: &DMatrix<f64> = &self.core_projection.matrix;
            let coordinate = (first..all).find(|&k| weights[(k, place)] != 0.0)?;
            let weight = weights[(coordinate, place)];
            // The deviation given the coordinates before it is the pivot of the factor.
            let shift = f64::from(rises[coordinate - first + 1].reach) * factor[(coordinate, coordinate)];
            let needed_score = self.core_projection.mean[place] + (gate.mean[coordinate] + shift) / weight;
            let (most_relative, most_a) = (f64::INFINITY, f64::INFINITY);
            Some(OrderSight { order: usize::from(*order), needed_score, usual_a: None, most_relative, most_a })
        };
        self.core_features.iter().enumerate().filter_map(of).collect()
    }
}

impl Estimates<'_> {
    /// Returns the constants of the orders of a model, by its healthy training segments.
    ///
    /// # Errors
    /// The core refuses the model.
    pub(crate) fn sight(&self, trained: &Trained) -> Result<Sight, Error> {
        let mut sight = Sight { orders: trained.needed_scores() };
        let Some(healthy) = trained.watch.gate.as_ref().map(|gate| gate.class) else { return Ok(sight) };
        if sight.orders.is_empty() {
            return Ok(sight);
        }
        let estimator = core_features::estimator(&sight.parts(&self.parts), self.segment)?;
        let healthy_traces: Vec<&LabelledTrace> = self.traces.iter().filter(|own| own.class == healthy).collect();
        let some: Vec<_> = healthy_traces.iter().step_by(healthy_traces.len().div_ceil(MOST_TRACES).max(1)).collect();
        let segments: Vec<_> = some.par_iter().flat_map(|own| estimator.run(&own.trace)).collect();
        let acceptable = trained.recipe.alarms.acceptable;
        for own in &mut sight.orders {
            let of = |pick: fn(&OrderStrength) -> f32| {
                let all = segments.iter().filter_map(|segment| segment.orders.get(own.order));
                most(all.map(pick).filter(|size| size.is_finite() && *size > 0.0).map(f64::from).collect(), acceptable)
            };
            if let (Some((_, relative)), Some((usual, most))) = (of(|o| o.smallest_relative), of(|o| o.smallest)) {
                (own.most_relative, own.most_a, own.usual_a) = (relative, most, Some(usual));
            }
        }
        Ok(sight)
    }
}

/// Returns the median, and (2).
fn most(mut sizes: Vec<f64>, acceptable: f64) -> Option<(f64, f64)> {
    sizes.sort_unstable_by(f64::total_cmp);
    let at = |part: f64| sizes.get((part * sizes.len().saturating_sub(1) as f64).ceil() as usize).copied();
    let median = at(0.5)?;
    Some((median, (acceptable * median).max(at(QUANTILE)?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_is_a_multiple_of_the_usual_size_or_that_of_one_in_fifty() {
        let alike: Vec<f64> = (0..101).map(|k| 1.0 + f64::from(k) * 1e-3).collect();
        let (median, most_of) = most(alike.clone(), 2.0).expect("sizes");
        assert!((median - 1.05).abs() < 1e-12 && (most_of - 2.1).abs() < 1e-12);
        let unlike: Vec<f64> = alike.iter().map(|x| (40.0 * (x - 1.0)).exp()).collect();
        let (_, most_of) = most(unlike, 2.0).expect("sizes");
        // The 98th of a hundred.
        assert!((most_of.ln() - 40.0 * 0.098).abs() < 1e-9, "{most_of}");
        assert_eq!(most(vec![], 2.0), None);
    }
}
