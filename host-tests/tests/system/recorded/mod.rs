//! Recorded drives and actuators, and bearings whose vibration was recorded.

mod emps;
mod families;
mod forward;
mod healthy_only;
mod later_runs;
mod slip;
