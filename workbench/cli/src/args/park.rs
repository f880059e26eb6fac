//! Argument of the sign convention of the quadrature current.

use bearing_watch::Park;
use clap::{Args, ValueEnum};

use model::Error;
use model::trace::{Channels, FrontEndFile};

#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct ParkArgs {
    /// Sign convention of the quadrature current in the recordings; the model then refuses a front end that differs
    #[arg(long, value_enum)]
    park: Option<ParkConvention>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ParkConvention {
    /// With the angle on the magnet axis, positive q current produces positive torque
    Standard,
    /// The +sin row of the source's Eq. 5.1
    Thesis,
}

impl ParkConvention {
    const fn core(self) -> Park {
        match self {
            Self::Standard => Park::Standard,
            Self::Thesis => Park::Thesis,
        }
    }
}

impl ParkArgs {
    /// The sign convention of the recordings: that of the front end, if there is one.
    pub(crate) fn of(self, channels: &Channels) -> Result<Option<Park>, Error> {
        let asked = self.park.map(ParkConvention::core);
        match (asked, channels.front_end.as_ref().map(FrontEndFile::park)) {
            (Some(asked), Some(own)) if asked != own => {
                Err(Error::Usage("--park differs from the convention of --front-end".into()))
            }
            (asked, own) => Ok(own.or(asked)),
        }
    }
}
