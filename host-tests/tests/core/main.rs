//! The core: each of its rooms against oracles in double precision, and on streams that no laboratory would record.

mod delta_form;
mod endurance;
mod estimator_edges;
mod frames;
mod half_band;
mod novelty;
mod oracle;
mod readme;
mod resampling;
mod rig;
mod robustness;
mod shaft;
mod shaft_streams;
mod streaming;
mod streaming_consistency;
