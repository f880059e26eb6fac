//! From the settings to output, inputs and front end.

use super::choices::Park;
use super::signals::Signals;
use super::whole::Settings;
use crate::Error;
use crate::identify::Structure;
use crate::trace::{Channels, FrontEndFile};

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
