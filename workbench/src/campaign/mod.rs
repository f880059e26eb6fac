//! Campaigns: many labelled traces of the rig, under many conditions, with seeds that never meet.
//!
//! What enters: a scenario and a list of [`Cell`]s (what for, which repetition, condition and defect). What leaves:
//! [`Recording`]s, simulated in parallel and in the order asked for.
//!
//! | room | what it holds |
//! |---|---|
//! | [`sets`] | cells, their seeds, and the traces in them |

pub mod sets;

pub use sets::{Cell, Purpose, Recording, map_traces, record};
