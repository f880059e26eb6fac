//! The front end of the library's plan.

use bearing_watch::Model;
use bearing_watch::drive::{CleanSample, FrontEndConstants};

use crate::code::{BwCode, Outcome};
pub(super) use crate::plan::DriveFrontEnd as Chain;
pub(crate) use crate::plan::FURTHER;
use crate::plan::{BW_MAX_FURTHER, Own, Sample};

/// Creates the front end.
///
/// # Errors
/// What is wrong with the constants, another factor or number of further channels than the plan has, or more of these
/// than the interface takes.
pub(super) fn create(factor: u16, further: u16, constants: &FrontEndConstants) -> Outcome<Chain> {
    if usize::from(further) != FURTHER || FURTHER > BW_MAX_FURTHER {
        return Err(BwCode::FrontEndFurther);
    }
    if usize::from(factor) != Chain::FACTOR {
        return Err(BwCode::FrontEndFactor);
    }
    Ok(Chain::new(constants)?)
}

/// The channels of the plan are those of its front end.
#[derive(Debug)]
pub(super) struct Columns;

impl Columns {
    #[expect(clippy::unnecessary_wraps, reason = "a library for any model has errors here")]
    pub(super) const fn of(_: &Model<Own>, _: u16) -> Outcome<Self> {
        Ok(Self)
    }

    #[inline]
    pub(super) fn sample(&self, clean: CleanSample<FURTHER>) -> Sample {
        clean.into()
    }
}
