//! The core: each of its rooms against oracles in double precision, and on streams that no laboratory would record.

mod delta_form;
mod endurance;
mod estimator_edges;
mod frames;
mod half_band;
mod oracle;
mod readme;
mod resampling;
mod robustness;
mod streaming;
mod streaming_consistency;
