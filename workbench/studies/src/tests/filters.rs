//! The filters of the orders that a training chooses.

use model::train::{VelocitySource, train};
use rig::{Condition, Defect};

use crate::campaign::experiments::Training;
use crate::campaign::run::{class_names, ours, training_set};

/// The high-pass a sample, trained under this condition.
fn chosen(condition: Condition) -> f32 {
    let training = Training { condition, classes: vec![Defect::HEALTHY], count: 16 };
    let set = training_set(&training, 77).expect("the rig");
    // With the little noise of the angle, even the small errors of this balance would be filtered.
    let mut recipe = ours(0.05);
    recipe.shaft.iter_mut().for_each(|plan| plan.velocity = VelocitySource::Channel);
    let trained = train(&set, &class_names(&training.classes), &recipe).expect("trains");
    let (layout, shaft) = trained.parts.shaft.expect("watched");
    // The constant is that of a step.
    shaft.tracking.blocks.high_pass / f32::from(layout.decimation)
}

#[test]
fn what_the_balance_does_not_know_is_filtered_and_a_known_drive_is_not() {
    // A drive whose parameters hardly vary needs no high-pass; under all effects of the field the balance is wrong.
    let known = chosen(Condition::STANDARD);
    assert!(known < 0.02, "{known}");
    let high_pass = chosen(Condition::named("field-sine").expect("a condition"));
    assert!(high_pass > 0.02, "{high_pass}");
}
