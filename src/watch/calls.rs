//! Start and stop, and the call of the current loop: with a front end, or with signals of the drive's own.

use super::inputs::{Inputs, StartError};
use super::link::count;
use super::slot::Content;
use super::source::{Sampled, Source};
use super::{Collector, Main, Watch, take};
use crate::drive::{Alignment, By, CleanSample, Factor, Faults, FrontEnd, FrontEndConstants, WiringCheck};
use crate::known_answers::known_answer_test;
use crate::model::Model;
use crate::plan::Plan;

impl<P: Plan, const FURTHER: usize, const FACTOR: usize> Watch<P, FrontEnd<FURTHER, FACTOR>>
where
    By<FACTOR>: Factor,
    P::Sample: From<CleanSample<FURTHER>>,
{
    /// Checks model, constants and arithmetic, and makes all parts. Call it before the interrupts run, or behind
    /// [`Watch::stop`]: another model and other constants need no reboot.
    ///
    /// # Errors
    /// What is wrong. Nothing runs then that did not run before, and a start with right ones may follow.
    pub fn start(&'static self, model: &'static Model<P>, constants: &FrontEndConstants) -> Result<(), StartError> {
        let front_end = FrontEnd::new(constants).map_err(StartError::FrontEnd)?;
        model.check_rotor_frame(front_end.frame()).map_err(StartError::Model)?;
        model.check_interval(FACTOR as f32 / constants.control_rate_hz).map_err(StartError::Model)?;
        known_answer_test().map_err(StartError::Arithmetic)?;
        self.start_around(model, front_end)
    }
}

impl<P: Plan> Watch<P> {
    /// Checks the arithmetic, and makes all parts. Call it before the interrupts run, or behind [`Watch::stop`].
    ///
    /// # Errors
    /// As with a front end.
    pub fn start(&'static self, model: &'static Model<P>) -> Result<(), StartError> {
        known_answer_test().map_err(StartError::Arithmetic)?;
        self.start_parts(model, (), None)
    }

    /// Takes a sample of the drive's own signals, at the sampling rate of the model. Returns whether
    /// [`Watch::collect`] has work.
    #[inline]
    pub fn sample(&self, sample: P::Sample) -> bool {
        self.sample_signals(sample)
    }
}

impl<P: Plan, F: Source> Watch<P, F>
where
    P::Sample: From<F::Clean>,
{
    /// As [`Watch::start`], around a front end that the caller has checked against the model
    /// ([`Model::check_rotor_frame`], [`Model::check_interval`]), where [`known_answer_test`] has passed.
    ///
    /// # Errors
    /// [`StartError::Started`].
    pub fn start_around(&'static self, model: &'static Model<P>, front_end: F) -> Result<(), StartError> {
        let faults = front_end.faults();
        self.start_parts(model, front_end, faults)
    }

    /// Takes what the current loop has read, at its rate. Returns whether [`Watch::collect`] has work: request its
    /// interrupt then.
    #[must_use = "the interrupt of `collect` is to be requested"]
    #[inline]
    pub fn sample(&self, reading: impl Into<F::Reading>) -> bool {
        let take = |inputs: &mut Inputs<P, F>| {
            let sampled = inputs.front_end.push(&reading.into());
            let due = self.link.counters.due();
            let first = inputs.told.is_none();
            if inputs.told != Some(due) {
                inputs.tell(&self.link, due);
            }
            let next = sampled.map(|Sampled { clean, found_late, alignment }| {
                self.link.tell_alignment(alignment);
                (clean.into(), found_late)
            });
            // The first call of the other context tests its arithmetic, long before the first clean sample.
            inputs.put(&self.link, next) || first
        };
        self.inputs.with(take) == Some(true)
    }

    /// Takes what the current loop has read at commissioning, for a check of the wiring instead of the detector. The
    /// velocity is one of the drive's own, rad/s, NaN if there is none. The times of [`Watch::clock`] count anew behind
    /// it.
    pub fn check_wiring(&self, reading: impl Into<F::Reading>, velocity_rad_s: f32, check: &mut WiringCheck) {
        self.inputs.with(|inputs| inputs.front_end.check_wiring(&reading.into(), velocity_rad_s, check));
        count(&self.link.counters.checked);
    }

    /// Counts what the front end refuses from zero, from the next reading on. In the main loop.
    pub fn clear_faults(&self) {
        count(&self.link.counters.cleared);
    }
}

impl<P: Plan, F> Watch<P, F> {
    /// Takes a sample of signals that the drive has itself, past the front end if there is one. Returns whether
    /// [`Watch::collect`] has work.
    #[inline]
    pub fn sample_signals(&self, sample: P::Sample) -> bool {
        self.inputs.with(|inputs| inputs.put(&self.link, Some((sample, false)))) == Some(true)
    }

    /// Makes all parts.
    fn start_parts(
        &'static self,
        model: &'static Model<P>,
        front_end: F,
        faults: Option<Faults>,
    ) -> Result<(), StartError> {
        let held = (self.inputs.hold(), self.collector.hold(), self.main.hold(), self.link.faults.hold());
        let (Some(mut inputs), Some(mut collector), Some(mut main), Some(mut told)) = held else {
            return Err(StartError::Started);
        };
        let [first, second] = self.places.take(model).ok_or(StartError::Started)?;
        self.link.restart(second, faults.map_or(Alignment::Unknown, |faults| faults.alignment));
        main.fill(|| Main::new(model));
        collector.fill(|| Collector::new(model, first));
        inputs.fill(|| Inputs::new(front_end));
        *told = faults.map_or(Content::Empty, Content::Full);
        Ok(())
    }

    /// Ends the diagnosis, so that [`Watch::start`] can follow with another model or other constants; what
    /// [`Watch::end_run`] writes is to be kept before. Call it in the main loop; the interrupts may go on, and find
    /// nothing to do. Returns `false`, and changes nothing, if another context is in a call.
    #[must_use = "it may not have stopped"]
    pub fn stop(&self) -> bool {
        let held = (self.inputs.hold(), self.collector.hold(), self.main.hold());
        let (Some(mut inputs), Some(mut collector), Some(mut main)) = held else { return false };
        inputs.take();
        let of_collector = collector.take().map_or([const { None }; 3], Collector::into_places);
        let of_main = main.take().map_or([None, None], |main| [main.waiting, main.returned]);
        // Only the two that are gone work on these.
        let between = [take(&self.link.closed), take(&self.link.spare)];
        for place in of_collector.into_iter().chain(of_main).chain(between).flatten() {
            self.places.give(place);
        }
        true
    }
}
