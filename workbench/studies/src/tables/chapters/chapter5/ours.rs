//! Our method on the recordings of chapter 5.

use super::draw::Draw;
use crate::ema::recipe;
use model::Error;
use model::core::Finding;
use model::evaluate::{self, Confusion};
use model::train::train;

/// Name of the row with its results.
pub const NAME: &str = "ours: torque balance, orders of both races, QDA, the core in f32";

/// Description of the method in one sentence.
pub const DESCRIPTION: &str = "Ours, for the actuator: drag from the torque balance, and the scores of \
     the orders of both races; at RIT from phase currents and resolver counts through the core's front end.";

/// Decisions on the validation set by the embedded detector that was trained on the training set.
///
/// # Errors
/// Returns an error if training or embedding fails.
pub fn judge(draw: &Draw) -> Result<Confusion, Error> {
    let [training, validation] = draw.ours();
    let names = draw.names();
    let model = train(&training, &names, &recipe::classes_alone())?.embed()?;
    let mut confusion = Confusion::new(&names);
    for verdict in evaluate::run(&model, &validation, || ())? {
        confusion.add(verdict.class, verdict.decided.and_then(Finding::class));
    }
    Ok(confusion)
}
