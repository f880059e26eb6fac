//! Batch estimators, structure search and validation, and the estimates of the core beside them.

mod consistency;
mod embedded;
mod estimators;
mod reference_set;
mod structure;
mod validation;
