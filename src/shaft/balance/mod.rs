//! Current, velocity and load → [`Friction`], by least squares of the torque balance.
//!
//! Enters: the signals of a sample. Leaves: the sums of a segment, which are solved for the friction, and the
//! parameters at present, with which [`super::orders`] forms the residual of each sample.

mod friction;
mod rows;
mod solve;
mod state_variable;
mod sums;

pub use friction::{Friction, LoadTerms, Parameter};
pub use rows::{LEAST_FROM_ROWS, RESTING, RESTING_ROWS, TERMS, TorqueBalance, Torques};
pub use state_variable::StateVariable;
pub(super) use {
    rows::{BalanceState, Regressors},
    solve::Estimated,
    sums::BalanceSums,
};
