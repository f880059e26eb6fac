//! What a user gets who names his signals, the bearing and the rate.

use crate::campaign::run::{class_names, traces};
use crate::field::recipe::by_default;
use crate::field::rows::named;
use model::core::{Embedded, Finding};
use model::trace::labels::LabelledTrace;
use model::train::{Estimation, train};
use rig::{Defect, DefectKind};

#[test]
fn the_signals_decide_what_is_watched() {
    for (name, load) in [("temperature", true), ("no-load-sensor", false)] {
        let row = named(&[name.into()]).expect("a row")[0];
        let recipe = by_default(&row, &["healthy".into()]).expect("settings that go together");
        assert!(recipe.automatic && recipe.features.is_empty() && recipe.alarms.required);
        assert_eq!((recipe.structure.nc > 0, recipe.alarms.false_alarm), (load, 0.01));
        let plan = recipe.shaft.expect("an angle");
        assert_eq!((plan.names(), plan.load, plan.slip), (vec!["outer".into(), "inner".into()], load, 0.022));
        assert_eq!(format!("{:?}", recipe.estimation), format!("{:?}", Estimation::default()));
    }
}

#[test]
fn the_chosen_features_find_small_defects_at_any_temperature() {
    let row = named(&["temperature".into()]).expect("a row")[0];
    let of = |cell, count| traces(&[(cell, 0)], count).expect("simulated");
    let healthy = of(row.training(40, Defect::HEALTHY), 80);
    let classes = class_names(&[Defect::HEALTHY]);
    let recipe = by_default(&row, &classes).expect("settings that go together");
    let trained = train(&healthy, &classes, &recipe).expect("enough healthy traces");
    let why = trained.automatic.as_ref().expect("the features are chosen");
    // The order of the outer race and some friction, whichever set of them is best.
    let winner = &why.winner().features;
    assert!(winner.contains(&"order_outer".into()) && winner.contains(&"drag".into()), "{winner:?}");
    assert!(why.held_out && why.rivals.len() == 5 && why.winner().detected.len() == 4);
    let found = why.winner().detected.iter().all(|own| own.found.windows(2).all(|pair| pair[1] > pair[0] - 0.1));
    assert!(found, "larger defects are found more often: {:?}", why.winner().detected);
    let detector = trained.embed().expect("a model");
    let novel = |detector: &Embedded, records: &[LabelledTrace]| {
        let decided = |own: &LabelledTrace| detector.combine(&detector.run(&own.trace)).map(|(finding, _)| finding);
        records.iter().filter(|own| decided(own) != Some(Finding::Class(0))).count()
    };
    let defect = |kind, severity| of(row.validation(40, Defect { kind, severity }), 20);
    let spalls = novel(&detector, &defect(DefectKind::Spall, 0.25));
    let rough = novel(&detector, &defect(DefectKind::Roughness, 0.125));
    // The table of the field has 100 % of both with 150 traces; fewer of the smallest roughness, 30 %.
    assert!(spalls >= 19 && rough >= 17, "{spalls} {rough}");
    let smallest = novel(&detector, &defect(DefectKind::Roughness, 1.0 / 32.0));
    assert!(smallest <= 16, "suspiciously many: {smallest}");
    let false_alarms = novel(&detector, &of(row.validation(40, Defect::HEALTHY), 100));
    // At 1 %, more than six of a hundred have a probability of 2e-4; gates of 80 traces scatter by a factor of two.
    assert!(false_alarms <= 6, "{false_alarms}");
}
