//! The whole system on simulated and recorded traces: rigs, identification, training, and the verdicts of the core.

mod actuator;
mod campaign;
mod consistency;
mod dc_motor_recordings;
mod dc_motor_rig;
mod embedded_estimates;
mod estimators;
mod field_table;
mod formats;
mod identification;
mod implausible_signals;
mod instruments_model;
mod lab_files;
mod piecewise;
mod priors_and_costs;
mod recorded_actuators;
mod recorded_drives;
mod recorded_families;
mod recorded_forward;
mod recorded_healthy_only;
mod recorded_later_runs;
mod recorded_slip;
mod recorded_wear;
mod standard_rig;
mod structure;
mod validation;
