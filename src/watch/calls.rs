//! The start, and the call of the current loop: with a front end, or with signals of the drive's own.

use core::sync::atomic::Ordering;

use super::Watch;
use super::inputs::{Inputs, StartError};
use super::link::count;
use crate::drive::{Alignment, By, CleanSample, Factor, FrontEnd, FrontEndConstants, RawSample, WiringCheck};
use crate::known_answers::known_answer_test;
use crate::model::Model;
use crate::plan::Plan;

impl<P: Plan, const FURTHER: usize, const FACTOR: usize> Watch<P, FrontEnd<FURTHER, FACTOR>>
where
    By<FACTOR>: Factor,
    P::Sample: From<CleanSample<FURTHER>>,
{
    /// Checks model, constants and arithmetic, and makes all parts. Call it once, before the interrupts run.
    ///
    /// # Errors
    /// What is wrong; nothing runs then.
    pub fn start(&'static self, model: &'static Model<P>, constants: &FrontEndConstants) -> Result<(), StartError> {
        known_answer_test().map_err(StartError::Arithmetic)?;
        let front_end = FrontEnd::new(constants).map_err(StartError::FrontEnd)?;
        model.check_rotor_frame(front_end.frame()).map_err(StartError::Model)?;
        model.check_interval(FACTOR as f32 / constants.control_rate_hz).map_err(StartError::Model)?;
        self.start_lower(model)?;
        let filled = self.link.faults.fill(|| front_end.faults()) && self.inputs.fill(|| Inputs::new(front_end));
        if filled { Ok(()) } else { Err(StartError::Started) }
    }

    /// Takes what the current loop has read, at its rate. Returns whether [`Watch::collect`] has work: request its
    /// interrupt then.
    #[must_use = "the interrupt of `collect` is to be requested"]
    #[inline]
    pub fn sample(&self, reading: impl Into<RawSample<FURTHER>>) -> bool {
        let take = |inputs: &mut Inputs<P, FrontEnd<FURTHER, FACTOR>>| {
            let clean = inputs.front_end.push(&reading.into());
            let closed = self.link.counters.closed.load(Ordering::Relaxed);
            let first = inputs.told.is_none();
            if inputs.told != Some(closed) {
                inputs.tell(&self.link, closed);
            }
            let late = clean.is_some_and(|clean| {
                self.link.tell_alignment(clean.alignment);
                clean.found_late
            });
            // The first call of the other context tests its arithmetic, long before the first clean sample.
            inputs.put(&self.link, clean.map(|clean| (clean.into(), late))) || first
        };
        self.inputs.with(take) == Some(true)
    }

    /// Takes what the current loop has read at commissioning, for a check of the wiring instead of the detector. The
    /// velocity is one of the drive's own, rad/s, NaN if there is none. The times of [`Watch::clock`] count anew behind
    /// it.
    pub fn check_wiring(&self, reading: impl Into<RawSample<FURTHER>>, velocity_rad_s: f32, check: &mut WiringCheck) {
        self.inputs.with(|inputs| inputs.front_end.check_wiring(&reading.into(), velocity_rad_s, check));
        count(&self.link.counters.checked);
    }
}

impl<P: Plan> Watch<P> {
    /// Checks the arithmetic, and makes all parts. Call it once, before the interrupts run.
    ///
    /// # Errors
    /// What is wrong; nothing runs then.
    pub fn start(&'static self, model: &'static Model<P>) -> Result<(), StartError> {
        known_answer_test().map_err(StartError::Arithmetic)?;
        self.start_lower(model)?;
        self.link.tell_alignment(Alignment::Unknown);
        if self.inputs.fill(|| Inputs::new(())) { Ok(()) } else { Err(StartError::Started) }
    }

    /// Takes a sample of the drive's own signals, at the sampling rate of the model. Returns whether
    /// [`Watch::collect`] has work.
    #[inline]
    pub fn sample(&self, sample: P::Sample) -> bool {
        self.inputs.with(|inputs| inputs.put(&self.link, Some((sample, false)))) == Some(true)
    }
}
