//! From labelled rows to classes: projection, densities, and their quality on rows that were held out.
//!
//! ```text
//! rows ─► fit: covariates ─► projection ─► discriminant (shrinkage, shrinkage_search)
//!          └─► cross_validation ─► scores;   ranking: what each feature contributes;   matrix: the same without traces
//! ```

pub(crate) mod cross_validation;
pub mod discriminant;
pub(crate) mod fit;
pub(crate) mod matrix;
pub mod projection;
pub(crate) mod ranking;
#[cfg(test)]
mod reference_values;
pub(crate) mod scores;
pub(crate) mod shrinkage;
pub(crate) mod shrinkage_search;

pub use cross_validation::{Forward, predict};
pub use discriminant::GaussianClasses;
pub use matrix::{Matrix, RowClassifier, RowGate};
pub use projection::{Keep, ProjectionKind};
pub use ranking::{Gain, Ranked, Ranking, rank};
pub use scores::{Bin, Decomposition, Prediction, Score, Scores};
pub use shrinkage::{Shrink, Shrinkage};
pub use shrinkage_search::{Choice, GridPoint};
