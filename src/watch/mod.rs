//! One object for a drive: front end, detector and monitor in a static, for the three contexts of a firmware.
//!
//! ```text
//! current loop, highest priority        Watch::sample    counts ─► front end ─► queue
//! interrupt below it, or the same one   Watch::collect   queue ─► detector ─► closed segment
//! main loop                             Watch::advance   segment ─► report, alarm
//! ```
//!
//! Each context works on parts of its own, behind locks that never wait: a call that finds one taken, because it has
//! interrupted the other, leaves its work to the next call. Nothing is masked. A sample is lost only if the queue of
//! [`QUEUE`] samples is full, a segment only if the main loop has not taken the one before; both are counted, and the
//! detector treats lost samples as missing ones.

mod calls;
mod clock;
mod collector;
mod inputs;
mod link;
mod places;
mod slot;
mod source;
#[cfg(test)]
mod tests;

pub use clock::Lapse;
pub use inputs::StartError;
pub use link::QUEUE;
pub use source::{Sampled, Source};

use core::fmt;
use core::sync::atomic::{AtomicU32, Ordering};

use crate::alarm::StateError;
use crate::detector::{Conclusion, Monitor};
use crate::drive::{Alignment, Faults};
use crate::model::Model;
use crate::plan::Plan;
use crate::reason::ArithmeticFault;
use crate::report::Verdict;
use crate::signal::{Liveness, LivenessLimits, RateCheck};
use collector::Collector;
use inputs::Inputs;
use link::{Counters, Link};
use places::{Place, Places};
use slot::{Slot, take};

/// Front end, detector and monitor of one drive. `train --rust` declares it as `WATCH`, with `F` the front end, or `()`
/// for a drive that has quadrature current and velocity itself.
///
/// ```
/// # mod model { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/support/standard_rig/model.rs")); }
/// use bearing_watch::watch::Watch;
/// use model::{Drive, MODEL, Sample};
///
/// static WATCH: Watch<Drive> = Watch::new(); // `train` writes this line
///
/// WATCH.start(&MODEL)?;
/// for k in 0..10_000 {
///     // In the sampling interrupt:
///     let t = 0.002 * k as f32;
///     WATCH.sample(Sample { current_a: t.sin(), velocity_ref_rad_s: 40.0 * t.cos(), load_torque_nm: 0.1 });
///     // There, or at a lower priority:
///     WATCH.collect();
///     // In the main loop:
///     WATCH.advance(|now| println!("{:?}, alarm: {}", now.report.verdict, now.alarm.is_some()));
/// }
/// # Ok::<(), bearing_watch::watch::StartError>(())
/// ```
pub struct Watch<P: Plan, F: 'static = ()> {
    inputs: Slot<Inputs<P, F>>,
    link: Link<P>,
    places: Places<P>,
    collector: Slot<Collector<P>>,
    main: Slot<Main<P>>,
}

/// What the main loop works on.
struct Main<P: Plan> {
    monitor: Monitor<'static, P>,
    rate: RateCheck,
    /// Whether the last window of the rate was right.
    right_rate: bool,
    /// Whether the clock was read.
    on_trial: bool,
    liveness: Liveness,
    /// Segments with a verdict, with wrap-around.
    verdicts: u32,
    /// Readings that the check of the wiring had when the clock was read last.
    checked: u32,
    /// Whether a report that was given before is withdrawn, and `advance` has not said it yet.
    withdrawn: bool,
    /// A closed segment that is to be solved next.
    waiting: Option<Place<P>>,
    /// A place that the interrupt did not get yet.
    returned: Option<Place<P>>,
}

impl<P: Plan> Main<P> {
    fn new(model: &'static Model<P>) -> Self {
        let sampling = &model.constants().sampling;
        Self {
            monitor: Monitor::new(model),
            rate: RateCheck::of_milliseconds(sampling.interval_s),
            right_rate: true,
            on_trial: false,
            liveness: Liveness::new(LivenessLimits::of_segments(sampling.segment_s())),
            verdicts: 0,
            checked: 0,
            withdrawn: false,
            waiting: None,
            returned: None,
        }
    }
}

/// What a firmware can tell beside verdicts and alarms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// What the front end has refused, as of the end of the last segment; `None` without a front end.
    pub faults: Option<Faults>,
    /// Whether the currents turn with the rotor: no segment has a verdict while this is not decided, and where they do
    /// not. [`Alignment::Unknown`]: it is not checked.
    pub alignment: Alignment,
    /// What the context of [`Watch::collect`] computes otherwise than the host of the training.
    pub failed: Option<ArithmeticFault>,
    /// Samples that the detector took, with wrap-around.
    pub rows: u32,
    /// Samples that were lost because [`Watch::collect`] came too late.
    pub lost_samples: u32,
    /// Segments that were lost because [`Watch::advance`] came too late.
    pub lost_segments: u32,
}

impl<P: Plan, F> Watch<P, F> {
    /// Nothing started; all bytes are zero, so that it takes no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            inputs: Slot::new(),
            link: Link::new(),
            places: Places::new(),
            collector: Slot::new(),
            main: Slot::new(),
        }
    }

    /// Takes the samples that wait, at a lower priority than the current loop, or behind [`Watch::sample`] in the same
    /// interrupt. Returns whether a segment has closed, for a main loop that sleeps. The first call tests the
    /// arithmetic of its context ([`known_answer_test`](crate::known_answer_test)), in some hundred thousand
    /// instructions: an interrupt has settings of the processor of its own. If it fails, no segment has a verdict, and
    /// [`Status::failed`] says why.
    pub fn collect(&self) -> bool {
        self.collect_with(|_, _| ())
    }

    /// As [`Watch::collect`], and shows each sample that the detector takes, with the number of those that were lost
    /// before it: for a recorder of the telemetry, or another use of clean samples.
    pub fn collect_with(&self, show: impl FnMut(&P::Sample, u16)) -> bool {
        let closed = self.collector.with(|collector| collector.run(&self.link, show));
        closed == Some(true)
    }

    /// One step of the main loop, of bounded cost: solves a closed segment, and gives its report and alarm to `tell`
    /// at the end. It also gives the last report again if that is withdrawn: [`Conclusion::withdrawn`]. Returns what
    /// `tell` returns.
    pub fn advance<R>(&self, tell: impl FnOnce(Conclusion<'_, P>) -> R) -> Option<R> {
        self.main.with(|main| self.step(main, tell)).flatten()
    }

    fn step<R>(&self, main: &mut Main<P>, tell: impl FnOnce(Conclusion<'_, P>) -> R) -> Option<R> {
        if !main.monitor.is_solving() && main.waiting.is_none() {
            main.waiting = take(&self.link.closed);
        }
        self.settle(main);
        if core::mem::take(&mut main.withdrawn)
            && let Some(now) = main.monitor.withdrawn()
        {
            return Some(tell(now));
        }
        if let Some(place) = main.returned.take() {
            main.returned = self.give(place);
        }
        if !main.monitor.is_solving() {
            let place = main.waiting.take()?;
            main.monitor.take_from(place);
            main.returned = self.give(place);
            return None;
        }
        let now = main.monitor.advance()?;
        main.verdicts = main.verdicts.wrapping_add(u32::from(!matches!(now.report.verdict, Verdict::Undetermined(_))));
        // For instrumental variables.
        self.collector.with(|collector| collector.detector.adopt(now.report));
        Some(tell(now))
    }

    /// Gives a place back to the interrupt; returns it if that holds the lock.
    fn give(&self, place: Place<P>) -> Option<Place<P>> {
        match self.link.spare.try_lock() {
            Some(mut spare) => spare.replace(place),
            None => Some(place),
        }
    }

    /// Withdraws a report that a fault has put in doubt, and gives no verdict before the wiring is known.
    fn settle(&self, main: &mut Main<P>) {
        main.monitor.tell_alignment(self.link.alignment());
        let doubted = self.link.counters.doubted.load(Ordering::Relaxed).wrapping_sub(1);
        // The next segment says it too, if the main loop has missed the number.
        let next = main.waiting.as_deref();
        main.withdrawn |= main.monitor.withdraw(doubted) || main.monitor.withdraw_before(next);
    }

    /// Works on the monitor in the main loop: alarm, evidence, limits of silence. `None` before the start.
    pub fn monitor<R>(&self, work: impl FnOnce(&mut Monitor<'static, P>) -> R) -> Option<R> {
        self.main.with(|main| {
            self.settle(main);
            work(&mut main.monitor)
        })
    }

    /// Ends a run, at power-down, and writes evidence and alarm into `buffer`; returns the number of bytes.
    /// [`Watch::restore`] continues from them after the next start.
    ///
    /// # Errors
    /// [`StateError::Unavailable`] before the start, and [`StateError::BufferTooSmall`].
    pub fn end_run(&self, buffer: &mut [u8]) -> Result<usize, StateError> {
        let end = |monitor: &mut Monitor<'static, P>| {
            monitor.end_run();
            monitor.save(buffer)
        };
        self.monitor(end).unwrap_or(Err(StateError::Unavailable))
    }

    /// Continues from the bytes of an earlier run.
    ///
    /// # Errors
    /// Bytes that are damaged or of another model.
    pub fn restore(&self, bytes: &[u8]) -> Result<(), StateError> {
        self.monitor(|monitor| monitor.restore(bytes)).unwrap_or(Err(StateError::Unavailable))
    }

    /// Starts afresh where samples do not continue from the last one, as after a pause of the interrupt: samples that
    /// wait are dropped. Call it while that is stopped. Returns `false` if [`Watch::collect`] runs.
    #[must_use = "it may not have started afresh"]
    pub fn restart(&self) -> bool {
        self.main.with(|main| {
            main.rate.restart();
            main.liveness.restart();
        });
        self.inputs.with(Inputs::restart);
        let cleared = self.link.queue.try_lock().map(|mut queue| queue.clear()).is_some();
        cleared && self.collector.with(|collector| collector.detector.restart()).is_some()
    }

    /// Starts afresh as after a repair: open and closed segment, report, alarm and scores. Call it in the main loop
    /// while the interrupts are stopped. Returns `false` if another context is in a call: it is to be called again.
    #[must_use = "it may not have started afresh"]
    pub fn reset(&self) -> bool {
        let reset = |main: &mut Main<P>| {
            main.monitor.reset();
            for place in [main.waiting.take(), take(&self.link.closed)].into_iter().flatten() {
                // One of two places is open in the detector: the other one is here or there.
                main.returned = self.give(place);
            }
        };
        let is_reset = self.main.with(reset).is_some() && self.collector.with(Collector::forget_closed).is_some();
        is_reset && self.restart()
    }

    /// What was lost or refused.
    pub fn status(&self) -> Status {
        let of = |counter: &AtomicU32| counter.load(Ordering::Relaxed);
        let Counters { rows, lost_samples, lost_segments, .. } = &self.link.counters;
        Status {
            faults: self.link.faults.with(|faults| *faults),
            alignment: self.link.alignment(),
            failed: self.collector.with(|collector| collector.failed()).flatten(),
            rows: of(rows),
            lost_samples: of(lost_samples),
            lost_segments: of(lost_segments),
        }
    }
}

impl<P: Plan, F> Default for Watch<P, F> {
    fn default() -> Self {
        Self::new()
    }
}

impl<P: Plan, F> fmt::Debug for Watch<P, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").field("status", &self.status()).finish_non_exhaustive()
    }
}
