//! The doors of the core and of its C interface.

mod c_detector;
mod c_front_end;
mod c_telemetry;
mod converter;
mod detector;
mod flash;
mod front_end;
pub mod model;
mod recovery;
#[cfg(feature = "signature")]
mod signature;
pub mod telemetry;

use crate::Door;

/// The doors.
pub static DOORS: &[Door] = &[
    Door::new("model", "bytes of a model", model::attack),
    Door::new("detector-squares", "samples and calls, least squares", detector::squares),
    Door::new("detector-refined", "samples and calls, instrumental variables", detector::refined),
    Door::new("detector-shaft", "samples and calls, shaft and bearing orders", detector::watched),
    Door::new("detector-run-time", "samples and calls, any structure, method and memory", detector::run_time),
    Door::new("recovery", "a bad interval in a stream", recovery::attack),
    Door::new("front-end", "raw counts, angles and constants", front_end::attack),
    Door::new("converter", "answers of an AD2S1210", converter::attack),
    Door::new("telemetry", "bytes of a line", telemetry::attack),
    Door::new("flash", "content and power of a flash", flash::attack),
    Door::new("c-detector", "calls of the C interface, detector", c_detector::attack),
    Door::new("c-front-end", "calls of the C interface, front end", c_front_end::attack),
    Door::new("c-telemetry", "calls of the C interface, recorders and frames", c_telemetry::attack),
    #[cfg(feature = "signature")]
    Door::new("signature", "signed models and sealed states", signature::attack),
];
