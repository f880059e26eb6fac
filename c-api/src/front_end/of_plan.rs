//! The front end of the library's plan.

use bearing_watch::drive::FrontEndConstants;

use crate::code::{BwCode, Outcome};
use crate::plan::BW_MAX_FURTHER;
pub(super) use crate::plan::DriveFrontEnd as Chain;
pub(crate) use crate::plan::FURTHER;

/// Creates the front end.
///
/// # Errors
/// What is wrong with the constants, another factor or number of further channels than the plan has, or more of these
/// than a [`super::BwCleanSample`] has room for.
pub(super) fn create(factor: u16, further: u16, constants: &FrontEndConstants) -> Outcome<Chain> {
    if usize::from(further) != FURTHER || FURTHER > BW_MAX_FURTHER {
        return Err(BwCode::FrontEndFurther);
    }
    if usize::from(factor) != Chain::FACTOR {
        return Err(BwCode::FrontEndFactor);
    }
    Ok(Chain::new(constants)?)
}
