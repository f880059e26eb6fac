//! Features of segments as labelled rows, and what there is to say of the rows before a classifier is fitted.
//!
//! ```text
//! traces ─► core_features ─► table ─► folds: rows with groups ─┬─► left_out, contamination: rows that are left out
//!                                                              ├─► dependence: rows that are alike
//!                                                              └─► covariates: what temperatures explain
//! ```

pub(crate) mod contamination;
pub(crate) mod core_features;
pub(crate) mod covariates;
pub(crate) mod dependence;
pub(crate) mod folds;
pub(crate) mod left_out;
pub(crate) mod table;

pub use contamination::Doubted;
pub use core_features::row as features_of;
pub use covariates::{Coefficient, Explained, Explaining};
pub use dependence::Dependence;
pub use folds::{Candidates, Folds, Validation};
pub use left_out::LeftOut;
pub use table::{AffineMap, FeatureTable};
