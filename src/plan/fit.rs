//! Whether the parts of a layout fit each other, and why not.

use super::layout::{
    Layout, MAX_CHANNELS, MAX_COVARIATES, MAX_DIRECTIONS, MAX_HARMONICS, MAX_OUTPUT_TERMS, Method, RegressionLayout,
    ShaftLayout, Signal,
};

/// Returns early with the error of another check.
macro_rules! pass {
    ($check:expr) => {
        if let Err(error) = $check {
            return Err(error);
        }
    };
}

/// Why a layout is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LayoutError {
    /// Neither a regression nor a shaft.
    Empty,
    /// No channel, or more than [`MAX_CHANNELS`].
    Channels,
    /// A signal names a channel that the sample does not have.
    UnknownChannel,
    /// The sample has a channel that no part uses.
    UnusedChannel,
    /// A signal is the difference of a channel and itself, which is zero.
    NoDifference,
    /// The regression has no terms, or more than 254 columns.
    Terms,
    /// Instrumental variables need 1 … 4 output terms.
    OutputTerms,
    /// The shaft has more than 32 orders, not 1 … 3 harmonics, or takes neither each sample nor each second one.
    Orders,
    /// More than [`MAX_COVARIATES`] covariates.
    Covariates,
    /// No features, no coordinates or no classes.
    Classifier,
    /// More rising coordinates than coordinates.
    Rising,
    /// More than 8 directions.
    Directions,
}

impl LayoutError {
    /// The error in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Empty => "the plan has neither a regression nor a shaft",
            Self::Channels => "the plan has no channel or more than 16 channels",
            Self::UnknownChannel => "a signal of the plan names a channel that its sample does not have",
            Self::UnusedChannel => "the sample of the plan has a channel that the plan does not use",
            Self::NoDifference => "a signal of the plan is the difference of a channel and itself",
            Self::Terms => "the regression of the plan has no terms or more than 254 columns",
            Self::OutputTerms => "instrumental variables need 1 to 4 output terms",
            Self::Orders => {
                "the plan has more than 32 bearing orders, not 1 to 3 harmonics, or a decimation other than 1 and 2"
            }
            Self::Covariates => "the plan has more than 8 covariates",
            Self::Classifier => "the plan has no features, no coordinates or no classes",
            Self::Rising => "the plan has more rising coordinates than coordinates",
            Self::Directions => "the plan has more than 8 directions",
        }
    }
}

impl core::fmt::Display for LayoutError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for LayoutError {}

impl Layout {
    /// Checks that the parts fit each other.
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub const fn check(&self) -> Result<(), LayoutError> {
        if self.regression.is_none() && self.shaft.is_none() {
            return Err(LayoutError::Empty);
        }
        let channels = self.channels as usize;
        if channels == 0 || channels > MAX_CHANNELS {
            return Err(LayoutError::Channels);
        }
        pass!(self.check_signals());
        let mut used: u16 = 0;
        if let Some(regression) = &self.regression {
            used |= regression.mask();
            if regression.structure.terms() == 0 || regression.columns() > 254 {
                return Err(LayoutError::Terms);
            }
            let na = regression.structure.na as usize;
            if matches!(regression.method, Method::Instruments) && (na == 0 || na > MAX_OUTPUT_TERMS) {
                return Err(LayoutError::OutputTerms);
            }
        }
        if let Some(shaft) = &self.shaft {
            used |= shaft.mask();
            let harmonics = shaft.harmonics as usize;
            let stepped = shaft.decimation == 1 || shaft.is_halved();
            if shaft.orders > 32 || harmonics == 0 || harmonics > MAX_HARMONICS || !stepped {
                return Err(LayoutError::Orders);
            }
        }
        used |= self.averaged;
        let there = if channels == MAX_CHANNELS { u16::MAX } else { (1 << channels) - 1 };
        if used & !there != 0 {
            return Err(LayoutError::UnknownChannel);
        }
        if used != there {
            return Err(LayoutError::UnusedChannel);
        }
        if self.covariates as usize > MAX_COVARIATES {
            return Err(LayoutError::Covariates);
        }
        if self.features == 0 || self.coordinates == 0 || self.classes == 0 {
            return Err(LayoutError::Classifier);
        }
        if self.rising > self.coordinates {
            return Err(LayoutError::Rising);
        }
        if self.directions > MAX_DIRECTIONS {
            return Err(LayoutError::Directions);
        }
        Ok(())
    }

    /// Checks the channels of each signal that is read: the mask of a signal has no place for those beyond the last.
    const fn check_signals(&self) -> Result<(), LayoutError> {
        if let Some(RegressionLayout { structure, y, u1, u2, .. }) = self.regression {
            pass!(self.check_signal(Some(y)));
            pass!(self.check_signal(if structure.nb > 0 { Some(u1) } else { None }));
            pass!(self.check_signal(if structure.nc > 0 { Some(u2) } else { None }));
        }
        if let Some(ShaftLayout { current, velocity, load, .. }) = self.shaft {
            pass!(self.check_signal(Some(current)));
            pass!(self.check_signal(velocity));
            pass!(self.check_signal(load.measured()));
        }
        Ok(())
    }

    const fn check_signal(&self, signal: Option<Signal>) -> Result<(), LayoutError> {
        match signal {
            Some(Signal { channel, minus: Some(other) }) if channel == other => Err(LayoutError::NoDifference),
            Some(Signal { channel, minus: Some(other) }) if channel >= self.channels || other >= self.channels => {
                Err(LayoutError::UnknownChannel)
            }
            Some(Signal { channel, .. }) if channel >= self.channels => Err(LayoutError::UnknownChannel),
            _ => Ok(()),
        }
    }
}
