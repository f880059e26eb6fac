//! Where and why ours differs from the source, in words.

use super::{Settings, Table};
use crate::identify::Order;

/// An order vector as the source writes it.
pub(super) fn order(order: Order) -> String {
    let numbers = order.to_array().map(|n| n.to_string()).join(" ");
    format!("[{numbers}]")
}

/// The words of a finished table.
pub(super) fn of(_table: &Table) -> Vec<String> {
    vec![]
}

/// What stands before the tables.
#[must_use]
pub fn intro(_settings: &Settings) -> Vec<String> {
    vec![]
}
