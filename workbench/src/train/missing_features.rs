//! Training sets in which a record lacks features: one of the standard rig's records at constant speed, whose torque
//! balance is not excited.

use serde_json::Value;

use super::{Recipe, Trained, train};
use crate::report::pages::model::{Worth, training};
use crate::rig::{Condition, Defect, DefectKind};
use crate::study::campaign::experiments::Training;
use crate::study::campaign::run::{class_names, ours, training_set};
use crate::trace::Channels;
use crate::trace::labels::LabelledTrace;

const COUNT: usize = 12;

/// Healthy and spalled records; the third healthy one runs at constant speed.
fn set() -> (Vec<LabelledTrace>, Vec<String>) {
    let classes = vec![Defect::HEALTHY, Defect::full(DefectKind::Spall)];
    let set = Training { condition: Condition::STANDARD, classes, count: COUNT as u32 };
    let mut traces = training_set(&set, 41).expect("the standard rig");
    let steady = &mut traces[2].trace;
    let motion = steady.motion.as_mut().expect("watched");
    for k in 0..steady.y.len() {
        let velocity = 40.0;
        (steady.u1[k], motion.reference_rad_s[k], motion.velocity_rad_s[k]) = (velocity, velocity, velocity);
        motion.angle_rad[k] = velocity * 0.002 * k as f64;
        // The current of friction alone, with the noise of the record.
        motion.current_a[k] = 0.1 + 0.01 * motion.current_a[k];
        steady.y[k] = motion.current_a[k];
    }
    (traces, class_names(&set.classes))
}

fn trained(features: &[&str]) -> Trained {
    let (traces, classes) = set();
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
fn a_record_at_constant_speed_lacks_its_friction_only() {
    let trained = trained(&["viscous", "drag_score", "viscous_log", "order_outer"]);
    assert_eq!((trained.left_out.count, trained.left_out.summary()), (0, None));
    let missing = |row: usize| trained.raw.variances[row].map(|v| !v.is_finite());
    assert_eq!(missing(2).as_slice(), [true, true, true, false]);
    assert!((0..2 * COUNT).all(|row| row == 2 || !missing(row).iter().any(|missing| *missing)));
    let errors = &trained.raw.variances[0];
    assert!(errors[0] > 0.0 && errors[1] <= 0.0 && errors[2] > 0.0 && errors[3] <= 0.0, "{errors}");
    let model = trained.embed().expect("embeds");
    let (traces, _) = set();
    let steady = &model.run(&traces[2].trace)[0];
    assert!(steady.verdict.is_ok() && steady.surprise.is_finite(), "{:?}", steady.verdict);
    assert_eq!(steady.missing.len(), 3, "{:?}", steady.missing);
    assert!(model.run(&traces[0].trace)[0].missing.is_empty());
}

#[test]
fn scores_ranking_and_report_bear_missing_values() {
    let trained = trained(&["viscous", "drag_score", "order_outer"]);
    let scores = trained.cross_validated().expect("folds");
    finite(&scores.to_json());
    assert!(scores.error < 0.2, "{scores:?}");
    let ranking = trained.rank().expect("ranks");
    finite(&ranking.to_json()["features"]);
    assert!(!format!("{ranking}").contains("NaN"), "{ranking}");
    let (traces, _) = set();
    let examples = [(&traces[0].trace, 0), (&traces[2].trace, 0)];
    let worth = Worth { ranking: Some(&ranking), cross_validated: Some(Ok(&scores)), ..Worth::default() };
    let page = training(&trained, &Channels::new("y", "u1", "u2"), &examples, worth).expect("a page");
    assert!(page.contains("1 of the training segments lack a coordinate") && !page.contains("NaN"));
}

#[test]
fn a_record_without_any_feature_is_left_out() {
    let trained = trained(&["viscous", "drag_score"]);
    let told = trained.left_out.summary().expect("one is left out");
    assert!(told.starts_with(&format!("1 of {} traces have none of the features: left out", 2 * COUNT)), "{told}");
    assert_eq!((trained.raw.rows.len(), trained.candidates.groups.len()), (2 * COUNT - 1, 2 * COUNT - 1));
    let (traces, classes) = set();
    let few: Vec<_> = [0, 2, COUNT, COUNT + 1].map(|k| traces[k].clone()).into();
    let recipe = Recipe { features: vec!["viscous".into()], ..ours(0.05) };
    let error = train(&few, &classes, &recipe).expect_err("one healthy record is left").to_string();
    assert!(error.contains(&traces[2].trace.id) && error.contains("leave the trace out"), "{error}");
}
