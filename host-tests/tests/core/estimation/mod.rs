//! The streaming estimators against double precision, against the truth, and on bad data.

mod consistency;
mod delta_form;
mod edges;
mod oracle;
mod robustness;
mod streaming;
