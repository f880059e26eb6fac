//! The number of harmonics that a training chooses.

use model::train::train;
use rig::{Condition, Defect};

use crate::campaign::experiments::Training;
use crate::campaign::run::{class_names, training_set};
use crate::field::recipe::recipe;

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
