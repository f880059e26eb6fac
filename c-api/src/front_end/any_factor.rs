//! A front end for every factor of decimation, in the library without one of its plan.

use bearing_watch::Model;
use bearing_watch::drive::{CleanSample, Faults, FrontEnd, FrontEndConstants, RawSample, WiringCheck};
use bearing_watch::plan::Signals as _;

use crate::code::{BwCode, Outcome};
use crate::plan::{BW_MAX_CHANNELS, BW_MAX_FURTHER, Own, Sample};

/// Number of channels that pass the filters; those that are not in use are zero.
pub(crate) const FURTHER: usize = BW_MAX_FURTHER;

/// Creates the front end.
///
/// # Errors
/// What is wrong with the constants, the factor, or the number of further channels.
pub(super) fn create(factor: u16, further: u16, constants: &FrontEndConstants) -> Outcome<Chain> {
    if usize::from(further) > FURTHER { Err(BwCode::FrontEndFurther) } else { Chain::new(factor, constants) }
}

/// Where a clean sample has each channel of the model.
#[derive(Debug)]
pub(super) struct Columns([Column; BW_MAX_CHANNELS]);

#[derive(Clone, Copy, Debug)]
enum Column {
    Current,
    Velocity,
    Further(u8),
}

impl Columns {
    /// The channels `current_a` and `velocity_rad_s` are those that the front end makes; the others are its further
    /// ones in their order.
    ///
    /// # Errors
    /// Another number of these than the front end has.
    pub(super) fn of(model: &Model<Own>, further: u16) -> Outcome<Self> {
        let (mut columns, mut next) = ([Column::Current; BW_MAX_CHANNELS], 0_u8);
        for (column, channel) in columns.iter_mut().zip(&model.constants().channels) {
            *column = match channel.name.as_str() {
                "current_a" => Column::Current,
                "velocity_rad_s" => Column::Velocity,
                _ => {
                    next = next.wrapping_add(1);
                    Column::Further(next.wrapping_sub(1))
                }
            };
        }
        if u16::from(next) == further { Ok(Self(columns)) } else { Err(BwCode::FrontEndFurther) }
    }

    /// The sample of the model.
    #[inline]
    pub(super) fn sample(&self, clean: CleanSample<FURTHER>) -> Sample {
        let value = |column: Column| match column {
            Column::Current => clean.current_a,
            Column::Velocity => clean.velocity_rad_s,
            Column::Further(place) => clean.further.get(usize::from(place)).copied().unwrap_or(f32::NAN),
        };
        Sample::of(&self.0.map(value), clean.angle)
    }
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
