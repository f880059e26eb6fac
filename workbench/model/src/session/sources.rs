//! A model as source code.

use crate::Error;
use crate::trace::Channels;
use crate::train::front_end_source::front_end_source;
use crate::train::{Trained, VelocitySource, export};

/// The static that a drive without a front end gives its samples.
const WATCH: &str = "bearing_watch::watch_static! {
    /// Detector and monitor of the drive.
    pub static WATCH: Drive;
}
";

/// A model as Rust source, with the front end that its recordings pass.
///
/// # Errors
/// A model that the core does not accept.
pub fn rust_source(trained: &Trained, description: &[String], channels: &Channels) -> Result<String, Error> {
    let mut source = export::rust_source(trained, description)?;
    source += "\n";
    source += &match &channels.front_end {
        Some(front_end) => front_end_source(&trained.to_core()?, channels, front_end)?,
        None => WATCH.into(),
    };
    Ok(source)
}

/// The channels that the model reads: without the reference, and without the velocity if it is taken from the angle.
#[must_use]
pub fn read_by(trained: &Trained, mut channels: Channels) -> Channels {
    if let (Some(shaft), Some(plan)) = (&mut channels.shaft, &trained.recipe.shaft) {
        shaft.reference = None;
        if plan.velocity == VelocitySource::Angle {
            shaft.velocity = None;
        }
    }
    channels
}
