//! Samples of any bits, and calls in any order, for detectors of several plans.

use crate::input::Input;
use crate::models::{LOADLESS, REFINED, REGRESSIONS, RIG, WATCHED};
use crate::{memory, session};

/// Least squares.
pub fn squares(bytes: &[u8]) {
    let model = &*RIG;
    memory::without_allocation(|| session::run(model, &mut Input::new(bytes)));
}

/// Instrumental variables.
pub fn refined(bytes: &[u8]) {
    let model = &*REFINED;
    memory::without_allocation(|| session::run(model, &mut Input::new(bytes)));
}

/// Shafts with and without regression and load.
pub fn watched(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    if input.byte().is_multiple_of(2) {
        let model = &*WATCHED;
        memory::without_allocation(|| session::run(model, &mut input));
    } else {
        let model = &*LOADLESS;
        memory::without_allocation(|| session::run(model, &mut input));
    }
}

/// Regressions of any structure, method and memory, of which the model brings the lengths.
pub fn run_time(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let model = &REGRESSIONS[input.below(REGRESSIONS.len())];
    session::run(model, &mut input);
}
