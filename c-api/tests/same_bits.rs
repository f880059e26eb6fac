//! Through the C functions the detector gives the bits of the Rust detector with its plan fixed when compiling.
#![allow(
    clippy::cast_possible_truncation,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by a panic"
)]

#[path = "../../examples/support/classifier.rs"]
mod classifier;
#[path = "../../target-tests/examples/support/law.rs"]
mod law;
#[path = "../../examples/support/numbers.rs"]
mod numbers;
#[allow(dead_code, reason = "only its model and plant are used")]
#[path = "../../examples/support/refined.rs"]
mod refined;
#[allow(dead_code, reason = "only its models and plant are used")]
#[path = "../../target-tests/examples/support/shaft.rs"]
mod shaft;
#[path = "../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
#[allow(dead_code, reason = "other tests use the rest")]
mod support;

use core::mem::MaybeUninit;

use bearing_watch::plan::{Plan, Signals};
use bearing_watch::{Alarm, Cause, Detector, Evidence, FrictionTerm, Model, Report, Verdict};
use bearing_watch_c::{
    BwAlarm, BwCode, BwReason, BwReport, BwState, BwValues, BwVerdict, bw_advance, bw_alarm, bw_report,
};

use support::{Memory, bytes, channels, collect, values};

/// Takes a sample; returns whether there is a new report, in one call for each step.
fn take(state: *mut BwState, channels: &[f32], angle: u32) -> bool {
    match collect(state, channels, angle) {
        BwCode::Ok => return false,
        code => assert_eq!(code, BwCode::Segment),
    }
    let (mut report, mut alarm) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    // SAFETY: the state is initialised, and both places are writable.
    let mut advance = || unsafe { bw_advance(state, report.as_mut_ptr(), alarm.as_mut_ptr()) };
    let mut steps = 0;
    let last = loop {
        steps += 1;
        match advance() {
            BwCode::Ok => {}
            code => break code,
        }
    };
    assert!(last == BwCode::Report && steps > 5, "{last:?} {steps}");
    // What the last step writes is what the functions give.
    let (mut own, mut other) = (MaybeUninit::<BwReport>::uninit(), MaybeUninit::<BwAlarm>::uninit());
    // SAFETY: both were written, and both are if the codes say so.
    unsafe {
        assert_eq!([bw_report(state, own.as_mut_ptr()), bw_alarm(state, other.as_mut_ptr())], [BwCode::Ok; 2]);
        assert_eq!((report.assume_init(), alarm.assume_init()), (own.assume_init(), other.assume_init()));
    }
    true
}

/// The lists of numbers behind a report of the core.
fn expected<P: Plan>(report: &Report<P>) -> Vec<(BwValues, Vec<f32>)> {
    let decision = report.decision.as_ref().expect("a verdict");
    let missing = decision.missing().iter().map(|missing| if *missing { 1.0 } else { 0.0 });
    let mut lists = vec![
        (BwValues::LogLikelihoods, decision.log_likelihoods().to_vec()),
        (BwValues::Posteriors, decision.posteriors().to_vec()),
        (BwValues::ExpectedCosts, decision.expected_costs().to_vec()),
        (BwValues::Missing, missing.collect()),
    ];
    let estimate = report.estimate();
    let delta = estimate.map(|own| own.delta().to_vec()).unwrap_or_default();
    let deviations = estimate.map(|own| (0..delta.len()).map(|k| own.deviation(k)).collect()).unwrap_or_default();
    lists.extend([(BwValues::Parameters, delta), (BwValues::ParameterDeviations, deviations)]);
    let terms = report.shaft().map_or(&[][..], |_| &FrictionTerm::ALL);
    let term = |value: fn(bearing_watch::shaft::Parameter) -> f32| {
        let friction = |term: &FrictionTerm| report.shaft().and_then(|own| own.friction.parameter(*term));
        terms.iter().map(|term| friction(term).map_or(f32::NAN, value)).collect::<Vec<_>>()
    };
    lists.push((BwValues::Friction, term(|own| own.value)));
    lists.push((BwValues::FrictionDeviations, term(|own| own.deviation)));
    lists.push((BwValues::FrictionScores, term(|own| own.score)));
    let orders = report.shaft().map_or(&[][..], |own| own.orders());
    lists.push((BwValues::OrderScores, orders.iter().map(|own| own.score).collect()));
    lists.push((BwValues::OrderAmplitudes, orders.iter().map(|own| own.amplitude).collect()));
    lists.push((BwValues::OrderDeviations, orders.iter().map(|own| own.deviation).collect()));
    lists.push((BwValues::OrderSlips, orders.iter().map(|own| own.slip).collect()));
    lists.push((BwValues::Means, report.averages().iter().map(|own| own.mean().unwrap_or(f32::NAN)).collect()));
    lists
        .push((BwValues::RootMeanSquares, report.averages().iter().map(|own| own.rms().unwrap_or(f32::NAN)).collect()));
    lists
}

fn same<P: Plan>(state: *mut BwState, report: &Report<P>, evidence: &Evidence<P>) {
    let bits = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for (what, list) in expected(report) {
        assert_eq!(bits(&values(state, what)), bits(&list), "{what:?}");
    }
    let mut own = core::mem::MaybeUninit::<BwReport>::uninit();
    // SAFETY: the state is initialised; the report is written if the code says so.
    let own = unsafe {
        assert_eq!(bw_report(state, own.as_mut_ptr()), BwCode::Ok);
        own.assume_init()
    };
    let decision = report.decision.as_ref().expect("a verdict");
    let verdict = match report.verdict {
        Verdict::Class(class) => (BwVerdict::Class, class),
        Verdict::Novel => (BwVerdict::Novel, decision.class),
        Verdict::Ambiguous => (BwVerdict::Ambiguous, decision.class),
        Verdict::Undetermined(reason) => panic!("{reason}"),
    };
    assert_eq!((own.verdict, own.class_index), verdict);
    assert_eq!((own.segment, own.rows), (evidence.segments().0, report.rows));
    let counts = report.counts;
    assert_eq!((own.rejected, own.saturated), (counts.rejected, counts.saturated));
    assert_eq!(bits(&[own.distance, own.surprise]), bits(&[decision.distance, decision.surprise]));

    let mut own = core::mem::MaybeUninit::<BwAlarm>::uninit();
    // SAFETY: likewise.
    let own = unsafe {
        assert_eq!(bw_alarm(state, own.as_mut_ptr()), BwCode::Ok);
        own.assume_init()
    };
    let class = if own.known { Cause::Class(own.class_index) } else { Cause::Unknown };
    let alarm = own.raised.then_some(Alarm { segment: own.segment, cause: class });
    assert_eq!((alarm, own.score.to_bits()), (evidence.alarm(), evidence.score().to_bits()));
}

/// The same samples in C and in Rust; returns the number of reports.
fn compare<P: Plan>(model: &Model<P>, samples: impl Iterator<Item = P::Sample>) -> usize {
    let mut memory = Memory::new();
    let state = memory.state(&bytes(model)).expect("a model that fits");
    let (mut detector, mut evidence, mut reports) = (Detector::new(model), Evidence::new(model), 0);
    for sample in samples {
        let report = detector.step(&sample);
        assert_eq!(take(state, &channels(model, &sample), sample.angle().bits()), report.is_some());
        let Some(report) = report else { continue };
        evidence.observe(report.decision.as_ref());
        same(state, &report, &evidence);
        reports += 1;
    }
    reports
}

#[test]
fn least_squares_on_the_standard_rig() {
    assert_eq!(compare(&standard_rig::model::MODEL, standard_rig::samples()), 3);
}

#[test]
fn instrumental_variables_that_adopt_each_estimate() {
    let mut plant = refined::Plant::new(5);
    assert_eq!(compare(&refined::MODEL, (0..3000).map(|_| plant.sample())), 5);
}

#[test]
fn friction_and_bearing_orders() {
    let mut plant = shaft::Plant::new(3);
    let segment = shaft::MODEL.constants().sampling.segment_samples;
    assert_eq!(compare(&shaft::MODEL, (0..4 * segment).map(|_| plant.motion().into())), 4);
    let segment = shaft::LOADLESS.constants().sampling.segment_samples;
    assert_eq!(compare(&shaft::LOADLESS, (0..3 * segment).map(|_| plant.motion().into())), 3);
    assert_eq!(compare(&shaft::WEIGHING, (0..3 * segment).map(|_| plant.motion().into())), 3);
}

#[test]
fn a_load_of_the_wrong_sign_has_a_reason_and_no_verdict() {
    let bytes = bytes(&shaft::MODEL);
    let mut memory = Memory::new();
    let state = memory.state(&bytes).expect("a model that fits");
    let mut plant = shaft::Plant::new(3);
    let mut reported = false;
    for _ in 0..shaft::MODEL.constants().sampling.segment_samples {
        let motion = plant.motion();
        let sample = shaft::Motion { load_nm: -motion.load_nm, ..motion }.into();
        reported = take(state, &channels(&shaft::MODEL, &sample), sample.angle().bits());
    }
    assert!(reported);
    let mut own = core::mem::MaybeUninit::<BwReport>::uninit();
    // SAFETY: the state is initialised; the report is written if the code says so.
    let own = unsafe {
        assert_eq!(bw_report(state, own.as_mut_ptr()), BwCode::Ok);
        own.assume_init()
    };
    // 1: the sign of the load.
    assert_eq!((own.verdict, own.reason, own.place), (BwVerdict::Undetermined, BwReason::Implausible, 1));
}
