//! A trained model, and what is made of it: a model file, source of Rust, a header of C.

use super::description;
use super::evidence::Orders;
use crate::Error;
use crate::evaluate::{self, TraceVerdict};
use crate::session::judging::prepare;
use crate::session::notes::Notes;
use crate::session::selection::Groups;
use crate::trace::labels::LabelledTrace;
use crate::trace::{Channels, Preparation, Tally};
use crate::train::c_header::c_header;
use crate::train::front_end_source::front_end_source;
use crate::train::{Trained, VelocitySource, export};

/// A trained model with the traces that it was trained on.
#[derive(Debug)]
pub struct Training {
    /// The model.
    pub trained: Trained,
    /// The model file.
    pub bytes: Vec<u8>,
    /// The columns that it reads.
    pub channels: Channels,
    /// The training traces as recorded.
    pub training: Vec<LabelledTrace>,
    /// The training traces as the model was trained on them.
    pub prepared: Vec<LabelledTrace>,
    /// Comment lines for exported sources.
    pub(crate) description: Vec<String>,
    /// What remains to be done before the detector.
    pub(crate) host: Preparation,
    pub(crate) orders: Option<Orders>,
    /// Traces that the settings hold out.
    pub(crate) held_out: Option<(Vec<LabelledTrace>, Groups)>,
    pub(crate) notes: Notes,
    /// What is doubtful about its precision.
    pub(crate) doubt: Option<String>,
}

impl Training {
    /// The same whose model carries this text of a drive file.
    ///
    /// # Errors
    /// A model that has no room for it.
    pub fn with_drive(mut self, text: String) -> Result<Self, Error> {
        self.notes.drive = Some(text);
        self.bytes = self.trained.to_bytes(&self.notes.to_text())?;
        Ok(self)
    }

    /// Verdicts of the embedded detector on the training traces.
    ///
    /// # Errors
    /// The core rejects the model.
    pub fn seen(&self) -> Result<Vec<TraceVerdict>, Error> {
        evaluate::run(&self.trained.embed()?, &prepare(&self.training, self.host)?, || {})
    }

    /// The model as Rust source, with the front end that its recordings passed.
    ///
    /// # Errors
    /// A model that the core does not accept.
    pub fn rust_source(&self) -> Result<String, Error> {
        rust_source(&self.trained, &self.description, &self.channels)
    }

    /// The model as a C header, with this name in its names.
    ///
    /// # Errors
    /// A model that the core does not accept, and a name that is not one of C.
    pub fn c_header(&self, name: Option<&str>) -> Result<String, Error> {
        c_header(&self.trained.to_core()?, (&self.description, &self.notes.orders), Some(&self.channels), name)
    }

    /// What is missing in the recordings of training.
    #[must_use]
    pub fn missing(&self) -> Tally {
        self.training.iter().map(|own| &own.trace).collect()
    }

    /// What is uncertain about the model.
    #[must_use]
    pub fn doubts(&self) -> Vec<String> {
        description::doubts(&self.trained)
    }
}

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
    if !trained.identifies() {
        // The output remains: by its numbers recordings are known again.
        (channels.u1, channels.u2) = (channels.y.clone(), channels.y.clone());
    }
    channels
}
