//! Training sets in which a record tells less than others: one of the standard rig's records at constant speed, where
//! only the sum of all friction is known, or at rest, where no ball passes.

use serde_json::Value;

use crate::campaign::experiments::Training;
use crate::campaign::run::{class_names, ours, training_set};
use model::core::Finding;
use model::trace::Channels;
use model::trace::labels::LabelledTrace;
use model::train::{Recipe, Trained, train};
use pages::training::{Worth, training};
use rig::noise::{NoiseSource, Stream};
use rig::{Condition, Defect, DefectKind};

const COUNT: usize = 12;

const TURNING: f64 = 40.0;
/// So slow that a ball passes the spall once or twice in a record.
const CREEPING: f64 = 2.0;
const AT_REST: f64 = 0.0;

/// Healthy and spalled records; the third healthy one runs at this speed throughout.
fn set(velocity: f64) -> (Vec<LabelledTrace>, Vec<String>) {
    let classes = vec![Defect::HEALTHY, Defect::full(DefectKind::Spall)];
    let set = Training { condition: Condition::STANDARD, classes, count: COUNT as u32 };
    let mut traces = training_set(&set, 41).expect("the standard rig");
    let steady = &mut traces[2].trace;
    let motion = steady.motion.as_mut().expect("watched");
    let mut noise = NoiseSource::new(1, Stream::CurrentNoise);
    for k in 0..steady.y.len() {
        (steady.u1[k], motion.velocity_rad_s[k]) = (velocity, velocity);
        motion.angle_rad[k] = velocity * 0.002 * k as f64;
        // The current of load and friction, with the noise of the rig.
        motion.current_a[k] = 0.1 + motion.load_nm[k] / 0.05 + 0.13 * noise.gaussian();
        steady.y[k] = motion.current_a[k];
    }
    (traces, class_names(&set.classes))
}

fn trained(velocity: f64, features: &[&str]) -> Trained {
    let (traces, classes) = set(velocity);
    let features = features.iter().map(ToString::to_string).collect();
    train(&traces, &classes, &Recipe { features, ..ours(0.05) }).expect("a record without features")
}

/// Panics if a number is not finite; JSON has null in its place.
fn finite(value: &Value) {
    match value {
        Value::Null => panic!("a number is not finite"),
        Value::Array(values) => values.iter().for_each(finite),
        Value::Object(values) => values.values().for_each(finite),
        _ => {}
    }
}

#[test]
fn a_record_at_constant_speed_has_friction_with_large_errors() {
    let trained = trained(TURNING, &["viscous", "drag_score", "viscous_log", "order_outer"]);
    assert_eq!((trained.left_out.count, trained.left_out.summary()), (0, None));
    let errors = |row: usize| &trained.raw.variances[row];
    assert!((0..2 * COUNT).all(|row| errors(row).iter().all(|v| v.is_finite())));
    // Only the healthy records tell what is usual: half of all errors are not above it.
    assert!((0..2 * COUNT).filter(|&row| errors(row)[0] <= 0.0).count() >= COUNT);
    let largest = (0..COUNT).filter(|&row| row != 2).map(|row| errors(row)[0]).fold(0.0, f64::max);
    // The sum of viscous and Coulomb friction does not determine either: their errors are those of the prior.
    assert!(errors(2)[0] > 3.0 * largest, "{} {largest}", errors(2)[0]);
    assert!(errors(2)[1] <= 0.0 && errors(2)[3] <= 0.0, "{}", errors(2));
    let model = trained.embed().expect("embeds");
    let (traces, _) = set(TURNING);
    let steady = &model.run(&traces[2].trace)[0];
    assert!(steady.verdict.is_ok() && steady.surprise.is_finite(), "{:?}", steady.verdict);
    assert!(steady.missing.is_empty(), "{:?}", steady.missing);
}

#[test]
fn a_creeping_record_lacks_its_orders_and_what_only_motion_tells() {
    let trained = trained(CREEPING, &["viscous", "drag_score", "order_outer"]);
    assert_eq!((trained.left_out.count, trained.left_out.summary()), (0, None));
    let missing = |row: usize| trained.raw.variances[row].map(|v| !v.is_finite());
    // All of its current is that of drag: the part that grows with velocity does not show.
    assert_eq!(missing(2).as_slice(), [true, false, true]);
    assert!((0..2 * COUNT).all(|row| row == 2 || !missing(row).iter().any(|missing| *missing)));
    let model = trained.embed().expect("embeds");
    let (traces, _) = set(CREEPING);
    let creeping = &model.run(&traces[2].trace)[0];
    assert!(creeping.verdict.is_ok() && creeping.surprise.is_finite(), "{:?}", creeping.verdict);
    assert_eq!(creeping.missing.len(), 2, "{:?}", creeping.missing);
    assert!(model.run(&traces[0].trace)[0].missing.is_empty());
}

#[test]
fn scores_ranking_and_report_bear_missing_values() {
    let trained = trained(CREEPING, &["viscous", "drag_score", "order_outer"]);
    let scores = trained.cross_validated().expect("folds");
    finite(&scores.to_json());
    assert!(scores.error < 0.2, "{scores:?}");
    let ranking = trained.rank().expect("ranks");
    finite(&ranking.to_json()["features"]);
    assert!(!format!("{ranking}").contains("NaN"), "{ranking}");
    let (traces, _) = set(CREEPING);
    let examples = [(&traces[0].trace, 0), (&traces[2].trace, 0)];
    let worth = Worth { ranking: Some(&ranking), cross_validated: Some(Ok(&scores)), ..Worth::default() };
    let page = training(&trained, &Channels::new("y", "u1", "u2"), &examples, worth).expect("a page");
    // The library of the figures has words of its own.
    let text: String =
        page.split("<script").map(|part| part.split_once("</script>").map_or(part, |(_, rest)| rest)).collect();
    assert!(text.contains("1 of the training segments lack a coordinate") && !text.contains("NaN"), "{text}");
}

#[test]
fn a_record_without_any_feature_is_left_out() {
    let trained = trained(AT_REST, &["order_outer", "amplitude_outer"]);
    let told = trained.left_out.summary().expect("one is left out");
    assert!(told.starts_with(&format!("1 of {} traces have none of the features: left out", 2 * COUNT)), "{told}");
    assert_eq!((trained.raw.rows.len(), trained.candidates.groups.len()), (2 * COUNT - 1, 2 * COUNT - 1));
    let (traces, classes) = set(AT_REST);
    let few: Vec<_> = [0, 2, COUNT, COUNT + 1].map(|k| traces[k].clone()).into();
    let recipe = Recipe { features: vec!["order_outer".into()], ..ours(0.05) };
    let error = train(&few, &classes, &recipe).expect_err("one healthy record is left").to_string();
    assert!(error.contains(&traces[2].trace.id) && error.contains("leave the trace out"), "{error}");
}

#[test]
fn records_with_lost_samples_train() {
    let (mut traces, classes) = set(TURNING);
    for (k, labelled) in traces.iter_mut().enumerate() {
        let trace = &mut labelled.trace;
        let motion = trace.motion.as_mut().expect("watched");
        for lost in (k..trace.y.len()).step_by(100) {
            (trace.y[lost], trace.u1[lost], trace.u2[lost]) = (f64::NAN, f64::NAN, f64::NAN);
            (motion.current_a[lost], motion.velocity_rad_s[lost], motion.load_nm[lost]) =
                (f64::NAN, f64::NAN, f64::NAN);
        }
    }
    let trained = train(&traces, &classes, &ours(0.05)).expect("one sample in a hundred is missing");
    assert_eq!(trained.left_out.count, 0, "{:?}", trained.left_out.summary());
    let model = trained.embed().expect("embeds");
    let judged = |class: usize| traces.iter().filter(move |own| own.class == class).map(|own| model.run(&own.trace));
    let right = |class: usize| judged(class).filter(|reports| reports[0].verdict == Ok(Finding::Class(class))).count();
    // All records of training but the one at constant speed.
    assert!(right(0) >= COUNT - 1 && right(1) == COUNT, "{} {}", right(0), right(1));
}
