//! A trained model, and its form in the core.

pub(crate) mod core_form;
pub mod label;
mod read;
pub(crate) mod sizes;
pub(crate) mod trained;

pub use core_form::compose;
pub use trained::{OrderSight, Sight, Trained};
