//! Trained models on the rigs: what they call, what they miss, and what they refuse.

mod axis_without_sensor;
mod campaigns;
mod field_table;
mod implausible_signals;
mod instruments_model;
mod priors_and_costs;
mod standard_rig;
mod stated_limits;
