//! The core: each of its rooms against oracles in double precision, and on streams that no laboratory would record.

mod alarm;
mod detector;
mod endurance;
mod estimation;
mod faults;
mod model;
mod power_off;
mod readme;
mod shaft;
mod signals;
#[path = "../../../examples/support/standard_rig/mod.rs"]
mod standard_rig;
mod telemetry;

use standard_rig::model as exported;
