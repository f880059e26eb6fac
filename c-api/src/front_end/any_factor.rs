//! A front end for every factor of decimation, in the library without one of its plan.

use bearing_watch::drive::{CleanSample, Faults, FrontEnd, FrontEndConstants, RawSample, WiringCheck};

use crate::code::{BwCode, Outcome};
use crate::plan::BW_MAX_FURTHER;

/// Number of channels that pass the filters; those that are not in use are zero.
pub(crate) const FURTHER: usize = BW_MAX_FURTHER;

/// Creates the front end.
///
/// # Errors
/// What is wrong with the constants, the factor, or the number of further channels.
pub(super) fn create(factor: u16, further: u16, constants: &FrontEndConstants) -> Outcome<Chain> {
    if usize::from(further) > FURTHER { Err(BwCode::FrontEndFurther) } else { Chain::new(factor, constants) }
}

macro_rules! any_factor {
    ($($name:ident: $factor:literal;)+) => {
        /// The front end of one of the factors.
        #[derive(Clone, Debug, PartialEq)]
        pub(super) enum Chain {$(
            $name(FrontEnd<FURTHER, $factor>),
        )+}

        impl Chain {
            fn new(factor: u16, constants: &FrontEndConstants) -> Outcome<Self> {
                match factor {
                    $($factor => Ok(Self::$name(FrontEnd::new(constants)?)),)+
                    _ => Err(BwCode::FrontEndFactor),
                }
            }

            pub(super) fn push(&mut self, raw: &RawSample<FURTHER>) -> Option<CleanSample<FURTHER>> {
                match self {
                    $(Self::$name(own) => own.push(raw),)+
                }
            }

            pub(super) fn check_wiring(
                &mut self,
                raw: &RawSample<FURTHER>,
                velocity_rad_s: f32,
                check: &mut WiringCheck,
            ) {
                match self {
                    $(Self::$name(own) => own.check_wiring(raw, velocity_rad_s, check),)+
                }
            }

            pub(super) fn faults(&self) -> Faults {
                match self {
                    $(Self::$name(own) => own.faults(),)+
                }
            }

            pub(super) fn clear_faults(&mut self) {
                match self {
                    $(Self::$name(own) => own.clear_faults(),)+
                }
            }
        }
    };
}

any_factor! {
    By1: 1;
    By2: 2;
    By4: 4;
    By8: 8;
    By16: 16;
    By32: 32;
    By6: 6;
    By12: 12;
    By24: 24;
    By48: 48;
    By10: 10;
    By20: 20;
    By40: 40;
}
