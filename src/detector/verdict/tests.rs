//! Healthy is earned: by what the segment would have shown.

use std::vec;
use std::vec::Vec;

use super::*;
use crate::detector::Detector;
use crate::model::{
    Blocks, Channel, Classifier, Constants, Covariates, Discriminant, EvidenceConstants, Feature, Label, Lags, Novelty,
    Projection, Sampling, ShaftConstants, TrackedOrder, Tracking,
};
use crate::plan::{Kind, Layout, Load, RunTime, RunTimeSample, ShaftLayout, Signal};
use crate::shaft::state::tests::balance;
use crate::shaft::{OrderStrength, ShaftEstimate};

/// Healthy at 0 and a defect at 9, in one feature; amplitudes up to 0.5 A are acceptable.
fn model(feature: Feature) -> Model<RunTime> {
    model_of(&[feature])
}

/// The same in some features.
fn model_of(features: &[Feature]) -> Model<RunTime> {
    let count = features.len();
    let unit = |rows: usize, row_from: fn(usize) -> usize| -> Vec<f32> {
        (0..rows).flat_map(|k| (row_from(k)..rows).map(move |j| f32::from(u8::from(j == k)))).collect()
    };
    let [matrix, diagonal] = [unit(count, |_| 0), unit(count, |k| k)];
    let [current, velocity, load] = [0, 1, 2].map(Signal::channel);
    let orders = features.iter().filter(|feature| feature.order().is_some()).count() as u8;
    let (velocity, load) = (Some(velocity), Load::Measured(load));
    let shaft = ShaftLayout { current, velocity, load, orders, harmonics: 3, decimation: 1 };
    let layout = Layout {
        channels: 3,
        shaft: Some(shaft),
        features: count as u8,
        coordinates: count as u8,
        classes: 2,
        ..Layout::EMPTY
    };
    let plan = RunTime::of(Layout { discriminant: Kind::Linear, ..layout }).unwrap();
    let blocks = Blocks {
        controls: [100_000, 200_000, 300_000, 400_000],
        cell_turns_log2: 0,
        slip: 0.02,
        slowest_rad_s: 2.0,
        pole: 0.5,
        high_pass: 0.02,
    };
    let order = TrackedOrder { most_a: 0.5, ..TrackedOrder::new(3.7, [1.0; 3]) };
    let tracking = Tracking { orders: vec![order; usize::from(orders)], blocks };
    let knots = core::array::from_fn(|k| [2.0 * k as f32, k as f32]);
    let constants = Constants {
        sampling: Sampling { interval_s: 0.001, park: None, block_mean: 1, segment_samples: 200 },
        channels: ["current", "velocity", "load"].map(|name| Channel::within(name, "A", 100.0)).to_vec(),
        regression: vec![],
        shaft: vec![ShaftConstants { lags: Lags::default(), balance: balance(), tracking }],
        classifier: Classifier {
            features: features.to_vec(),
            covariates: Covariates { list: vec![], map: vec![] },
            projection: Projection { matrix, mean: vec![0.0; count], usual: vec![0.0; count] },
            discriminant: Discriminant {
                means: [vec![0.0; count], vec![9.0; count]].concat(),
                factors: diagonal.clone(),
                log_prior: vec![-0.693; 2],
                costs: vec![0.0, 1.0, 1.0, 0.0],
                reject_cost: f32::INFINITY,
            },
            novelty: Novelty {
                class: Some(0),
                mean: vec![0.0; count],
                factor: diagonal,
                knots,
                limit: 4.5,
                ..Novelty::none(plan)
            },
        },
        evidence: EvidenceConstants::NONE,
        labels: ["healthy", "spall"].map(Label::constant).to_vec(),
    };
    Model::new(plan, constants).unwrap()
}

/// The verdict on a segment with this value of the feature, whose orders and friction have seen so much.
fn verdict(model: &Model<RunTime>, value: f32, order: OrderStrength, friction: bool) -> Verdict {
    let plan = model.plan();
    let mut estimate = ShaftEstimate::empty(plan);
    (estimate.friction_reason, estimate.orders_reason) = (None, None);
    estimate.orders = estimate.orders.iter().map(|_| order).collect::<Vec<_>>();
    let mut report = Report::empty(plan);
    report.shaft = vec![estimate];
    report.decision = model.constants().classifier.decide_at(plan, &[value], &[0.0]);
    judge(model, &Segment::new(model), &mut report, (Ok(()), friction));
    assert_eq!(report.decision.is_none(), matches!(report.verdict, Verdict::Undetermined(_)));
    report.verdict
}

fn seen(smallest: f32, unseen: bool) -> OrderStrength {
    OrderStrength { smallest, unseen, ..OrderStrength::default() }
}

#[test]
fn with_orders_a_segment_is_healthy_only_if_one_would_have_shown_an_acceptable_defect() {
    let model = model(Feature::OrderScore(0));
    let healthy = |order| verdict(&model, 0.0, order, false);
    let unseen = |obstacle| Verdict::Undetermined(Reason::Unseen(obstacle));
    assert_eq!([healthy(seen(0.1, false)), healthy(seen(0.5, false))], [Verdict::Class(0); 2]);
    assert_eq!(healthy(seen(0.51, false)), unseen(Obstacle::TooNoisy));
    assert_eq!(healthy(seen(f32::NAN, false)), unseen(Obstacle::TooNoisy));
    assert_eq!(healthy(seen(f32::INFINITY, true)), unseen(Obstacle::TooLittleMotion));
}

#[test]
fn what_departs_from_healthy_is_told_whatever_the_segment_could_have_shown() {
    let model = model(Feature::OrderScore(0));
    let blind = seen(f32::INFINITY, true);
    assert_eq!(verdict(&model, 9.0, blind, false), Verdict::Class(1));
    assert_eq!([4.0, -9.0].map(|value| verdict(&model, value, blind, false)), [Verdict::Novel; 2]);
}

#[test]
fn without_orders_the_friction_decides() {
    let term = FrictionTerm::Drag;
    let model = model(Feature::FrictionScore(term));
    let of = |value, friction| verdict(&model, value, OrderStrength::default(), friction);
    assert_eq!([of(0.0, true), of(9.0, false)], [Verdict::Class(0), Verdict::Class(1)]);
    assert_eq!(of(0.0, false), Verdict::Undetermined(Reason::TermNotExcited(term)));
}

#[test]
fn without_a_regression_the_rows_of_a_segment_are_its_own_usable_samples() {
    let model = model(Feature::Friction(FrictionTerm::Drag));
    let mut detector = Detector::new(&model);
    let rows: Vec<u32> = (0..600_u16)
        .filter_map(|k| {
            // Every fourth sample of the second segment is refused.
            let current = if (200..400).contains(&k) && k % 4 == 0 { f32::NAN } else { 1.0 };
            let sample = RunTimeSample { values: vec![current, 2.0, 0.0], ..RunTimeSample::default() };
            detector.step(&sample).map(|report| report.rows)
        })
        .collect();
    assert_eq!(rows, [200, 150, 200]);
}

#[test]
fn a_race_is_named_before_friction_if_its_order_is_strong_enough() {
    use crate::reason::FrictionTerm::Drag;
    let model = model_of(&[Feature::Friction(Drag), Feature::OrderScore(0), Feature::OrderScore(1)]);
    let named = |scores: [f32; 2], unseen: bool| {
        let plan = model.plan();
        let mut estimate = ShaftEstimate::empty(plan);
        (estimate.friction_reason, estimate.orders_reason) = (None, None);
        estimate.orders = scores.map(|score| OrderStrength { score, unseen, ..OrderStrength::default() }).to_vec();
        let mut report = Report::empty(plan);
        report.shaft = vec![estimate];
        let values = [[90.0], [scores[0]], [scores[1]]].concat();
        report.decision = model.constants().classifier.decide_at(plan, &values, &[0.0; 3]);
        judge(&model, &Segment::new(&model), &mut report, (Ok(()), true));
        assert_eq!(report.verdict, Verdict::Novel);
        report.decision.and_then(|decision| decision.most)
    };
    let coordinate = |coordinate| Some(Most { coordinate, falls: false });
    // The orders need a score of 4.
    assert_eq!(named([3.9, 2.0], false), coordinate(0));
    assert_eq!([named([4.1, 2.0], false), named([4.1, 5.0], false)], [coordinate(1), coordinate(2)]);
    assert_eq!(named([9.0, 9.0], true), coordinate(0), "the shaft has turned too little");
}
