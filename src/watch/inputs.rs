//! The half of the current loop: readings in, clean samples into the queue.

use core::fmt;
use core::sync::atomic::Ordering;

use super::Watch;
use super::collector::{Queue, Queued, count};
use crate::drive::{By, CleanSample, Factor, FrontEnd, FrontEndConstants, FrontEndError, RawSample, WiringCheck};
use crate::known_answers::known_answer_test;
use crate::model::{Model, ModelError};
use crate::plan::Plan;
use crate::reason::Kernel;

/// What the current loop works on.
pub(super) struct Inputs<P: Plan, F> {
    front_end: F,
    /// A sample that the queue did not take yet.
    kept: Option<Queued<P>>,
    /// Samples that were lost since the last one of the queue, and whether one of them had a fault that was found late.
    missed: u16,
    found_late: bool,
    /// Closed segments when the main loop was told the faults; none is told at first.
    told: Option<u32>,
}

/// Why a [`Watch`] did not start.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StartError {
    /// The chip computes otherwise than the host of the training.
    Arithmetic(Kernel),
    /// A constant of the front end is out of range.
    FrontEnd(FrontEndError),
    /// The model was trained with another front end.
    Model(ModelError),
    /// It runs already.
    Started,
}

impl StartError {
    /// What is wrong, in words.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Arithmetic(kernel) => kernel.message(),
            Self::FrontEnd(error) => error.message(),
            Self::Model(error) => error.message(),
            Self::Started => "the watch runs already",
        }
    }
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for StartError {}

impl<P: Plan, F> Inputs<P, F> {
    const fn new(front_end: F) -> Self {
        Self { front_end, kept: None, missed: 0, found_late: false, told: None }
    }

    /// Puts a sample into the queue, behind the one that was kept; keeps it if the queue is full, or if the other
    /// context holds the lock. Returns whether samples wait.
    #[inline(always)]
    fn put(&mut self, watch: &Watch<P, F>, sample: Option<(P::Sample, bool)>) -> bool {
        if self.kept.is_none() && sample.is_none() {
            return false;
        }
        let mut queue = watch.queue.try_lock();
        let mut queue = queue.as_deref_mut();
        send(&mut self.kept, &mut queue);
        if let Some((sample, found_late)) = sample {
            if self.kept.is_some() {
                self.lose(watch);
            }
            let found_late = core::mem::take(&mut self.found_late) || found_late;
            self.kept = Some(Queued { sample, found_late, missed: core::mem::take(&mut self.missed) });
            send(&mut self.kept, &mut queue);
        }
        queue.is_some_and(|queue| !queue.is_empty())
    }

    /// Drops the sample that was kept; the next one tells of it.
    #[cold]
    #[inline(never)]
    fn lose(&mut self, watch: &Watch<P, F>) {
        if let Some(Queued { missed, found_late, .. }) = self.kept.take() {
            (self.missed, self.found_late) = (missed.saturating_add(1), found_late);
            count(&watch.counters.lost_samples);
        }
    }
}

/// Moves a sample into the queue if there is room.
#[inline(always)]
fn send<P: Plan>(kept: &mut Option<Queued<P>>, queue: &mut Option<&mut Queue<P>>) {
    if let Some(queue) = queue
        && !queue.is_full()
        && let Some(queued) = kept.take()
    {
        let _room = queue.push_back(queued).is_ok();
    }
}

impl<P: Plan, const FURTHER: usize, const FACTOR: usize> Inputs<P, FrontEnd<FURTHER, FACTOR>>
where
    By<FACTOR>: Factor,
{
    /// Tells the main loop the faults, once a segment.
    #[cold]
    #[inline(never)]
    fn tell(&mut self, watch: &Watch<P, FrontEnd<FURTHER, FACTOR>>, closed: u32) {
        watch.faults.with(|faults| *faults = self.front_end.faults());
        self.told = Some(closed);
    }
}

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
        let filled = self.faults.fill(|| front_end.faults()) && self.inputs.fill(|| Inputs::new(front_end));
        if filled { Ok(()) } else { Err(StartError::Started) }
    }

    /// Takes what the current loop has read, at its rate. Returns whether [`Watch::collect`] has work: request its
    /// interrupt then.
    #[inline]
    pub fn sample(&self, reading: impl Into<RawSample<FURTHER>>) -> bool {
        let take = |inputs: &mut Inputs<P, FrontEnd<FURTHER, FACTOR>>| {
            let clean = inputs.front_end.push(&reading.into());
            let closed = self.counters.closed.load(Ordering::Relaxed);
            let first = inputs.told.is_none();
            if inputs.told != Some(closed) {
                inputs.tell(self, closed);
            }
            let late = clean.is_some_and(|clean| clean.found_late);
            // The first call of the other context tests its arithmetic, long before the first clean sample.
            inputs.put(self, clean.map(|clean| (clean.into(), late))) || first
        };
        self.inputs.with(take) == Some(true)
    }

    /// Takes what the current loop has read at commissioning, for a check of the wiring instead of the detector. The
    /// velocity is one of the drive's own, rad/s, NaN if there is none.
    pub fn check_wiring(&self, reading: impl Into<RawSample<FURTHER>>, velocity_rad_s: f32, check: &mut WiringCheck) {
        self.inputs.with(|inputs| inputs.front_end.check_wiring(&reading.into(), velocity_rad_s, check));
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
        if self.inputs.fill(|| Inputs::new(())) { Ok(()) } else { Err(StartError::Started) }
    }

    /// Takes a sample of the drive's own signals, at the sampling rate of the model. Returns whether
    /// [`Watch::collect`] has work.
    #[inline]
    pub fn sample(&self, sample: P::Sample) -> bool {
        self.inputs.with(|inputs| inputs.put(self, Some((sample, false)))) == Some(true)
    }
}
