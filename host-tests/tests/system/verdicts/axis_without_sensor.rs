//! An axis that moves a weight, without a load sensor: what the default recipe finds, and that another payload is no
//! defect.

use std::sync::LazyLock;

use model::core::{Embedded, Finding, SegmentReport};
use rig::{Condition, Defect, DefectKind, Scenario};
use studies::campaign::run::labelled;
use studies::campaign::{Cell, Purpose, Recording, map_traces};
use studies::recipes::{default_recipe, default_settings};

/// A number far from those of the documents, so that these are other records.
const REPETITION: u32 = 720;

fn records(condition: &str, purpose: Purpose, defect: Defect, count: u32) -> Vec<Recording> {
    let condition = Condition::named(condition).expect("a known condition");
    let cell = Cell { purpose, repetition: REPETITION, condition, defect };
    map_traces(&Scenario::WITH_RESOLVER, &[cell], count, Ok).expect("the rig")
}

static TRAINED: LazyLock<Embedded> = LazyLock::new(|| {
    let set = records("axis-0.15", Purpose::Training, Defect::HEALTHY, 100);
    let set: Vec<_> = set.into_iter().map(|own| labelled(own, 0)).collect();
    let recipe = default_recipe(&default_settings(false, 0.01), &["healthy".into()]).expect("a recipe");
    model::train::train(&set, &["healthy".into()], &recipe).and_then(|own| own.embed()).expect("trains")
});

fn judged(condition: &str, defect: Defect, count: u32) -> Vec<SegmentReport> {
    let all = records(condition, Purpose::Validation, defect, count).into_iter();
    all.map(|own| TRAINED.run(&labelled(own, 0).trace).into_iter().next().expect("a segment")).collect()
}

fn percent(all: &[SegmentReport], is: impl Fn(&SegmentReport) -> bool) -> f64 {
    100.0 * all.iter().filter(|own| is(own)).count() as f64 / all.len() as f64
}

fn novel(own: &SegmentReport) -> bool {
    own.verdict == Ok(Finding::Novel)
}

/// The amplitude of the weight in the middle record, A.
fn weight_a(all: &[SegmentReport]) -> f32 {
    let mut weights: Vec<f32> =
        all.iter().map(|own| own.friction.and_then(|friction| friction.weight_a()).expect("a weight").0).collect();
    weights.sort_unstable_by(f32::total_cmp);
    weights[weights.len() / 2]
}

#[test]
fn small_defects_of_an_axis_with_a_weight_are_found() {
    let healthy = judged("axis-0.15", Defect::HEALTHY, 100);
    let spall = judged("axis-0.15", Defect { kind: DefectKind::Spall, severity: 0.25 }, 60);
    let rough = judged("axis-0.15", Defect { kind: DefectKind::Roughness, severity: 0.125 }, 60);
    let small = judged("axis-0.15", Defect { kind: DefectKind::Spall, severity: 1.0 / 32.0 }, 60);
    let found = [&healthy, &spall, &rough, &small].map(|all| percent(all, novel));
    println!(
        "novel, %: healthy {}, spall 1/4 {}, roughness 1/8 {}, spall 1/32 {}",
        found[0], found[1], found[2], found[3]
    );
    // docs/field.md has 1.1, 100 and 88 % of more records. A spall of 1/32 is below what one record tells.
    assert!(found[0] <= 5.0 && found[1] >= 95.0 && found[2] >= 70.0, "{found:?}");
    assert!(found[2] < 100.0 || found[3] < 60.0, "suspiciously good: {found:?}");
    let weight = weight_a(&healthy);
    assert!((weight / 3.0 - 1.0).abs() < 0.15, "0.15 N·m at 20 A/(N·m), and not {weight} A");
}

#[test]
fn another_payload_is_no_defect_and_is_said_as_weight() {
    // 0.4 N·m instead of 0.15.
    let heavy = judged("axis-0.4", Defect::HEALTHY, 60);
    let (found, weight) = (percent(&heavy, novel), weight_a(&heavy));
    println!("novel with 2.7 times the payload: {found} %, weight {weight} A");
    assert!(found <= 10.0, "{found} %");
    assert!((weight / 8.0 - 1.0).abs() < 0.15, "{weight} A");
}
