//! What a training chooses to watch the shaft: filters, harmonics, and the source of the velocity.

use model::train::{VelocitySource, train};
use rig::{Condition, Defect};

use crate::campaign::experiments::Training;
use crate::campaign::run::{class_names, ours, training_set};
use crate::field::recipe::recipe;

/// The high-pass a sample, trained under this condition.
fn chosen_high_pass(condition: Condition) -> f32 {
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
    let known = chosen_high_pass(Condition::STANDARD);
    assert!(known < 0.02, "{known}");
    let high_pass = chosen_high_pass(Condition::named("field-sine").expect("a condition"));
    assert!(high_pass > 0.02, "{high_pass}");
}

/// The weights of the outer ring's order after training on so many healthy records of a condition.
fn chosen_weights(condition: &str, count: u32, fewer_harmonics: bool) -> [f32; 3] {
    let condition = Condition::named(condition).expect("a condition");
    let training = Training { condition, classes: vec![Defect::HEALTHY], count };
    let set = training_set(&training, 78).expect("the rig");
    let mut recipe = recipe(&condition, &["order_outer".into()]);
    recipe.shaft.iter_mut().for_each(|plan| plan.fewer_harmonics = fewer_harmonics);
    let trained = train(&set, &class_names(&training.classes), &recipe);
    let (_, shaft) = trained.expect("trains").parts.shaft.expect("watched");
    shaft.tracking.orders[0].weights
}

/// In one direction the third harmonic, 11.15, is searched down to 10.9, over a sideband of the cogging at 11.
#[test]
fn harmonics_on_lines_of_the_rotor_are_left_out_and_others_are_not() {
    assert!(chosen_weights("field-any", 150, true)[2] <= 0.0);
    assert_eq!(chosen_weights("field-any", 50, false), [1.0, 0.5, 0.25]);
    // The load hides all harmonics alike.
    assert!(chosen_weights("no-load-sensor", 100, true)[1] > 0.0);
    // Too few traces to tell.
    assert_eq!(chosen_weights("field-any", 30, true), [1.0, 0.5, 0.25]);
}

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
