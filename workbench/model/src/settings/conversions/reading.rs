//! What is read of a recording, and what is done to it before: settings that follow from others, output, inputs and
//! front end.

use crate::Error;
use crate::identify::Structure;
use crate::settings::sections::choices::Park;
use crate::settings::sections::order::Order;
use crate::settings::sections::settings::Settings;
use crate::settings::sections::signals::Signals;
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

/// Order of the difference model that is tried first on a new drive: the source's Table 4.1.
const ORDER: Structure = Structure::new(2, 1, 2, 1, 1);
/// The same without a second input.
const ORDER_OF_ONE: Structure = Structure::new(2, 1, 0, 1, 1);

impl Settings {
    /// These settings with those that follow: output, inputs and order from the signals of the shaft.
    #[must_use]
    pub fn completed(mut self) -> Self {
        let own = &mut self.channels;
        own.y = own.y.take().or_else(|| own.current.clone());
        own.u1 = own.u1.take().or_else(|| own.velocity_ref.clone()).or_else(|| own.velocity.clone());
        own.u2 = own.u2.take().or_else(|| own.load.clone());
        let order = if own.u2.is_some() { ORDER } else { ORDER_OF_ONE };
        self.model.order = self.model.order.or(Some(Order(order)));
        // An output without an input is described by its own past: no order of it reads the first input.
        if self.model.order.as_ref().is_some_and(|Order(order)| order.nb == 0) {
            own.u1 = own.u1.take().or_else(|| own.y.clone());
        }
        self
    }
}

impl Settings {
    /// Output and inputs, the time, and what makes them; without a second input the first one takes its place, which no
    /// order uses.
    ///
    /// # Errors
    /// No output or no first input.
    pub fn channels(&self, front_end: Option<FrontEndFile>) -> Result<Channels, Error> {
        let Signals { y, u1, u2, .. } = &self.channels;
        let (Some(y), Some(u1)) = (y, u1) else {
            return Err(Error::Usage("the channels y and u1 are not given".into()));
        };
        let (time, rate_hz) = (self.data.time.clone(), self.data.rate_hz);
        let text = self.data.text_form();
        Ok(Channels { time, rate_hz, text, front_end, ..Channels::new(y, u1, u2.as_ref().unwrap_or(u1)) })
    }
}

impl Signals {
    /// Returns an error if the structure has terms of a second input, and none is given.
    ///
    /// # Errors
    /// It has.
    pub fn require(&self, structure: Structure) -> Result<(), Error> {
        if self.u2.is_some() || structure.nc == 0 {
            return Ok(());
        }
        let nc = structure.nc;
        Err(Error::Usage(format!("the order has {nc} terms of a second input; give --u2, or an order with nc = 0")))
    }

    /// The sign convention of the recordings: that of the front end, if there is one.
    ///
    /// # Errors
    /// They differ.
    pub fn park(&self, channels: &Channels) -> Result<Option<bearing_watch::Park>, Error> {
        match (self.park.map(Park::core), channels.front_end.as_ref().map(FrontEndFile::park)) {
            (Some(asked), Some(own)) if asked != own => {
                Err(Error::Usage("--park differs from the convention of --front-end".into()))
            }
            (asked, own) => Ok(own.or(asked)),
        }
    }
}
