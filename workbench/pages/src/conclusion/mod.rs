//! The sentences with which a page begins: what was found, where, since when, how sure it is, and what to do next.
//!
//! Results enter, plain text leaves; command line and page have the same sentences.

pub mod evaluation;
pub mod folder;
pub mod live;
pub mod models;
pub mod recordings;
pub mod replay;
pub mod risen;
mod runs;
pub mod training;

/// A share as text, `2.5 %`.
fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// `a`, `a and b`, `a, b and c`.
fn listed(all: &[String]) -> String {
    match all {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
