//! The whole system on simulated and recorded traces: rigs, identification, training, and the verdicts of the core.

mod alarm;
mod formats;
mod identification;
mod recorded;
mod rigs;
mod verdicts;
