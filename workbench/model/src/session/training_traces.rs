//! What a model is trained on.

use crate::trace::labels::LabelledTrace;
use crate::train::Recipe;

/// Traces with their classes, and the recipe for them.
pub(super) struct Traces {
    pub(super) classes: Vec<String>,
    /// As recorded.
    pub(super) training: Vec<LabelledTrace>,
    pub(super) prepared: Vec<LabelledTrace>,
    pub(super) recipe: Recipe,
}
