//! What is missing in a segment: which coordinates are left, and the reason if there are none.

use std::vec;

use super::*;
use crate::decide::{Covariate, Covariates, Discriminant, Feature, Novelty, Projection, Verdict};
use crate::plan::{Layout, Memory, Method, RunTime, Structure, testing};
use crate::regression::estimate::Estimate;

fn plan() -> RunTime {
    let plain = testing::regression(Structure::new(1, 1, 0, 1, 0), Method::LeastSquares, Memory::Segment);
    RunTime::of(Layout { features: 2, coordinates: 2, classes: 2, covariates: 1, averaged: 2, ..plain }).unwrap()
}

/// A parameter, which 3 times the other one explains while that is within 0 … 10, and the mean of a channel, as
/// coordinates; classes at (0, 0) and (8, 8) with unit covariance.
fn classifier() -> Classifier<RunTime> {
    let covariate = Covariate { feature: Feature::Parameter(1), centre: 5.0, low: 0.0, high: 10.0, usual: 0.0 };
    Classifier {
        features: vec![Feature::Parameter(0), Feature::ChannelMean(1)],
        covariates: Covariates { list: vec![covariate], map: vec![[3.0, 0.0], [0.0; 2]] },
        projection: Projection { matrix: vec![1.0, 0.0, 0.0, 1.0], mean: vec![0.0; 2], usual: vec![0.0; 2] },
        discriminant: Discriminant {
            means: vec![0.0, 0.0, 8.0, 8.0],
            factors: vec![1.0, 0.0, 1.0],
            log_prior: vec![0.5_f32.ln(); 2],
            costs: vec![0.0, 1.0, 1.0, 0.0],
            reject_cost: f32::INFINITY,
        },
        novelty: Novelty::none(plan()),
    }
}

/// The decision on a segment with these parameters, or with this reason instead, whose averages are lost.
fn decide(parameters: Result<[f32; 2], Reason>) -> Result<Decision<RunTime>, Reason> {
    let mut estimate = Estimate::empty(plan());
    estimate.reason = parameters.err();
    estimate.delta = parameters.unwrap_or_default().to_vec();
    let mut decision = Decision::empty(plan());
    let estimates: Estimates<'_, RunTime> = (Some(&estimate), None, &[]);
    let mut classification = Classification::new(plan());
    loop {
        if let Some(result) = classification.step(plan(), &classifier(), estimates, &mut decision) {
            return result.map(|()| decision);
        }
    }
}

#[test]
fn what_is_left_decides() {
    // 14 less 3 times the 2 beyond the centre; the mean of the channel is missing.
    let decision = decide(Ok([14.0, 7.0])).unwrap();
    assert_eq!((decision.class, decision.missing(), decision.outside()), (1, &[false, true][..], &[false][..]));
    // ln of the ratio of the densities is 8²/2 at 8 and 0 in the middle.
    let ratio = |parameters| {
        let decision = decide(Ok(parameters)).unwrap();
        decision.log_likelihoods()[1] - decision.log_likelihoods()[0]
    };
    assert!((ratio([14.0, 7.0]) - 32.0).abs() < 1e-4 && ratio([10.0, 7.0]).abs() < 1e-4);
}

#[test]
fn a_segment_without_any_coordinate_has_the_first_reason() {
    let none = |parameters| decide(parameters).unwrap_err();
    // The mean of the channel is lost, too.
    assert_eq!(none(Err(Reason::AtRest)), Reason::AtRest);
    for far in [-1.1, 11.1, f32::NAN] {
        assert_eq!(none(Ok([14.0, far])), Reason::OutOfRange { covariate: 0 }, "{far}");
    }
}

/// The surprise of a squared distance k² of both coordinates is k, and the gate is at 2; that of a defect is at three
/// times the distance. One coordinate is as improbable as that from 9 · 2.2097 on.
#[test]
fn a_segment_is_far_from_a_class_by_the_coordinates_that_are_left() {
    let mut classifier = classifier();
    let mut novelty = Novelty { class: Some(0), factor: vec![1.0, 0.0, 1.0], limit: 2.0, ..Novelty::none(plan()) };
    for (k, knot) in (0_u8..).zip(&mut novelty.knots) {
        *knot = [f32::from(k) * f32::from(k), f32::from(k)];
    }
    classifier.novelty = novelty;
    let beyond =
        |z: [f32; 2], variances: [f32; 2]| classifier.decide_at(plan(), &z, &variances).unwrap().beyond().to_vec();
    for (departure, both, left) in [(4.3, false, false), (4.6, false, true), (5.9, false, true), (6.1, true, true)] {
        assert_eq!(beyond([8.0 + departure, 8.0], [0.0; 2]), [false, both], "{departure}");
        assert_eq!(beyond([8.0 + departure, 0.0], [0.0, f32::INFINITY]), [false, left], "{departure}");
    }
}

/// With rising coordinates one of them may be rare at a usual distance, and a distance rare where none of them is.
#[test]
fn the_gate_of_the_healthy_class_compares_the_rarest_value_and_not_the_distance() {
    let novelty = Novelty { class: Some(0), limit: 2.0, ..Novelty::none(plan()) };
    let classifier = Classifier { novelty, ..classifier() };
    let of = |surprise: f32, distance_surprise: f32| {
        let decision = classifier.decide(plan(), &[0.0, -9.0], 0.0).unwrap();
        classifier.verdict(&Decision { surprise, distance_surprise, ..decision })
    };
    assert_eq!([of(2.0, 0.5), of(1.9, 30.0)], [Verdict::Novel, Verdict::Class(0)]);
}
