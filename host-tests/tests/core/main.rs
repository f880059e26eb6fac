//! The core: each of its rooms against oracles in double precision, and on streams that no laboratory would record.

mod ad2s1210;
mod arithmetic;
mod covariates;
mod delta_form;
mod detector;
mod drive_faults;
mod endurance;
mod estimator_edges;
mod evidence;
mod evidence_of_drives;
mod fault_table;
mod filter_design;
mod fixed_plans;
mod frames;
mod half_band;
mod implausible;
mod injected_faults;
mod missing;
mod model_file;
mod model_ranges;
mod novelty;
mod oracle;
mod parts;
mod readme;
mod replayed_faults;
mod resampling;
mod rig;
mod rising;
mod robustness;
mod safety;
mod saved;
mod shaft;
mod shaft_model;
mod shaft_streams;
mod silent_faults;
mod soak;
#[path = "../../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
mod storage;
mod streaming;
mod streaming_consistency;
mod telemetry;
mod telemetry_risen;
mod wiring;

use standard_rig::model as exported;
