//! What is read of a recording, and what is done to it before.

use super::whole::Settings;
use crate::Error;
use crate::identify::Structure;
use crate::trace::{Channels, FrontEndFile, Preparation};
use crate::train::ShaftPlan;

/// What is read of recordings.
#[derive(Clone, Debug)]
pub struct Reading {
    /// The structure of the difference model.
    pub structure: Structure,
    /// All columns, also those of the shaft and of averages.
    pub channels: Channels,
    /// The plan of the shaft, if it is watched.
    pub shaft: Option<ShaftPlan>,
    /// What is done to the traces before.
    pub preparation: Preparation,
}

impl Settings {
    /// What is read of recordings that pass this front end, if there is one.
    ///
    /// # Errors
    /// Channels or an order that are missing or do not go together.
    pub fn reading(&self, front_end: Option<FrontEndFile>) -> Result<Reading, Error> {
        let own = self.clone().completed();
        let structure = own.model.structure()?;
        own.channels.require(structure)?;
        let mut channels = own.channels(front_end)?;
        let (shaft_channels, shaft) = own.shaft(&channels.y)?.unzip();
        channels.shaft = shaft_channels;
        let preparation = own.model.preparation()?;
        let channels = own.model.averaged((structure, shaft.as_ref()), channels, preparation)?;
        Ok(Reading { structure, channels, shaft, preparation })
    }
}
