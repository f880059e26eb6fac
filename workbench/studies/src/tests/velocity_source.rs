//! The source of the velocity that a training chooses.

use model::train::{VelocitySource, train};
use rig::{Condition, Defect};

use crate::campaign::experiments::Training;
use crate::campaign::run::{class_names, ours, training_set};
use crate::field::recipe::recipe;

#[test]
fn the_better_source_is_chosen() {
    let named = |name| Condition::named(name).expect("a condition");
    let chosen = |condition, load| {
        let training = Training { condition, classes: vec![Defect::HEALTHY], count: 16 };
        let set = training_set(&training, 78).expect("the rig");
        let recipe = if load { ours(0.05) } else { recipe(&named("no-load-sensor"), &[]) };
        let trained = train(&set, &class_names(&training.classes), &recipe).expect("trains");
        let source = trained.recipe.shaft.map(|plan| plan.velocity);
        let channels = trained.parts.channels.len();
        (source, channels)
    };
    // 14 bits have less noise than the rig's velocity; with jitter of the sampling instants they have more than the
    // filtered velocity of the field.
    assert_eq!(chosen(Condition::MIX, true), (Some(VelocitySource::Angle), 3));
    assert_eq!(chosen(named("field-sine"), true), (Some(VelocitySource::Channel), 4));
    assert_eq!(chosen(named("no-load-sensor"), false), (Some(VelocitySource::Angle), 2));
    assert_eq!(chosen(named("field-sine"), false), (Some(VelocitySource::Channel), 3));
}
