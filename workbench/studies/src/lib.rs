//! Studies on the simulated rigs: the demonstration, the campaigns, and the source's tables compared with ours.
//!
//! The size of a study and its first seed enter; tables of rates with their intervals leave, as text, JSON or a page. A
//! study simulates traces, trains detectors on them, and counts their verdicts on other traces. The same seed gives the
//! same table on every machine.
//!
//! | module | content |
//! |---|---|
//! | [`recipes`] | the configurations that the studies train |
//! | [`demo`] | labelled traces of the standard rig, and one draw of the whole chain |
//! | [`demo_drive`] | a drive of which the user sets what is wrong |
//! | [`literal`] | the source's own method |
//! | [`campaign`] | experiments over many conditions and repetitions |
//! | [`ema`] | the actuator, from phase currents and resolver counts to verdicts |
//! | [`field`] | the effects of the field, one by one and together |
//! | [`tables`] | the source's tables |
//! | [`pages`] | pages of the results |

pub mod campaign;
pub mod demo;
pub mod demo_drive;
pub mod ema;
pub mod field;
pub mod literal;
pub mod pages;
pub mod recipes;
pub mod simulation;
pub mod tables;
#[cfg(test)]
mod tests;
